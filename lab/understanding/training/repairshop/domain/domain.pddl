; repair shop robot
(define (domain repairshop)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot unit - thing heat voltage)

  (:predicates
    (human ?spot - spot)
    (dev ?spot - spot)
    (hatch ?spot - spot)
    (iron ?spot - spot)
    (psu ?spot - spot)
    (tag ?spot - spot)
    (fixable ?unit - unit)
    (part ?unit - unit)
    (batt ?unit - unit)
    (robot-at ?spot - spot)
    (at ?unit - unit ?spot - spot)
    (carrying ?unit - unit)
    (on ?spot - spot)
    (open ?spot - spot)
    (hot ?spot - spot ?heat - heat)
    (supplies ?spot - spot ?voltage - voltage)
    (tagged ?unit - unit ?tag - spot)
    ; sensed
    (works ?unit - unit)
    (faulty ?unit - unit)
    (full ?unit - unit)
    (flat ?unit - unit)
    (swollen ?unit - unit)
    ; events
    (fitted ?unit - unit ?part - unit)
    (soldered ?unit - unit)
    (dusted ?thing - thing)
    (pinged ?spot - spot))

  (:action drive
    :parameters (?to - spot)
    :precondition (and (not (robot-at ?to)) (not (tag ?to)))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to)))

  (:action pick
    :parameters (?unit - unit ?from - spot)
    :precondition (and (robot-at ?from) (at ?unit ?from)
                       (forall (?other - unit) (not (carrying ?other))))
    :effect (and (carrying ?unit) (not (at ?unit ?from))))

  (:action drop
    :parameters (?unit - unit ?to - spot)
    :precondition (and (robot-at ?to) (carrying ?unit))
    :effect (and (at ?unit ?to) (not (carrying ?unit))))

  (:action press-on
    :parameters (?dev - spot)
    :precondition (and (dev ?dev) (robot-at ?dev) (not (on ?dev)))
    :effect (on ?dev))

  (:action press-off
    :parameters (?dev - spot)
    :precondition (and (dev ?dev) (robot-at ?dev) (on ?dev))
    :effect (not (on ?dev)))

  (:action pull
    :parameters (?hatch - spot)
    :precondition (and (hatch ?hatch) (robot-at ?hatch) (not (open ?hatch)))
    :effect (open ?hatch))

  (:action push
    :parameters (?hatch - spot)
    :precondition (and (hatch ?hatch) (robot-at ?hatch) (open ?hatch))
    :effect (not (open ?hatch)))

  (:action heat-to
    :parameters (?iron - spot ?heat - heat)
    :precondition (and (iron ?iron) (robot-at ?iron) (not (hot ?iron ?heat)))
    :effect (and (forall (?other - heat) (not (hot ?iron ?other))) (hot ?iron ?heat)))

  (:action turn-knob
    :parameters (?psu - spot ?voltage - voltage)
    :precondition (and (psu ?psu) (robot-at ?psu) (not (supplies ?psu ?voltage)))
    :effect (and (forall (?other - voltage) (not (supplies ?psu ?other))) (supplies ?psu ?voltage)))

  (:action stick
    :parameters (?unit - unit ?tag - spot ?where - spot)
    :precondition (and (tag ?tag) (robot-at ?where) (at ?unit ?where) (not (tagged ?unit ?tag)))
    :effect (and (forall (?other - spot) (not (tagged ?unit ?other))) (tagged ?unit ?tag)))

  (:action fit
    :parameters (?unit - unit ?part - unit ?where - spot)
    :precondition (and (fixable ?unit) (part ?part) (robot-at ?where) (at ?unit ?where))
    :effect (fitted ?unit ?part))

  (:action rework
    :parameters (?unit - unit ?where - spot)
    :precondition (and (fixable ?unit) (robot-at ?where) (at ?unit ?where))
    :effect (soldered ?unit))

  (:action blow-out
    :parameters (?unit - unit ?where - spot)
    :precondition (and (robot-at ?where) (at ?unit ?where))
    :effect (dusted ?unit))

  (:action wipe-down
    :parameters (?spot - spot)
    :precondition (and (robot-at ?spot) (not (human ?spot)) (not (tag ?spot)))
    :effect (dusted ?spot))

  (:action ring
    :parameters (?human - spot)
    :precondition (human ?human)
    :effect (pinged ?human))

  (:action try-out
    :parameters (?unit - unit ?where - spot)
    :precondition (and (fixable ?unit) (robot-at ?where) (at ?unit ?where))
    :effect (and))

  (:action probe
    :parameters (?unit - unit ?where - spot)
    :precondition (and (batt ?unit) (robot-at ?where) (at ?unit ?where))
    :effect (and)))
