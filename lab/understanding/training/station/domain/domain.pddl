; The robot of a research station in space or on the ice: it carries things, works hatches, valves and devices,
; charges batteries, analyses samples, sets temperatures and passes messages on.
(define (domain station)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing temperature message)

  (:predicates
    (crew ?spot - spot)
    (closable ?spot - spot)                 ; a hatch, a door, a valve
    (device ?spot - spot)
    (instrument ?spot - spot)
    (charger ?spot - spot)
    (thermostat ?spot - spot)
    (battery ?item - item)
    (sample ?item - item)
    (robot-at ?spot - spot)
    (at ?item - item ?spot - spot)
    (holding ?item - item)
    (open ?spot - spot)
    (live ?spot - spot)
    (set-to ?spot - spot ?temperature - temperature)
    ; what happened
    (charged ?item - item)
    (analysed ?sample - item ?instrument - spot)
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

  (:action open-up
    :parameters (?spot - spot)
    :precondition (and (closable ?spot) (robot-at ?spot) (not (open ?spot)))
    :effect (open ?spot))

  (:action seal
    :parameters (?spot - spot)
    :precondition (and (closable ?spot) (robot-at ?spot) (open ?spot))
    :effect (not (open ?spot)))

  (:action switch-on
    :parameters (?spot - spot)
    :precondition (and (device ?spot) (robot-at ?spot) (not (live ?spot)))
    :effect (live ?spot))

  (:action switch-off
    :parameters (?spot - spot)
    :precondition (and (device ?spot) (robot-at ?spot) (live ?spot))
    :effect (not (live ?spot)))

  (:action charge
    :parameters (?item - item ?charger - spot)
    :precondition (and (battery ?item) (charger ?charger) (robot-at ?charger) (holding ?item))
    :effect (charged ?item))

  (:action analyse
    :parameters (?sample - item ?instrument - spot)
    :precondition (and (sample ?sample) (instrument ?instrument) (live ?instrument)
                       (robot-at ?instrument) (holding ?sample))
    :effect (analysed ?sample ?instrument))

  (:action dial
    :parameters (?spot - spot ?temperature - temperature)
    :precondition (and (thermostat ?spot) (robot-at ?spot) (not (set-to ?spot ?temperature)))
    :effect (and (forall (?other - temperature) (not (set-to ?spot ?other))) (set-to ?spot ?temperature)))

  (:action tell
    :parameters (?person - spot ?message - message)
    :precondition (and (crew ?person) (robot-at ?person))
    :effect (told ?person ?message)))
