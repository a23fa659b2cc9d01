; A museum robot: it guides visitors, explains exhibits, opens and locks display cases, switches lights and alarms, dusts exhibits.
(define (domain museum)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing brightness)

  (:predicates
    (lockable ?spot - spot)                 ; a display case, a door, a gate
    (case ?spot - spot)                     ; things lie behind its glass
    (device ?spot - spot)
    (lamp ?spot - spot)
    (person ?item - item)                   ; walks where the robot leads
    (exhibit ?item - item)
    (tool ?item - item)
    (robot-at ?spot - spot)
    (at ?item - item ?spot - spot)
    (holding ?item - item)
    (has ?visitor - item ?item - item)
    (on ?spot - spot)
    (open ?spot - spot)
    (locked ?spot - spot)
    (shines ?spot - spot ?brightness - brightness)
    ; what happened
    (dusted ?item - item ?tool - item)
    (explained ?item - item ?visitor - item))

  (:action go
    :parameters (?to - spot)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to)))

  (:action lead
    :parameters (?visitor - item ?from - spot ?to - spot)
    :precondition (and (person ?visitor) (robot-at ?from) (at ?visitor ?from) (not (= ?from ?to)))
    :effect (and (not (robot-at ?from)) (robot-at ?to) (not (at ?visitor ?from)) (at ?visitor ?to)))

  (:action take
    :parameters (?item - item ?from - spot)
    :precondition (and (not (person ?item)) (robot-at ?from) (at ?item ?from) (imply (case ?from) (open ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action put-down
    :parameters (?item - item ?to - spot)
    :precondition (and (holding ?item) (robot-at ?to) (imply (case ?to) (open ?to)))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action hand-over
    :parameters (?item - item ?visitor - item ?spot - spot)
    :precondition (and (person ?visitor) (holding ?item) (robot-at ?spot) (at ?visitor ?spot))
    :effect (and (has ?visitor ?item) (not (holding ?item))))

  (:action collect
    :parameters (?item - item ?visitor - item ?spot - spot)
    :precondition (and (has ?visitor ?item) (robot-at ?spot) (at ?visitor ?spot)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (has ?visitor ?item))))

  (:action dust
    :parameters (?tool - item ?item - item ?spot - spot)
    :precondition (and (tool ?tool) (exhibit ?item) (holding ?tool) (robot-at ?spot) (at ?item ?spot)
                       (imply (case ?spot) (open ?spot)))
    :effect (dusted ?item ?tool))

  (:action explain
    :parameters (?item - item ?visitor - item ?spot - spot)
    :precondition (and (exhibit ?item) (person ?visitor) (robot-at ?spot) (at ?visitor ?spot))
    :effect (explained ?item ?visitor))

  (:action switch-on
    :parameters (?device - spot)
    :precondition (and (device ?device) (robot-at ?device) (not (on ?device)))
    :effect (on ?device))

  (:action switch-off
    :parameters (?device - spot)
    :precondition (and (device ?device) (robot-at ?device) (on ?device))
    :effect (not (on ?device)))

  (:action adjust
    :parameters (?lamp - spot ?brightness - brightness)
    :precondition (and (lamp ?lamp) (robot-at ?lamp) (on ?lamp) (not (shines ?lamp ?brightness)))
    :effect (and (forall (?other - brightness) (not (shines ?lamp ?other))) (shines ?lamp ?brightness)))

  (:action unlock
    :parameters (?spot - spot)
    :precondition (and (lockable ?spot) (robot-at ?spot) (locked ?spot))
    :effect (not (locked ?spot)))

  (:action lock
    :parameters (?spot - spot)
    :precondition (and (lockable ?spot) (robot-at ?spot) (not (open ?spot)) (not (locked ?spot)))
    :effect (locked ?spot))

  (:action open-up
    :parameters (?spot - spot)
    :precondition (and (lockable ?spot) (robot-at ?spot) (not (open ?spot)) (not (locked ?spot)))
    :effect (open ?spot))

  (:action close
    :parameters (?spot - spot)
    :precondition (and (lockable ?spot) (robot-at ?spot) (open ?spot))
    :effect (not (open ?spot))))
