; glasshouse robot
(define (domain glasshouse)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types station item - entity temp dose)

  (:predicates
    (shelf ?s - station)
    (zone ?s - station)
    (flap ?s - station)
    (unit ?s - station)
    (lamp ?s - station)
    (colour ?s - station)
    (seat ?s - station)
    (person ?s - station)
    (plant ?i - item)
    (robot-at ?e - entity)
    (at ?i - item ?s - station)
    (carrying ?i - item)
    (open ?s - station)
    (on ?s - station)
    (set-to ?s - station ?t - temp)
    (shines ?s - station ?c - station)
    ; sensed
    (dry ?i - item)
    (moist ?i - item)
    (soggy ?i - item)
    (taken ?s - station)
    (vacant ?s - station)
    ; events
    (watered ?i - item)
    (fed ?i - item ?d - dose)
    (wiped ?s - station)
    (pinged ?s - station))

  (:action drive
    :parameters (?to - entity)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - entity) (not (robot-at ?from))) (robot-at ?to)))

  (:action pick
    :parameters (?i - item ?from - station)
    :precondition (and (robot-at ?from) (at ?i ?from) (forall (?other - item) (not (carrying ?other))))
    :effect (and (carrying ?i) (not (at ?i ?from))))

  (:action drop
    :parameters (?i - item ?to - station)
    :precondition (and (robot-at ?to) (carrying ?i) (or (shelf ?to) (person ?to)))
    :effect (and (at ?i ?to) (not (carrying ?i))))

  (:action flap-open
    :parameters (?s - station)
    :precondition (and (flap ?s) (robot-at ?s) (not (open ?s)))
    :effect (open ?s))

  (:action flap-shut
    :parameters (?s - station)
    :precondition (and (flap ?s) (robot-at ?s) (open ?s))
    :effect (not (open ?s)))

  (:action start
    :parameters (?s - station)
    :precondition (and (unit ?s) (robot-at ?s) (not (on ?s)))
    :effect (on ?s))

  (:action stop
    :parameters (?s - station)
    :precondition (and (unit ?s) (robot-at ?s) (on ?s))
    :effect (not (on ?s)))

  (:action irrigate
    :parameters (?i - item)
    :precondition (and (plant ?i) (robot-at ?i))
    :effect (watered ?i))

  (:action dose-out
    :parameters (?i - item ?d - dose)
    :precondition (and (plant ?i) (robot-at ?i))
    :effect (fed ?i ?d))

  (:action regulate
    :parameters (?s - station ?t - temp)
    :precondition (and (zone ?s) (robot-at ?s) (not (set-to ?s ?t)))
    :effect (and (forall (?other - temp) (not (set-to ?s ?other))) (set-to ?s ?t)))

  (:action tune
    :parameters (?s - station ?c - station)
    :precondition (and (lamp ?s) (colour ?c) (robot-at ?s) (not (shines ?s ?c)))
    :effect (and (forall (?other - station) (not (shines ?s ?other))) (shines ?s ?c)))

  (:action clean
    :parameters (?s - station)
    :precondition (and (shelf ?s) (robot-at ?s))
    :effect (wiped ?s))

  (:action signal
    :parameters (?s - station)
    :precondition (person ?s)
    :effect (pinged ?s))

  (:action probe
    :parameters (?i - item)
    :precondition (and (plant ?i) (robot-at ?i))
    :effect (and))

  (:action watch
    :parameters (?s - station)
    :precondition (and (seat ?s) (robot-at ?s))
    :effect (and)))
