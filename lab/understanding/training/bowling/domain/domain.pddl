;; bowling alley robot
(define (domain bowling)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types loc obj - thing mode count)

  (:constants kids league disco practice - mode)

  (:predicates
    (lane ?loc - loc)
    (dev ?loc - loc)
    (door ?loc - loc)
    (person ?loc - loc)
    (ball ?obj - obj)
    (shoes ?obj - obj)
    (robot-at ?loc - loc)
    (at ?obj - obj ?loc - loc)
    (grip ?obj - obj)
    (powered ?loc - loc)
    (open ?loc - loc)
    (in-mode ?loc - loc ?mode - mode)
    (booked ?loc - loc ?count - count)
    ; sensed
    (intact ?obj - obj)
    (chipped ?obj - obj)
    (cracked ?obj - obj)
    (vacant ?loc - loc)
    (taken ?loc - loc)
    ; events
    (racked ?loc - loc)
    (oiled ?loc - loc)
    (sprayed ?obj - obj)
    (wiped ?thing - thing)
    (pinged ?loc - loc))

  (:action go
    :parameters (?to - loc)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - loc) (not (robot-at ?from))) (robot-at ?to)))

  (:action grab
    :parameters (?obj - obj ?from - loc)
    :precondition (and (robot-at ?from) (at ?obj ?from) (forall (?other - obj) (not (grip ?other))))
    :effect (and (grip ?obj) (not (at ?obj ?from))))

  (:action drop
    :parameters (?obj - obj ?to - loc)
    :precondition (and (grip ?obj) (robot-at ?to))
    :effect (and (at ?obj ?to) (not (grip ?obj))))

  (:action power-on
    :parameters (?dev - loc)
    :precondition (and (dev ?dev) (robot-at ?dev) (not (powered ?dev)))
    :effect (powered ?dev))

  (:action power-off
    :parameters (?dev - loc)
    :precondition (and (dev ?dev) (robot-at ?dev) (powered ?dev))
    :effect (not (powered ?dev)))

  (:action open-up
    :parameters (?door - loc)
    :precondition (and (door ?door) (robot-at ?door) (not (open ?door)))
    :effect (open ?door))

  (:action shut-up
    :parameters (?door - loc)
    :precondition (and (door ?door) (robot-at ?door) (open ?door))
    :effect (not (open ?door)))

  (:action set-mode
    :parameters (?lane - loc ?mode - mode)
    :precondition (and (lane ?lane) (not (in-mode ?lane ?mode)))
    :effect (and (forall (?other - mode) (not (in-mode ?lane ?other))) (in-mode ?lane ?mode)))

  (:action book
    :parameters (?lane - loc ?count - count)
    :precondition (and (lane ?lane) (not (booked ?lane ?count)))
    :effect (and (forall (?other - count) (not (booked ?lane ?other))) (booked ?lane ?count)))

  (:action set-pins
    :parameters (?lane - loc)
    :precondition (lane ?lane)
    :effect (racked ?lane))

  (:action run-oil
    :parameters (?lane - loc)
    :precondition (and (lane ?lane) (robot-at ?lane))
    :effect (oiled ?lane))

  (:action spray
    :parameters (?shoes - obj ?at - loc)
    :precondition (and (shoes ?shoes) (at ?shoes ?at) (robot-at ?at))
    :effect (sprayed ?shoes))

  (:action wipe-obj
    :parameters (?obj - obj ?at - loc)
    :precondition (and (at ?obj ?at) (robot-at ?at))
    :effect (wiped ?obj))

  (:action wipe-loc
    :parameters (?loc - loc)
    :precondition (robot-at ?loc)
    :effect (wiped ?loc))

  (:action ping
    :parameters (?who - loc)
    :precondition (person ?who)
    :effect (pinged ?who))

  (:action check-ball
    :parameters (?ball - obj)
    :precondition (ball ?ball)
    :effect (and))

  (:action check-lane
    :parameters (?lane - loc)
    :precondition (lane ?lane)
    :effect (and)))
