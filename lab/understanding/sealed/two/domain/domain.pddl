; A robot in a monastery: it carries things, sweeps rooms, waters plants, lights and puts out lights, locks doors, rings bells and tells people about things.
(define (domain monastery)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item - thing strokes)

  (:predicates
    ; what never changes
    (room ?place - place)                   ; has a floor to sweep
    (door ?place - place)                   ; has a lock
    (lamp ?place - place)                   ; candles too
    (bell ?place - place)
    (plant ?place - place)                  ; beds too
    (person ?place - place)
    ; where things are and how they are
    (robot-at ?place - place)
    (at ?item - item ?place - place)
    (holding ?item - item)
    (burning ?place - place)
    (locked ?place - place)
    ; what only shows when the robot feels the soil
    (moist ?plant - place)
    (dry ?plant - place)
    ; what happened
    (was-moist ?plant - place)
    (was-dry ?plant - place)
    (watered ?plant - place)
    (swept ?room - place)
    (rung ?bell - place ?strokes - strokes)
    (told ?person - place ?thing - thing))

  (:action go
    :parameters (?to - place)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - place) (not (robot-at ?from))) (robot-at ?to)))

  (:action take
    :parameters (?item - item ?from - place)
    :precondition (and (robot-at ?from) (at ?item ?from)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action leave
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action kindle
    :parameters (?lamp - place)
    :precondition (and (lamp ?lamp) (robot-at ?lamp) (not (burning ?lamp)))
    :effect (burning ?lamp))

  (:action douse
    :parameters (?lamp - place)
    :precondition (and (lamp ?lamp) (robot-at ?lamp) (burning ?lamp))
    :effect (not (burning ?lamp)))

  (:action lock
    :parameters (?door - place)
    :precondition (and (door ?door) (robot-at ?door) (not (locked ?door)))
    :effect (locked ?door))

  (:action unlock
    :parameters (?door - place)
    :precondition (and (door ?door) (robot-at ?door) (locked ?door))
    :effect (not (locked ?door)))

  (:action ring
    :parameters (?bell - place ?strokes - strokes)
    :precondition (and (bell ?bell) (robot-at ?bell))
    :effect (rung ?bell ?strokes))

  ; How moist the soil is afterwards, only another touch can tell.
  (:action water
    :parameters (?plant - place)
    :precondition (and (plant ?plant) (robot-at ?plant))
    :effect (and (watered ?plant)
                 (when (moist ?plant) (was-moist ?plant))
                 (when (dry ?plant) (was-dry ?plant))
                 (not (moist ?plant)) (not (dry ?plant))))

  (:action sweep
    :parameters (?room - place)
    :precondition (and (room ?room) (robot-at ?room))
    :effect (swept ?room))

  (:action tell
    :parameters (?person - place ?thing - thing)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (told ?person ?thing))

  (:action feel-soil
    :parameters (?plant - place)
    :precondition (and (plant ?plant) (robot-at ?plant))
    :effect (and)))
