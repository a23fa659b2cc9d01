; A supermarket robot: it restocks shelves and freezers, fetches goods, changes price labels, opens tills, helps customers.
(define (domain supermarket)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item - thing price)

  (:predicates
    (person ?place - place)
    (till ?place - place)
    (cold ?place - place)                   ; reached only while it is open
    (openable ?place - place)
    (bin ?place - place)
    (tool ?item - item)                     ; a mop, a cloth, a broom
    (robot-at ?place - place)
    (at ?item - item ?place - place)
    (holding ?item - item)
    (open ?place - place)
    (costs ?item - item ?price - price)
    ; what happened
    (discarded ?item - item)
    (scanned ?item - item ?till - place)
    (cleaned ?place - place ?tool - item)
    (attended ?person - place))

  (:action go
    :parameters (?to - place)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - place) (not (robot-at ?from))) (robot-at ?to)))

  (:action take
    :parameters (?item - item ?from - place)
    :precondition (and (robot-at ?from) (at ?item ?from) (imply (cold ?from) (open ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action put
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (imply (cold ?to) (open ?to)))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action open-up
    :parameters (?place - place)
    :precondition (and (openable ?place) (robot-at ?place) (not (open ?place)))
    :effect (open ?place))

  (:action shut
    :parameters (?place - place)
    :precondition (and (openable ?place) (robot-at ?place) (open ?place))
    :effect (not (open ?place)))

  (:action label
    :parameters (?item - item ?place - place ?price - price)
    :precondition (and (robot-at ?place) (at ?item ?place) (not (costs ?item ?price)))
    :effect (and (forall (?other - price) (not (costs ?item ?other))) (costs ?item ?price)))

  (:action scan
    :parameters (?item - item ?till - place)
    :precondition (and (till ?till) (open ?till) (robot-at ?till) (holding ?item))
    :effect (scanned ?item ?till))

  (:action discard
    :parameters (?item - item ?bin - place)
    :precondition (and (bin ?bin) (robot-at ?bin) (holding ?item))
    :effect (and (discarded ?item) (at ?item ?bin) (not (holding ?item))))

  (:action clean
    :parameters (?place - place ?tool - item)
    :precondition (and (tool ?tool) (holding ?tool) (robot-at ?place) (not (person ?place)))
    :effect (cleaned ?place ?tool))

  (:action attend
    :parameters (?person - place)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (attended ?person)))
