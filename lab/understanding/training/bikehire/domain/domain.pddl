; A bicycle hire robot: it wheels bikes about, hands things out, pumps, washes, locks and mends, and looks at tyres, brakes
; and lamps before it decides. The three check actions change nothing; afterwards one of their outcomes is known.
(define (domain bikehire)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item - thing)

  (:predicates
    ; what never changes
    (spot ?place - place)                   ; things can be put there
    (lidded ?place - place)                 ; it opens
    (device ?place - place)
    (person ?place - place)
    (bike ?item - item)
    (pneumatic ?item - item)
    (brake ?item - item)
    (lamp ?item - item)
    (mounted ?item - item)                  ; part of a bike, cannot be carried
    (part-of ?item - item ?bike - item)
    ; where things are and how they are
    (near ?thing - thing)
    (at ?item - item ?place - place)
    (holding ?item - item)
    (open ?place - place)
    (running ?place - place)
    (locked ?bike - item)
    ; what only shows when the robot looks
    (firm ?item - item)
    (soft ?item - item)
    (flat ?item - item)
    (sound ?item - item)
    (worn ?item - item)
    (working ?item - item)
    (dead ?item - item)
    ; what happened
    (pumped ?item - item)
    (washed ?item - item)
    (replaced ?item - item)
    (reported ?item - item ?person - place))

  (:action go
    :parameters (?to - thing)
    :precondition (not (near ?to))
    :effect (and (forall (?from - thing) (not (near ?from))) (near ?to)))

  (:action take
    :parameters (?item - item ?from - place)
    :precondition (and (near ?item) (at ?item ?from) (not (mounted ?item)) (imply (lidded ?from) (open ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action put
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (near ?to) (or (spot ?to) (person ?to)) (imply (lidded ?to) (open ?to)))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action open-up
    :parameters (?place - place)
    :precondition (and (lidded ?place) (near ?place) (not (open ?place)))
    :effect (open ?place))

  (:action shut
    :parameters (?place - place)
    :precondition (and (lidded ?place) (near ?place) (open ?place))
    :effect (not (open ?place)))

  (:action switch-on
    :parameters (?place - place)
    :precondition (and (device ?place) (near ?place) (not (running ?place)))
    :effect (running ?place))

  (:action switch-off
    :parameters (?place - place)
    :precondition (and (device ?place) (near ?place) (running ?place))
    :effect (not (running ?place)))

  (:action lock
    :parameters (?bike - item)
    :precondition (and (bike ?bike) (near ?bike) (not (locked ?bike)))
    :effect (locked ?bike))

  (:action unlock
    :parameters (?bike - item)
    :precondition (and (bike ?bike) (near ?bike) (locked ?bike))
    :effect (not (locked ?bike)))

  (:action inflate
    :parameters (?item - item)
    :precondition (and (pneumatic ?item) (near ?item))
    :effect (pumped ?item))

  (:action wash
    :parameters (?item - item)
    :precondition (and (not (mounted ?item)) (near ?item))
    :effect (washed ?item))

  (:action replace
    :parameters (?item - item)
    :precondition (and (or (brake ?item) (lamp ?item) (and (pneumatic ?item) (mounted ?item))) (near ?item))
    :effect (replaced ?item))

  (:action report
    :parameters (?item - item ?person - place)
    :precondition (and (person ?person) (near ?person))
    :effect (reported ?item ?person))

  (:action check-pressure
    :parameters (?item - item)
    :precondition (and (pneumatic ?item) (near ?item))
    :effect (and))

  (:action check-brake
    :parameters (?item - item)
    :precondition (and (brake ?item) (near ?item))
    :effect (and))

  (:action check-lamp
    :parameters (?item - item)
    :precondition (and (lamp ?item) (near ?item))
    :effect (and)))
