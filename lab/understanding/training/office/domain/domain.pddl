; An office robot: it carries mail and supplies, shreds and copies papers, switches devices, moves blinds and passes messages on.
(define (domain office)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing message count)

  (:predicates
    (person ?spot - spot)
    (switchable ?spot - spot)
    (blind ?spot - spot)
    (shredder ?spot - spot)
    (copier ?spot - spot)
    (refillable ?spot - spot)
    (paper ?item - item)
    (supply ?item - item)
    (robot-at ?spot - spot)
    (at ?item - item ?spot - spot)
    (holding ?item - item)
    (on ?spot - spot)
    (up ?spot - spot)
    (shredded ?item - item)
    ; what happened
    (replenished ?spot - spot ?item - item)
    (duplicated ?item - item ?count - count)
    (told ?person - spot ?message - message))

  (:action go
    :parameters (?to - spot)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to)))

  (:action take
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (at ?item ?from)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action leave
    :parameters (?item - item ?to - spot)
    :precondition (and (holding ?item) (robot-at ?to))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action switch-on
    :parameters (?spot - spot)
    :precondition (and (switchable ?spot) (robot-at ?spot) (not (on ?spot)))
    :effect (on ?spot))

  (:action switch-off
    :parameters (?spot - spot)
    :precondition (and (switchable ?spot) (robot-at ?spot) (on ?spot))
    :effect (not (on ?spot)))

  (:action raise
    :parameters (?spot - spot)
    :precondition (and (blind ?spot) (robot-at ?spot) (not (up ?spot)))
    :effect (up ?spot))

  (:action lower
    :parameters (?spot - spot)
    :precondition (and (blind ?spot) (robot-at ?spot) (up ?spot))
    :effect (not (up ?spot)))

  (:action shred
    :parameters (?item - item ?spot - spot)
    :precondition (and (paper ?item) (holding ?item) (shredder ?spot) (robot-at ?spot))
    :effect (and (shredded ?item) (not (holding ?item))))

  (:action copy
    :parameters (?item - item ?spot - spot ?count - count)
    :precondition (and (paper ?item) (holding ?item) (copier ?spot) (robot-at ?spot))
    :effect (duplicated ?item ?count))

  (:action refill
    :parameters (?spot - spot ?item - item)
    :precondition (and (refillable ?spot) (supply ?item) (holding ?item) (robot-at ?spot))
    :effect (and (replenished ?spot ?item) (at ?item ?spot) (not (holding ?item))))

  (:action tell
    :parameters (?person - spot ?message - message)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (told ?person ?message)))
