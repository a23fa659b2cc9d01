; A building site robot: it shifts material, mixes mortar, sets hoists and signals, minds gates and machines, sweeps,
; covers things up, and looks at material and at parts of the site before it decides what to do.
(define (domain buildingsite)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types zone load - object volume height)

  (:predicates
    (worker ?zone - zone)
    (engine ?zone - zone)
    (mixer ?zone - zone)
    (hoist ?zone - zone)
    (gate ?zone - zone)
    (lamp ?zone - zone)
    (colour ?zone - zone)
    (area ?zone - zone)
    (material ?load - load)
    (sheet ?load - load)
    (robot-at ?zone - zone)
    (lies ?load - load ?zone - zone)
    (gripped ?load - load)
    (on ?zone - zone)
    (open ?zone - zone)
    (high ?zone - zone ?height - height)
    (shows ?zone - zone ?colour - zone)
    ; what only a look tells
    (dry ?load - load)
    (damp ?load - load)
    (broken ?load - load)
    (occupied ?zone - zone)
    (deserted ?zone - zone)
    ; what happened
    (mixed ?zone - zone ?volume - volume)
    (swept ?zone - zone)
    (covered ?load - load ?sheet - load)
    (summoned ?zone - zone))

  (:action drive
    :parameters (?zone - zone)
    :precondition (and (not (robot-at ?zone)) (not (colour ?zone)))
    :effect (and (forall (?from - zone) (not (robot-at ?from))) (robot-at ?zone)))

  (:action lift
    :parameters (?load - load ?zone - zone)
    :precondition (and (robot-at ?zone) (lies ?load ?zone)
                       (forall (?other - load) (not (gripped ?other))))
    :effect (and (gripped ?load) (not (lies ?load ?zone))))

  (:action lower
    :parameters (?load - load ?zone - zone)
    :precondition (and (gripped ?load) (robot-at ?zone))
    :effect (and (lies ?load ?zone) (not (gripped ?load))))

  (:action power-up
    :parameters (?zone - zone)
    :precondition (and (engine ?zone) (robot-at ?zone) (not (on ?zone)))
    :effect (on ?zone))

  (:action power-down
    :parameters (?zone - zone)
    :precondition (and (engine ?zone) (robot-at ?zone) (on ?zone))
    :effect (not (on ?zone)))

  (:action unbar
    :parameters (?zone - zone)
    :precondition (and (gate ?zone) (robot-at ?zone) (not (open ?zone)))
    :effect (open ?zone))

  (:action bar
    :parameters (?zone - zone)
    :precondition (and (gate ?zone) (robot-at ?zone) (open ?zone))
    :effect (not (open ?zone)))

  (:action mix
    :parameters (?zone - zone ?volume - volume)
    :precondition (and (mixer ?zone) (robot-at ?zone))
    :effect (mixed ?zone ?volume))

  (:action crank
    :parameters (?zone - zone ?height - height)
    :precondition (and (hoist ?zone) (robot-at ?zone) (not (high ?zone ?height)))
    :effect (and (forall (?other - height) (not (high ?zone ?other))) (high ?zone ?height)))

  (:action change-light
    :parameters (?zone - zone ?colour - zone)
    :precondition (and (lamp ?zone) (colour ?colour) (robot-at ?zone) (not (shows ?zone ?colour)))
    :effect (and (forall (?other - zone) (not (shows ?zone ?other))) (shows ?zone ?colour)))

  (:action sweep
    :parameters (?zone - zone)
    :precondition (and (area ?zone) (robot-at ?zone))
    :effect (swept ?zone))

  (:action drape
    :parameters (?load - load ?sheet - load ?zone - zone)
    :precondition (and (sheet ?sheet) (not (= ?load ?sheet)) (robot-at ?zone) (lies ?load ?zone))
    :effect (covered ?load ?sheet))

  (:action radio
    :parameters (?zone - zone)
    :precondition (worker ?zone)
    :effect (summoned ?zone))

  (:action feel
    :parameters (?load - load ?zone - zone)
    :precondition (and (material ?load) (robot-at ?zone) (lies ?load ?zone))
    :effect (and))

  (:action look-round
    :parameters (?zone - zone)
    :precondition (and (area ?zone) (robot-at ?zone))
    :effect (and)))
