; A sorting robot: it carries loads, feeds machines, pulls metal out with magnets, works belts and lids, calls people.
(define (domain recycling)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot load - thing speed)

  (:predicates
    (person ?spot - spot)
    (machine ?spot - spot)                  ; can be started and stopped
    (processor ?spot - spot)                ; a press, a shredder, a washer
    (belt ?spot - spot)
    (lidded ?spot - spot)                   ; a bin with a lid, a gate
    (magnet ?load - load)
    (robot-at ?spot - spot)
    (at ?load - load ?spot - spot)
    (holding ?load - load)
    (running ?spot - spot)
    (open ?spot - spot)
    (set-to ?belt - spot ?speed - speed)
    ; what happened
    (fed ?load - load ?machine - spot)
    (demetalled ?load - load ?magnet - load)
    (alerted ?person - spot))

  (:action go
    :parameters (?to - spot)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to)))

  (:action grab
    :parameters (?load - load ?from - spot)
    :precondition (and (robot-at ?from) (at ?load ?from) (imply (lidded ?from) (open ?from))
                       (forall (?other - load) (not (holding ?other))))
    :effect (and (holding ?load) (not (at ?load ?from))))

  (:action drop
    :parameters (?load - load ?to - spot)
    :precondition (and (holding ?load) (robot-at ?to) (imply (lidded ?to) (open ?to)))
    :effect (and (at ?load ?to) (not (holding ?load))))

  ; The load ends at the machine.
  (:action feed
    :parameters (?load - load ?machine - spot)
    :precondition (and (processor ?machine) (running ?machine) (robot-at ?machine) (holding ?load) (not (magnet ?load)))
    :effect (and (fed ?load ?machine) (at ?load ?machine) (not (holding ?load))))

  (:action pull
    :parameters (?load - load ?magnet - load ?spot - spot)
    :precondition (and (magnet ?magnet) (holding ?magnet) (robot-at ?spot) (at ?load ?spot))
    :effect (demetalled ?load ?magnet))

  ; Machines and lids are worked by radio.
  (:action start
    :parameters (?machine - spot)
    :precondition (and (machine ?machine) (not (running ?machine)))
    :effect (running ?machine))

  (:action stop
    :parameters (?machine - spot)
    :precondition (and (machine ?machine) (running ?machine))
    :effect (not (running ?machine)))

  (:action set-speed
    :parameters (?belt - spot ?speed - speed)
    :precondition (and (belt ?belt) (not (set-to ?belt ?speed)))
    :effect (and (forall (?other - speed) (not (set-to ?belt ?other))) (set-to ?belt ?speed)))

  (:action open
    :parameters (?spot - spot)
    :precondition (and (lidded ?spot) (not (open ?spot)))
    :effect (open ?spot))

  (:action close
    :parameters (?spot - spot)
    :precondition (and (lidded ?spot) (open ?spot))
    :effect (not (open ?spot)))

  (:action alert
    :parameters (?person - spot)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (alerted ?person)))
