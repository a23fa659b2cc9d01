; A deck robot with a crane arm: it stows and lashes cargo, works hatches, pumps, winches and lifeboats, and sends the crew to their stations.
(define (domain ship)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing length)

  (:predicates
    (person ?spot - spot)
    (hatch ?spot - spot)
    (pump ?spot - spot)
    (boat ?spot - spot)
    (winch ?spot - spot)
    (rope ?item - item)
    (at ?item - item ?spot - spot)
    (stands ?person - spot ?spot - spot)
    (open ?spot - spot)
    (on ?spot - spot)
    (afloat ?spot - spot)
    (lashed ?item - item ?rope - item)
    ; what happened
    (veered ?winch - spot ?length - length))

  ; What is lashed stays where it is, and so does the rope.
  (:action carry
    :parameters (?item - item ?from - spot ?to - spot)
    :precondition (and (at ?item ?from) (not (= ?from ?to))
                       (forall (?other - item) (and (not (lashed ?item ?other)) (not (lashed ?other ?item)))))
    :effect (and (at ?item ?to) (not (at ?item ?from))))

  (:action send
    :parameters (?person - spot ?to - spot)
    :precondition (and (person ?person) (not (person ?to)) (not (stands ?person ?to)))
    :effect (and (forall (?from - spot) (not (stands ?person ?from))) (stands ?person ?to)))

  (:action lift-cover
    :parameters (?spot - spot)
    :precondition (and (hatch ?spot) (not (open ?spot)))
    :effect (open ?spot))

  (:action batten
    :parameters (?spot - spot)
    :precondition (and (hatch ?spot) (open ?spot))
    :effect (not (open ?spot)))

  (:action start
    :parameters (?spot - spot)
    :precondition (and (pump ?spot) (not (on ?spot)))
    :effect (on ?spot))

  (:action stop
    :parameters (?spot - spot)
    :precondition (and (pump ?spot) (on ?spot))
    :effect (not (on ?spot)))

  (:action lash
    :parameters (?item - item ?rope - item)
    :precondition (and (rope ?rope) (not (rope ?item))
                       (forall (?other - item) (and (not (lashed ?item ?other)) (not (lashed ?other ?rope)))))
    :effect (lashed ?item ?rope))

  (:action untie
    :parameters (?item - item ?rope - item)
    :precondition (lashed ?item ?rope)
    :effect (not (lashed ?item ?rope)))

  (:action launch
    :parameters (?spot - spot)
    :precondition (and (boat ?spot) (not (afloat ?spot)))
    :effect (afloat ?spot))

  (:action veer
    :parameters (?winch - spot ?length - length)
    :precondition (winch ?winch)
    :effect (veered ?winch ?length)))
