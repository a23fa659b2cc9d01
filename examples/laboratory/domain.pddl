; A bench robot with one gripper and a pipette: tubes, racks, a centrifuge with a lid, an incubator.
(define (domain laboratory)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types fixture vessel - thing)

  (:predicates
    ; fixtures never change their kind
    (rack ?fixture - fixture)
    (centrifuge ?fixture - fixture)
    (incubator ?fixture - fixture)
    (waste ?fixture - fixture)
    (in ?vessel - vessel ?fixture - fixture)
    (holding ?vessel - vessel)
    (capped ?vessel - vessel)
    (filled ?vessel - vessel)
    (lid-open ?fixture - fixture)
    ; what happened
    (spun ?vessel - vessel)
    (incubated ?vessel - vessel)
    (shaken ?vessel - vessel)
    (transferred ?from - vessel ?to - vessel))

  (:action pick
    :parameters (?vessel - vessel ?from - fixture)
    :precondition (and (in ?vessel ?from) (not (waste ?from))
                       (forall (?other - vessel) (not (holding ?other)))
                       (imply (centrifuge ?from) (lid-open ?from)))
    :effect (and (holding ?vessel) (not (in ?vessel ?from))))

  (:action place
    :parameters (?vessel - vessel ?to - fixture)
    :precondition (and (holding ?vessel) (imply (centrifuge ?to) (lid-open ?to)))
    :effect (and (in ?vessel ?to) (not (holding ?vessel))))

  ; The capping tool reaches tubes that stand in a rack.
  (:action cap
    :parameters (?vessel - vessel)
    :precondition (and (not (capped ?vessel)) (forall (?other - vessel) (not (holding ?other)))
                       (exists (?rack - fixture) (and (rack ?rack) (in ?vessel ?rack))))
    :effect (capped ?vessel))

  (:action uncap
    :parameters (?vessel - vessel)
    :precondition (and (capped ?vessel) (forall (?other - vessel) (not (holding ?other)))
                       (exists (?rack - fixture) (and (rack ?rack) (in ?vessel ?rack))))
    :effect (not (capped ?vessel)))

  (:action shake
    :parameters (?vessel - vessel)
    :precondition (and (holding ?vessel) (capped ?vessel))
    :effect (shaken ?vessel))

  (:action pipette
    :parameters (?from - vessel ?to - vessel)
    :precondition (and (filled ?from) (not (= ?from ?to)) (not (capped ?from)) (not (capped ?to))
                       (forall (?other - vessel) (not (holding ?other)))
                       (exists (?rack - fixture) (and (rack ?rack) (in ?from ?rack)))
                       (exists (?rack - fixture) (and (rack ?rack) (in ?to ?rack))))
    :effect (and (transferred ?from ?to) (filled ?to)))

  (:action open-lid
    :parameters (?fixture - fixture)
    :precondition (and (centrifuge ?fixture) (not (lid-open ?fixture))
                       (forall (?other - vessel) (not (holding ?other))))
    :effect (lid-open ?fixture))

  (:action close-lid
    :parameters (?fixture - fixture)
    :precondition (and (centrifuge ?fixture) (lid-open ?fixture)
                       (forall (?other - vessel) (not (holding ?other))))
    :effect (not (lid-open ?fixture)))

  ; Spins everything that is in the centrifuge; an open tube would spill.
  (:action spin
    :parameters (?fixture - fixture)
    :precondition (and (centrifuge ?fixture) (not (lid-open ?fixture))
                       (exists (?vessel - vessel) (in ?vessel ?fixture))
                       (forall (?vessel - vessel) (imply (in ?vessel ?fixture) (capped ?vessel))))
    :effect (forall (?vessel - vessel) (when (in ?vessel ?fixture) (spun ?vessel))))

  (:action incubate
    :parameters (?fixture - fixture)
    :precondition (and (incubator ?fixture) (exists (?vessel - vessel) (in ?vessel ?fixture)))
    :effect (forall (?vessel - vessel) (when (in ?vessel ?fixture) (incubated ?vessel)))))
