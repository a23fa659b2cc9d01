; Blocks on a table, moved by one hand.
(define (domain blocks)
  (:requirements :strips :typing)
  (:types block - object)
  (:predicates
    (on ?block - block ?below - block)
    (on-table ?block - block)
    (clear ?block - block)
    (holding ?block - block)
    (hand-empty))
  (:action pick-up
    :parameters (?block - block)
    :precondition (and (clear ?block) (on-table ?block) (hand-empty))
    :effect (and (holding ?block) (not (clear ?block)) (not (on-table ?block)) (not (hand-empty))))
  (:action put-down
    :parameters (?block - block)
    :precondition (holding ?block)
    :effect (and (not (holding ?block)) (clear ?block) (on-table ?block) (hand-empty)))
  (:action stack
    :parameters (?block - block ?below - block)
    :precondition (and (holding ?block) (clear ?below))
    :effect (and (not (holding ?block)) (not (clear ?below)) (clear ?block) (hand-empty) (on ?block ?below)))
  (:action unstack
    :parameters (?block - block ?below - block)
    :precondition (and (on ?block ?below) (clear ?block) (hand-empty))
    :effect (and (holding ?block) (clear ?below) (not (clear ?block)) (not (hand-empty)) (not (on ?block ?below)))))
