; A robot on a grid with locked cells and keys of several shapes; it carries one key.
(define (domain keys)
  (:requirements :strips :typing :negative-preconditions)
  (:types cell key shape - object)
  (:predicates
    (next-to ?cell - cell ?other - cell)
    (lock ?cell - cell ?shape - shape)
    (fits ?key - key ?shape - shape)
    (locked ?cell - cell)
    (at ?cell - cell)
    (lies ?key - key ?cell - cell)
    (carrying ?key - key)
    (hand-free))
  (:action walk
    :parameters (?from - cell ?to - cell)
    :precondition (and (at ?from) (next-to ?from ?to) (not (locked ?to)))
    :effect (and (not (at ?from)) (at ?to)))
  (:action pick
    :parameters (?key - key ?cell - cell)
    :precondition (and (at ?cell) (lies ?key ?cell) (hand-free))
    :effect (and (carrying ?key) (not (lies ?key ?cell)) (not (hand-free))))
  (:action drop
    :parameters (?key - key ?cell - cell)
    :precondition (and (at ?cell) (carrying ?key))
    :effect (and (lies ?key ?cell) (hand-free) (not (carrying ?key))))
  (:action unlock
    :parameters (?from - cell ?to - cell ?key - key ?shape - shape)
    :precondition (and (at ?from) (next-to ?from ?to) (locked ?to) (lock ?to ?shape) (fits ?key ?shape) (carrying ?key))
    :effect (not (locked ?to))))
