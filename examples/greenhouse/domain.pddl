; A rail robot in a greenhouse that waters plants and opens vents.
(define (domain greenhouse)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types bed plant - thing)

  (:constants tank - bed)

  (:predicates
    (has-vent ?bed - bed)
    (grows-in ?plant - plant ?bed - bed)
    (robot-at ?bed - bed)
    (can-full)
    (vent-open ?bed - bed)
    (dry ?plant - plant)
    (watered ?plant - plant))

  (:action ride
    :parameters (?to - bed)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - bed) (not (robot-at ?from))) (robot-at ?to)))

  (:action fill
    :parameters ()
    :precondition (and (robot-at tank) (not (can-full)))
    :effect (can-full))

  ; One can of water serves every plant of a bed.
  (:action water
    :parameters (?bed - bed)
    :precondition (and (robot-at ?bed) (can-full) (exists (?plant - plant) (grows-in ?plant ?bed)))
    :effect (and (not (can-full))
                 (forall (?plant - plant)
                   (when (grows-in ?plant ?bed) (and (watered ?plant) (not (dry ?plant)))))))

  (:action open-vent
    :parameters (?bed - bed)
    :precondition (and (robot-at ?bed) (has-vent ?bed) (not (vent-open ?bed)))
    :effect (vent-open ?bed))

  (:action close-vent
    :parameters (?bed - bed)
    :precondition (and (robot-at ?bed) (vent-open ?bed))
    :effect (not (vent-open ?bed))))
