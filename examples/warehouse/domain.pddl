; A warehouse robot that carries pallets and boxes between bays, docks, conveyors and a wrapping table.
(define (domain warehouse)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality :numeric-fluents)

  (:types place load - thing)

  (:predicates
    (conveyor ?place - place)
    (charger ?place - place)
    (wrapper ?place - place)
    (fragile ?load - load)
    (blocked ?place - place)
    (robot-at ?place - place)
    (at ?load - load ?place - place)
    (carrying ?load - load)
    (running ?place - place)
    (wrapped ?load - load)
    ; outcomes of an inspection
    (damaged ?load - load)
    (intact ?load - load)
    ; what happened
    (scanned ?load - load)
    (charged))

  (:functions (battery))                       ; percent

  ; A drive takes 2 percent of the battery, a charge adds 20.
  (:action drive
    :parameters (?to - place)
    :precondition (and (not (robot-at ?to)) (not (blocked ?to)) (>= (battery) 2))
    :effect (and (decrease (battery) 2) (forall (?from - place) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?load - load ?from - place)
    :precondition (and (robot-at ?from) (at ?load ?from)
                       (forall (?other - load) (not (carrying ?other))))
    :effect (and (carrying ?load) (not (at ?load ?from))))

  ; Nothing fragile goes onto a conveyor, and nothing at all onto one that runs.
  (:action lower
    :parameters (?load - load ?to - place)
    :precondition (and (robot-at ?to) (carrying ?load)
                       (imply (conveyor ?to) (and (not (fragile ?load)) (not (running ?to)))))
    :effect (and (at ?load ?to) (not (carrying ?load))))

  (:action wrap
    :parameters (?load - load ?place - place)
    :precondition (and (wrapper ?place) (robot-at ?place) (at ?load ?place) (not (wrapped ?load)))
    :effect (wrapped ?load))

  (:action scan
    :parameters (?load - load)
    :precondition (or (carrying ?load)
                      (exists (?place - place) (and (robot-at ?place) (at ?load ?place))))
    :effect (scanned ?load))

  (:action inspect
    :parameters (?load - load)
    :precondition (exists (?place - place) (and (robot-at ?place) (at ?load ?place)))
    :effect (and))

  (:action start-conveyor
    :parameters (?place - place)
    :precondition (and (conveyor ?place) (robot-at ?place) (not (running ?place)))
    :effect (running ?place))

  (:action stop-conveyor
    :parameters (?place - place)
    :precondition (and (conveyor ?place) (robot-at ?place) (running ?place))
    :effect (not (running ?place)))

  (:action charge
    :parameters (?place - place)
    :precondition (and (charger ?place) (robot-at ?place) (<= (battery) 80))
    :effect (and (charged) (increase (battery) 20))))
