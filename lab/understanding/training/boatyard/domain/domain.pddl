(define (domain boatyard)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing temperature)

  (:predicates
    (person ?spot - spot)
    (boat ?spot - spot)
    (machine ?spot - spot)
    (heater ?spot - spot)
    (door ?spot - spot)
    (shelf ?spot - spot)
    (wood ?item - item)
    (paint ?item - item)
    (work ?thing - thing)
    (robot-at ?thing - thing)
    (at ?item - item ?spot - spot)
    (holding ?item - item)
    (running ?spot - spot)
    (open ?spot - spot)
    (afloat ?spot - spot)
    (set-to ?spot - spot ?temperature - temperature)
    ; unknown until looked at
    (tight ?spot - spot)
    (leaky ?spot - spot)
    (dry ?item - item)
    (damp ?item - item)
    (rotten ?item - item)
    ; done
    (sanded ?thing - thing)
    (coated ?thing - thing ?paint - item)
    (bailed ?spot - spot)
    (called ?spot - spot))

  (:action go
    :parameters (?to - thing)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - thing) (not (robot-at ?from))) (robot-at ?to)))

  (:action pick
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (at ?item ?from) (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action drop
    :parameters (?item - item ?to - spot)
    :precondition (and (robot-at ?to) (holding ?item))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action lower
    :parameters (?boat - spot)
    :precondition (and (boat ?boat) (robot-at ?boat) (not (afloat ?boat)))
    :effect (afloat ?boat))

  (:action lift
    :parameters (?boat - spot)
    :precondition (and (boat ?boat) (robot-at ?boat) (afloat ?boat))
    :effect (not (afloat ?boat)))

  (:action grind
    :parameters (?thing - thing)
    :precondition (and (work ?thing) (robot-at ?thing))
    :effect (sanded ?thing))

  (:action brush
    :parameters (?thing - thing ?paint - item)
    :precondition (and (work ?thing) (paint ?paint) (robot-at ?thing))
    :effect (coated ?thing ?paint))

  (:action pump
    :parameters (?boat - spot)
    :precondition (and (boat ?boat) (robot-at ?boat))
    :effect (bailed ?boat))

  (:action start
    :parameters (?machine - spot)
    :precondition (and (machine ?machine) (robot-at ?machine) (not (running ?machine)))
    :effect (running ?machine))

  (:action stop
    :parameters (?machine - spot)
    :precondition (and (machine ?machine) (robot-at ?machine) (running ?machine))
    :effect (not (running ?machine)))

  (:action unlatch
    :parameters (?door - spot)
    :precondition (and (door ?door) (robot-at ?door) (not (open ?door)))
    :effect (open ?door))

  (:action latch
    :parameters (?door - spot)
    :precondition (and (door ?door) (robot-at ?door) (open ?door))
    :effect (not (open ?door)))

  (:action dial
    :parameters (?heater - spot ?temperature - temperature)
    :precondition (and (heater ?heater) (robot-at ?heater) (not (set-to ?heater ?temperature)))
    :effect (and (forall (?other - temperature) (not (set-to ?heater ?other))) (set-to ?heater ?temperature)))

  (:action ring
    :parameters (?person - spot)
    :precondition (person ?person)
    :effect (called ?person))

  (:action check-hull
    :parameters (?boat - spot)
    :precondition (and (boat ?boat) (robot-at ?boat))
    :effect (and))

  (:action probe
    :parameters (?wood - item)
    :precondition (and (wood ?wood) (robot-at ?wood))
    :effect (and)))
