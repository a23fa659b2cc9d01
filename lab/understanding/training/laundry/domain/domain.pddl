; A laundry robot: it carries washing and tools, runs machines, irons, folds and treats stains.
(define (domain laundry)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing temperature)

  (:predicates
    (person ?spot - spot)
    (machine ?spot - spot)
    (board ?spot - spot)                    ; a place for ironing
    (cloth ?item - item)
    (presser ?item - item)                  ; an iron, a steamer
    (agent ?item - item)                    ; a substance for cloth
    (robot-at ?spot - spot)
    (at ?item - item ?spot - spot)
    (holding ?item - item)
    (running ?spot - spot)
    (folded ?item - item)
    ; what happened
    (cycled ?item - item ?machine - spot)
    (cycled-at ?item - item ?machine - spot ?temperature - temperature)
    (pressed ?item - item ?tool - item)
    (treated ?item - item ?agent - item))

  (:action go
    :parameters (?to - spot)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to)))

  (:action take
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (at ?item ?from) (not (running ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action leave
    :parameters (?item - item ?to - spot)
    :precondition (and (holding ?item) (robot-at ?to) (not (running ?to)))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action start
    :parameters (?machine - spot)
    :precondition (and (machine ?machine) (robot-at ?machine) (not (running ?machine)))
    :effect (running ?machine))

  (:action stop
    :parameters (?machine - spot)
    :precondition (and (machine ?machine) (robot-at ?machine) (running ?machine))
    :effect (not (running ?machine)))

  (:action cycle
    :parameters (?item - item ?machine - spot)
    :precondition (and (machine ?machine) (cloth ?item) (at ?item ?machine) (robot-at ?machine)
                       (not (running ?machine)))
    :effect (and (cycled ?item ?machine) (not (folded ?item))))

  (:action cycle-at
    :parameters (?item - item ?machine - spot ?temperature - temperature)
    :precondition (and (machine ?machine) (cloth ?item) (at ?item ?machine) (robot-at ?machine)
                       (not (running ?machine)))
    :effect (and (cycled ?item ?machine) (cycled-at ?item ?machine ?temperature) (not (folded ?item))))

  (:action press
    :parameters (?item - item ?tool - item ?board - spot)
    :precondition (and (board ?board) (robot-at ?board) (cloth ?item) (at ?item ?board)
                       (presser ?tool) (holding ?tool))
    :effect (pressed ?item ?tool))

  (:action treat
    :parameters (?item - item ?agent - item ?spot - spot)
    :precondition (and (robot-at ?spot) (cloth ?item) (at ?item ?spot) (not (running ?spot))
                       (agent ?agent) (holding ?agent))
    :effect (treated ?item ?agent))

  (:action fold
    :parameters (?item - item)
    :precondition (and (cloth ?item) (holding ?item) (not (folded ?item)))
    :effect (folded ?item)))
