; A bathroom robot: it tidies and hands things, washes, dries and scrubs, switches devices, opens and shuts cabinets and windows.
(define (domain bathroom)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing temperature)

  (:predicates
    (person ?spot - spot)
    (opens ?spot - spot)                    ; a window, a cabinet, a machine
    (has-top ?spot - spot)
    (device ?spot - spot)
    (heats ?spot - spot)                    ; has a thermostat
    (washes ?spot - spot)
    (dries ?spot - spot)
    (scrubbable ?spot - spot)
    (cloth ?item - item)                    ; can be washed and dried
    (tool ?item - item)
    (at ?item - item ?spot - spot)
    (atop ?item - item ?spot - spot)
    (beside ?item - item ?spot - spot)
    (holding ?item - item)
    (open ?spot - spot)
    (running ?spot - spot)
    (wet ?item - item)
    (set-to ?spot - spot ?temperature - temperature)
    ; what happened
    (washed ?item - item)
    (scrubbed ?spot - spot ?tool - item))

  (:action take
    :parameters (?item - item)
    :precondition (and (forall (?other - item) (not (holding ?other)))
                       (forall (?spot - spot) (imply (and (at ?item ?spot) (opens ?spot)) (open ?spot))))
    :effect (and (holding ?item)
                 (forall (?spot - spot) (and (not (at ?item ?spot)) (not (atop ?item ?spot)) (not (beside ?item ?spot))))))

  (:action put
    :parameters (?item - item ?spot - spot)
    :precondition (and (holding ?item) (imply (opens ?spot) (open ?spot)))
    :effect (and (at ?item ?spot) (not (holding ?item))))

  (:action put-top
    :parameters (?item - item ?spot - spot)
    :precondition (and (holding ?item) (has-top ?spot))
    :effect (and (atop ?item ?spot) (not (holding ?item))))

  (:action put-beside
    :parameters (?item - item ?spot - spot)
    :precondition (and (holding ?item) (not (person ?spot)))
    :effect (and (beside ?item ?spot) (not (holding ?item))))

  (:action wash
    :parameters (?item - item ?washer - spot)
    :precondition (and (cloth ?item) (washes ?washer) (at ?item ?washer))
    :effect (and (washed ?item) (wet ?item)))

  (:action dry
    :parameters (?item - item ?dryer - spot)
    :precondition (and (cloth ?item) (dries ?dryer) (at ?item ?dryer) (wet ?item))
    :effect (not (wet ?item)))

  (:action scrub
    :parameters (?spot - spot ?tool - item)
    :precondition (and (scrubbable ?spot) (tool ?tool) (holding ?tool))
    :effect (scrubbed ?spot ?tool))

  (:action switch-on
    :parameters (?device - spot)
    :precondition (and (device ?device) (not (running ?device)))
    :effect (running ?device))

  (:action switch-off
    :parameters (?device - spot)
    :precondition (and (device ?device) (running ?device))
    :effect (not (running ?device)))

  (:action adjust
    :parameters (?device - spot ?temperature - temperature)
    :precondition (and (heats ?device) (running ?device))
    :effect (and (forall (?old - temperature) (not (set-to ?device ?old))) (set-to ?device ?temperature)))

  (:action open-up
    :parameters (?spot - spot)
    :precondition (and (opens ?spot) (not (open ?spot)))
    :effect (open ?spot))

  (:action close
    :parameters (?spot - spot)
    :precondition (and (opens ?spot) (open ?spot))
    :effect (not (open ?spot))))
