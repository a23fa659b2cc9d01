; A robot in a mountain refuge: it stows and hands over gear, hangs wet things up, minds fires, doors and the roof beacon,
; gives guests their bunks, fetches water, sweeps, calls over the radio, and looks at clothes and bunks before it decides.
(define (domain mountainhut)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing litres)

  (:predicates
    ; what never changes
    (storage ?thing - thing)
    (person ?spot - spot)
    (flame ?spot - spot)
    (door ?spot - spot)
    (rack ?spot - spot)
    (bunk ?spot - spot)
    (room ?spot - spot)
    (post ?spot - spot)
    (colour ?spot - spot)
    (cloth ?item - item)
    (vessel ?item - item)
    ; where things are and how they are
    (robot-at ?thing - thing)
    (at ?item - item ?place - thing)
    (holding ?item - item)
    (burning ?spot - spot)
    (open ?spot - spot)
    (contains ?item - item ?litres - litres)
    (sleeps-in ?guest - spot ?bunk - spot)
    (shown ?colour - spot)
    ; what only a look tells
    (soaked ?item - item)
    (damp ?item - item)
    (dry ?item - item)
    (vacant ?spot - spot)
    (taken ?spot - spot)
    ; what happened
    (swept ?spot - spot)
    (radioed ?post - spot))

  (:action walk
    :parameters (?to - thing)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - thing) (not (robot-at ?from))) (robot-at ?to)))

  (:action pick-up
    :parameters (?item - item ?from - thing)
    :precondition (and (robot-at ?from) (at ?item ?from)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action stow
    :parameters (?item - item ?to - thing)
    :precondition (and (holding ?item) (robot-at ?to) (storage ?to) (not (= ?item ?to)))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action pass
    :parameters (?item - item ?person - spot)
    :precondition (and (holding ?item) (robot-at ?person) (person ?person))
    :effect (and (at ?item ?person) (not (holding ?item))))

  (:action hang
    :parameters (?cloth - item ?rack - spot)
    :precondition (and (holding ?cloth) (robot-at ?rack) (cloth ?cloth) (rack ?rack))
    :effect (and (at ?cloth ?rack) (not (holding ?cloth))))

  (:action kindle
    :parameters (?flame - spot)
    :precondition (and (flame ?flame) (robot-at ?flame) (not (burning ?flame)))
    :effect (burning ?flame))

  (:action put-out
    :parameters (?flame - spot)
    :precondition (and (flame ?flame) (robot-at ?flame) (burning ?flame))
    :effect (not (burning ?flame)))

  (:action swing-open
    :parameters (?door - spot)
    :precondition (and (door ?door) (robot-at ?door) (not (open ?door)))
    :effect (open ?door))

  (:action pull-to
    :parameters (?door - spot)
    :precondition (and (door ?door) (robot-at ?door) (open ?door))
    :effect (not (open ?door)))

  (:action pour-in
    :parameters (?vessel - item ?litres - litres)
    :precondition (and (vessel ?vessel) (robot-at ?vessel) (not (contains ?vessel ?litres)))
    :effect (and (forall (?other - litres) (not (contains ?vessel ?other))) (contains ?vessel ?litres)))

  (:action book
    :parameters (?guest - spot ?bunk - spot)
    :precondition (and (person ?guest) (bunk ?bunk) (robot-at ?bunk) (not (sleeps-in ?guest ?bunk)))
    :effect (and (forall (?other - spot) (not (sleeps-in ?guest ?other))) (sleeps-in ?guest ?bunk)))

  (:action set-beacon
    :parameters (?colour - spot)
    :precondition (and (colour ?colour) (not (shown ?colour)))
    :effect (and (forall (?other - spot) (not (shown ?other))) (shown ?colour)))

  (:action sweep
    :parameters (?spot - spot)
    :precondition (and (robot-at ?spot) (or (room ?spot) (storage ?spot)))
    :effect (swept ?spot))

  (:action call-in
    :parameters (?post - spot)
    :precondition (post ?post)
    :effect (radioed ?post))

  ; It is enough to stand in front of the thing.
  (:action feel-cloth
    :parameters (?item - item)
    :precondition (and (cloth ?item) (robot-at ?item))
    :effect (and))

  (:action look-bunk
    :parameters (?spot - spot)
    :precondition (and (bunk ?spot) (robot-at ?spot))
    :effect (and)))
