; A market stall robot: it moves fruit and crates, weighs, prices and washes them, opens and switches things, serves
; people, and looks at fruit, crates and scales before it decides what to do with them.
(define (domain fruitstall)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item - thing price)

  (:predicates
    ; what never changes
    (holder ?thing - thing)                 ; things can be put there
    (lidded ?thing - thing)
    (device ?thing - thing)
    (person ?place - place)
    (scale ?place - place)
    (produce ?item - item)
    (crate ?item - item)
    ; where things are and how they are
    (robot-at ?thing - thing)
    (at ?item - item ?place - thing)
    (holding ?item - item)
    (open ?thing - thing)
    (running ?thing - thing)
    (priced ?item - item ?price - price)
    ; what only a look tells
    (ripe ?item - item)
    (unripe ?item - item)
    (rotten ?item - item)
    (balanced ?place - place)
    (unbalanced ?place - place)
    (full ?item - item)
    (roomy ?item - item)
    ; what happened
    (washed ?thing - thing)
    (weighed ?item - item ?scale - place)
    (zeroed ?scale - place)
    (reported ?thing - thing ?person - place))

  (:action go
    :parameters (?to - thing)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - thing) (not (robot-at ?from))) (robot-at ?to)))

  (:action take
    :parameters (?item - item ?from - thing)
    :precondition (and (robot-at ?from) (at ?item ?from) (imply (lidded ?from) (open ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action place
    :parameters (?item - item ?to - thing)
    :precondition (and (holding ?item) (robot-at ?to) (not (= ?item ?to)) (holder ?to)
                       (imply (lidded ?to) (open ?to)))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action hand-over
    :parameters (?item - item ?person - place)
    :precondition (and (holding ?item) (robot-at ?person) (person ?person))
    :effect (and (at ?item ?person) (not (holding ?item))))

  (:action unfold
    :parameters (?thing - thing)
    :precondition (and (lidded ?thing) (robot-at ?thing) (not (open ?thing)))
    :effect (open ?thing))

  (:action shut
    :parameters (?thing - thing)
    :precondition (and (lidded ?thing) (robot-at ?thing) (open ?thing))
    :effect (not (open ?thing)))

  (:action turn-on
    :parameters (?thing - thing)
    :precondition (and (device ?thing) (robot-at ?thing) (not (running ?thing)))
    :effect (running ?thing))

  (:action turn-off
    :parameters (?thing - thing)
    :precondition (and (device ?thing) (robot-at ?thing) (running ?thing))
    :effect (not (running ?thing)))

  (:action wash
    :parameters (?thing - thing)
    :precondition (robot-at ?thing)
    :effect (washed ?thing))

  (:action weigh
    :parameters (?item - item ?scale - place)
    :precondition (and (scale ?scale) (holding ?item) (robot-at ?scale))
    :effect (weighed ?item ?scale))

  (:action mark
    :parameters (?item - item ?price - price)
    :precondition (and (produce ?item) (robot-at ?item) (not (priced ?item ?price)))
    :effect (and (forall (?other - price) (not (priced ?item ?other))) (priced ?item ?price)))

  (:action zero
    :parameters (?scale - place)
    :precondition (and (scale ?scale) (robot-at ?scale))
    :effect (zeroed ?scale))

  (:action report
    :parameters (?thing - thing ?person - place)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (reported ?thing ?person))

  ; It is enough to stand in front of the thing.
  (:action check-ripeness
    :parameters (?item - item)
    :precondition (and (produce ?item) (robot-at ?item))
    :effect (and))

  (:action check-scale
    :parameters (?place - place)
    :precondition (and (scale ?place) (robot-at ?place))
    :effect (and))

  (:action check-room
    :parameters (?item - item)
    :precondition (and (crate ?item) (robot-at ?item))
    :effect (and)))
