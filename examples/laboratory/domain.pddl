; A bench robot with one gripper and a pipette: tubes, racks, a centrifuge with a lid, an incubator.
(define (domain laboratory)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality :numeric-fluents)

  (:types fixture vessel - thing speed duration)

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
    (speed-of ?fixture - fixture ?speed - speed)
    (timer-of ?fixture - fixture ?duration - duration)
    ; what happened
    (spun ?vessel - vessel)
    (spun-at ?vessel - vessel ?speed - speed)
    (spun-for ?vessel - vessel ?duration - duration)
    (incubated ?vessel - vessel)
    (incubated-for ?vessel - vessel ?duration - duration)
    (shaken ?vessel - vessel)
    (transferred ?from - vessel ?to - vessel))

  (:functions
    (volume ?vessel - vessel))                   ; in microlitres

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

  ; One stroke of the pipette is 50 ul.
  (:action pipette
    :parameters (?from - vessel ?to - vessel)
    :precondition (and (filled ?from) (not (= ?from ?to)) (>= (volume ?from) 50) (not (capped ?from)) (not (capped ?to))
                       (forall (?other - vessel) (not (holding ?other)))
                       (exists (?rack - fixture) (and (rack ?rack) (in ?from ?rack)))
                       (exists (?rack - fixture) (and (rack ?rack) (in ?to ?rack))))
    :effect (and (transferred ?from ?to) (filled ?to)
                 (decrease (volume ?from) 50) (increase (volume ?to) 50)))

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

  (:action set-speed
    :parameters (?fixture - fixture ?speed - speed)
    :precondition (and (centrifuge ?fixture) (not (speed-of ?fixture ?speed)))
    :effect (and (forall (?other - speed) (not (speed-of ?fixture ?other))) (speed-of ?fixture ?speed)))

  (:action set-timer
    :parameters (?fixture - fixture ?duration - duration)
    :precondition (and (or (centrifuge ?fixture) (incubator ?fixture)) (not (timer-of ?fixture ?duration)))
    :effect (and (forall (?other - duration) (not (timer-of ?fixture ?other))) (timer-of ?fixture ?duration)))

  ; Spins everything that is in the centrifuge; an open tube would spill.
  (:action spin
    :parameters (?fixture - fixture)
    :precondition (and (centrifuge ?fixture) (not (lid-open ?fixture))
                       (exists (?vessel - vessel) (in ?vessel ?fixture))
                       (forall (?vessel - vessel) (imply (in ?vessel ?fixture) (capped ?vessel))))
    :effect (and (forall (?vessel - vessel) (when (in ?vessel ?fixture) (spun ?vessel)))
                 (forall (?vessel - vessel ?speed - speed)
                   (when (and (in ?vessel ?fixture) (speed-of ?fixture ?speed)) (spun-at ?vessel ?speed)))
                 (forall (?vessel - vessel ?duration - duration)
                   (when (and (in ?vessel ?fixture) (timer-of ?fixture ?duration)) (spun-for ?vessel ?duration)))))

  (:action incubate
    :parameters (?fixture - fixture)
    :precondition (and (incubator ?fixture) (exists (?vessel - vessel) (in ?vessel ?fixture)))
    :effect (and (forall (?vessel - vessel) (when (in ?vessel ?fixture) (incubated ?vessel)))
                 (forall (?vessel - vessel ?duration - duration)
                   (when (and (in ?vessel ?fixture) (timer-of ?fixture ?duration)) (incubated-for ?vessel ?duration))))))
