;; A robot in a small cinema: it carries things, minds lamps, machines, doors and curtains, sets the sound and the light
;; of the halls, cleans, tells people, and looks into rooms and at supplies before it decides what to do.
(define (domain cinema)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types area prop - thing loudness)

  (:predicates
    ; what never changes
    (base ?area - area)                    ; things can be left there
    (person ?area - area)
    (lamp ?area - area)
    (machine ?area - area)
    (opening ?area - area)
    (sound ?area - area)
    (room ?area - area)
    (hall ?area - area)
    (scene ?area - area)                   ; a light scene of a hall
    (supply ?prop - prop)
    ; where things are and how they are
    (robot-at ?thing - thing)
    (at ?prop - prop ?area - area)
    (carried ?prop - prop)
    (glowing ?area - area)
    (turning ?area - area)
    (ajar ?area - area)
    (loud ?area - area ?loudness - loudness)
    (bathed ?hall - area ?scene - area)
    ; what only a look tells
    (vacant ?area - area)
    (occupied ?area - area)
    (ample ?prop - prop)
    (low ?prop - prop)
    (used-up ?prop - prop)
    ; what happened
    (cleaned ?area - area)
    (informed ?area - area))

  (:action head-for
    :parameters (?to - thing)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - thing) (not (robot-at ?from))) (robot-at ?to)))

  (:action collect
    :parameters (?prop - prop ?from - area)
    :precondition (and (robot-at ?from) (at ?prop ?from) (forall (?other - prop) (not (carried ?other))))
    :effect (and (carried ?prop) (not (at ?prop ?from))))

  (:action deposit
    :parameters (?prop - prop ?to - area)
    :precondition (and (carried ?prop) (robot-at ?to) (or (base ?to) (person ?to)))
    :effect (and (at ?prop ?to) (not (carried ?prop))))

  (:action light-up
    :parameters (?lamp - area)
    :precondition (and (lamp ?lamp) (robot-at ?lamp) (not (glowing ?lamp)))
    :effect (glowing ?lamp))

  (:action douse
    :parameters (?lamp - area)
    :precondition (and (lamp ?lamp) (robot-at ?lamp) (glowing ?lamp))
    :effect (not (glowing ?lamp)))

  (:action set-going
    :parameters (?machine - area)
    :precondition (and (machine ?machine) (robot-at ?machine) (not (turning ?machine)))
    :effect (turning ?machine))

  (:action halt
    :parameters (?machine - area)
    :precondition (and (machine ?machine) (robot-at ?machine) (turning ?machine))
    :effect (not (turning ?machine)))

  (:action part
    :parameters (?opening - area)
    :precondition (and (opening ?opening) (robot-at ?opening) (not (ajar ?opening)))
    :effect (ajar ?opening))

  (:action close-off
    :parameters (?opening - area)
    :precondition (and (opening ?opening) (robot-at ?opening) (ajar ?opening))
    :effect (not (ajar ?opening)))

  (:action set-volume
    :parameters (?sound - area ?loudness - loudness)
    :precondition (and (sound ?sound) (robot-at ?sound) (not (loud ?sound ?loudness)))
    :effect (and (forall (?other - loudness) (not (loud ?sound ?other))) (loud ?sound ?loudness)))

  (:action set-scene
    :parameters (?hall - area ?scene - area)
    :precondition (and (hall ?hall) (scene ?scene) (robot-at ?hall) (not (bathed ?hall ?scene)))
    :effect (and (forall (?other - area) (not (bathed ?hall ?other))) (bathed ?hall ?scene)))

  (:action sweep
    :parameters (?area - area)
    :precondition (and (robot-at ?area) (not (person ?area)) (not (scene ?area)))
    :effect (cleaned ?area))

  (:action inform
    :parameters (?person - area)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (informed ?person))

  ; It is enough to stand in front of the thing, or in the doorway.
  (:action peek-in
    :parameters (?area - area)
    :precondition (and (room ?area) (robot-at ?area))
    :effect (and))

  (:action check-stock
    :parameters (?prop - prop)
    :precondition (and (supply ?prop) (robot-at ?prop))
    :effect (and)))
