; A robot in a dental practice: it fetches and tidies, sees to chairs, lamps, doors and cups, cleans and refills, calls
; people in, and looks at instruments and supplies before it decides what to do with them.
(define (domain dentist)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing shade way angle volume)

  (:constants white amber blue - shade
              open shut - way)

  (:predicates
    ; what never changes
    (surface ?thing - thing)
    (person ?spot - spot)
    (chair ?spot - spot)
    (device ?spot - spot)
    (lamp ?spot - spot)
    (door ?spot - spot)
    (instrument ?item - item)
    (edged ?item - item)
    (cup ?item - item)
    (supply ?thing - thing)
    ; where things are and how they are
    (robot-at ?thing - thing)
    (at ?item - item ?spot - thing)
    (holding ?item - item)
    (powered ?spot - spot)
    (shining ?spot - spot ?shade - shade)
    (stands ?spot - spot ?way - way)
    (tilted ?spot - spot ?angle - angle)
    (water ?item - item ?volume - volume)
    ; what only a look tells
    (sharp ?item - item)
    (blunt ?item - item)
    (plenty ?thing - thing)
    (low ?thing - thing)
    (empty ?thing - thing)
    ; what happened
    (sterilised ?item - item)
    (wiped ?spot - spot)
    (invited ?person - spot ?spot - spot)
    (restocked ?thing - thing)
    (told ?person - spot ?thing - thing))

  (:action glide
    :parameters (?to - thing)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - thing) (not (robot-at ?from))) (robot-at ?to)))

  (:action pick
    :parameters (?item - item ?from - thing)
    :precondition (and (robot-at ?from) (at ?item ?from)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action lay
    :parameters (?item - item ?to - thing)
    :precondition (and (holding ?item) (robot-at ?to) (not (= ?item ?to)) (surface ?to))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action pass
    :parameters (?item - item ?person - spot)
    :precondition (and (holding ?item) (robot-at ?person) (person ?person))
    :effect (and (at ?item ?person) (not (holding ?item))))

  (:action sterilise
    :parameters (?item - item)
    :precondition (and (instrument ?item) (robot-at ?item))
    :effect (sterilised ?item))

  (:action wipe-down
    :parameters (?spot - spot)
    :precondition (and (robot-at ?spot) (not (person ?spot)))
    :effect (wiped ?spot))

  (:action power-up
    :parameters (?spot - spot)
    :precondition (and (device ?spot) (robot-at ?spot) (not (powered ?spot)))
    :effect (powered ?spot))

  (:action power-down
    :parameters (?spot - spot)
    :precondition (and (device ?spot) (robot-at ?spot) (powered ?spot))
    :effect (not (powered ?spot)))

  (:action tune
    :parameters (?lamp - spot ?shade - shade)
    :precondition (and (lamp ?lamp) (robot-at ?lamp) (not (shining ?lamp ?shade)))
    :effect (and (forall (?other - shade) (not (shining ?lamp ?other))) (shining ?lamp ?shade)))

  (:action swing
    :parameters (?door - spot ?way - way)
    :precondition (and (door ?door) (robot-at ?door) (not (stands ?door ?way)))
    :effect (and (forall (?other - way) (not (stands ?door ?other))) (stands ?door ?way)))

  (:action tilt
    :parameters (?chair - spot ?angle - angle)
    :precondition (and (chair ?chair) (robot-at ?chair) (not (tilted ?chair ?angle)))
    :effect (and (forall (?other - angle) (not (tilted ?chair ?other))) (tilted ?chair ?angle)))

  (:action pour
    :parameters (?cup - item ?volume - volume)
    :precondition (and (cup ?cup) (robot-at ?cup) (not (water ?cup ?volume)))
    :effect (and (forall (?other - volume) (not (water ?cup ?other))) (water ?cup ?volume)))

  (:action invite
    :parameters (?person - spot ?spot - spot)
    :precondition (and (person ?person) (robot-at ?person) (not (person ?spot)))
    :effect (invited ?person ?spot))

  (:action restock
    :parameters (?thing - thing)
    :precondition (and (supply ?thing) (robot-at ?thing))
    :effect (restocked ?thing))

  (:action tell
    :parameters (?person - spot ?thing - thing)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (told ?person ?thing))

  ; It is enough to stand in front of the thing.
  (:action test-edge
    :parameters (?item - item)
    :precondition (and (edged ?item) (robot-at ?item))
    :effect (and))

  (:action check-supply
    :parameters (?thing - thing)
    :precondition (and (supply ?thing) (robot-at ?thing))
    :effect (and)))
