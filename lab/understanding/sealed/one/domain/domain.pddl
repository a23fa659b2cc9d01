; A beekeeper's robot: it carries things, opens and closes hives and doors, smokes and feeds hives, washes tools, switches and heats devices.
(define (domain apiary)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item - thing temperature)

  (:predicates
    ; what never changes
    (hive ?place - place)                   ; bees live in it
    (lidded ?place - place)                 ; can be opened
    (device ?place - place)                 ; has a switch
    (heater ?place - place)                 ; has a temperature
    (basin ?place - place)                  ; things are washed there
    (person ?place - place)
    (smoker ?item - item)
    (feed ?item - item)
    (washable ?item - item)
    ; where things are and how they are
    (robot-at ?place - place)
    (at ?item - item ?place - place)
    (holding ?item - item)
    (open ?place - place)
    (running ?place - place)
    (set-to ?place - place ?temperature - temperature)
    ; what only shows when the robot lifts a corner of the hive
    (light ?hive - place)
    (heavy ?hive - place)
    ; what happened
    (smoked ?hive - place)
    (fed ?hive - place ?feed - item)
    (washed ?item - item)
    (notified ?person - place))

  (:action go
    :parameters (?to - place)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - place) (not (robot-at ?from))) (robot-at ?to)))

  (:action take
    :parameters (?item - item ?from - place)
    :precondition (and (robot-at ?from) (at ?item ?from) (imply (lidded ?from) (open ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action leave
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (imply (lidded ?to) (open ?to)))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action lift-lid
    :parameters (?place - place)
    :precondition (and (lidded ?place) (robot-at ?place) (not (open ?place)))
    :effect (open ?place))

  (:action shut-lid
    :parameters (?place - place)
    :precondition (and (lidded ?place) (robot-at ?place) (open ?place))
    :effect (not (open ?place)))

  (:action blow-smoke
    :parameters (?smoker - item ?hive - place)
    :precondition (and (smoker ?smoker) (hive ?hive) (holding ?smoker) (robot-at ?hive))
    :effect (smoked ?hive))

  (:action pour-feed
    :parameters (?feed - item ?hive - place)
    :precondition (and (feed ?feed) (hive ?hive) (holding ?feed) (robot-at ?hive) (open ?hive))
    :effect (fed ?hive ?feed))

  (:action scrub
    :parameters (?item - item ?basin - place)
    :precondition (and (washable ?item) (basin ?basin) (holding ?item) (robot-at ?basin))
    :effect (washed ?item))

  (:action adjust
    :parameters (?heater - place ?temperature - temperature)
    :precondition (and (heater ?heater) (robot-at ?heater) (not (set-to ?heater ?temperature)))
    :effect (and (forall (?other - temperature) (not (set-to ?heater ?other))) (set-to ?heater ?temperature)))

  (:action switch-on
    :parameters (?device - place)
    :precondition (and (device ?device) (robot-at ?device) (not (running ?device)))
    :effect (running ?device))

  (:action switch-off
    :parameters (?device - place)
    :precondition (and (device ?device) (robot-at ?device) (running ?device))
    :effect (not (running ?device)))

  (:action notify
    :parameters (?person - place)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (notified ?person))

  (:action heft
    :parameters (?hive - place)
    :precondition (and (hive ?hive) (robot-at ?hive))
    :effect (and)))
