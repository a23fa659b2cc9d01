; A care robot: it visits people, brings them things, gives pills out of boxes, wakes and informs people.
(define (domain care)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality :numeric-fluents)

  (:types spot item - thing message)

  (:predicates
    (person ?spot - spot)
    (lamp ?spot - spot)
    (box ?item - item)                      ; holds pills
    (robot-at ?spot - spot)
    (at ?item - item ?spot - spot)
    (holding ?item - item)
    (open ?item - item)
    (asleep ?spot - spot)
    (lit ?spot - spot)
    ; what happened
    (dosed ?box - item ?person - spot)
    (informed ?person - spot)
    (told ?person - spot ?message - message)
    (visited ?spot - spot))

  (:functions
    (pills ?box - item)
    (given ?box - item))                    ; pills given from the box

  (:action go
    :parameters (?to - spot)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to) (visited ?to)))

  (:action take
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (at ?item ?from) (not (asleep ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  ; Nobody is handed anything while asleep.
  (:action give
    :parameters (?item - item ?to - spot)
    :precondition (and (holding ?item) (robot-at ?to) (not (asleep ?to)))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action open-box
    :parameters (?item - item)
    :precondition (and (holding ?item) (box ?item) (not (open ?item)))
    :effect (open ?item))

  (:action close-box
    :parameters (?item - item)
    :precondition (and (holding ?item) (box ?item) (open ?item))
    :effect (not (open ?item)))

  (:action dose
    :parameters (?box - item ?person - spot)
    :precondition (and (holding ?box) (box ?box) (open ?box) (>= (pills ?box) 1)
                       (person ?person) (robot-at ?person) (not (asleep ?person)))
    :effect (and (dosed ?box ?person) (decrease (pills ?box) 1) (increase (given ?box) 1)))

  (:action wake
    :parameters (?person - spot)
    :precondition (and (person ?person) (robot-at ?person) (asleep ?person))
    :effect (not (asleep ?person)))

  (:action inform
    :parameters (?person - spot)
    :precondition (and (person ?person) (robot-at ?person) (not (asleep ?person)))
    :effect (informed ?person))

  (:action tell
    :parameters (?person - spot ?message - message)
    :precondition (and (person ?person) (robot-at ?person) (not (asleep ?person)))
    :effect (and (informed ?person) (told ?person ?message)))

  (:action light-on
    :parameters (?spot - spot)
    :precondition (and (lamp ?spot) (robot-at ?spot) (not (lit ?spot)))
    :effect (lit ?spot))

  (:action light-off
    :parameters (?spot - spot)
    :precondition (and (lamp ?spot) (robot-at ?spot) (lit ?spot))
    :effect (not (lit ?spot))))
