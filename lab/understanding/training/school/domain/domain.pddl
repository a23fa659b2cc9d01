; A school robot: it carries things, wipes and writes on boards, stamps papers, switches devices, opens windows and doors, speaks to people.
(define (domain school)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing text)

  (:predicates
    (person ?spot - spot)
    (board ?spot - spot)
    (device ?spot - spot)
    (opening ?spot - spot)
    (storage ?spot - spot)                  ; things lie behind its door
    (paper ?item - item)
    (stamp ?item - item)
    (robot-at ?spot - spot)
    (at ?item - item ?spot - spot)
    (holding ?item - item)
    (on ?spot - spot)
    (open ?spot - spot)
    (reads ?spot - spot ?text - text)
    ; what happened
    (wiped ?spot - spot)
    (stamped ?item - item ?stamp - item)
    (addressed ?spot - spot))

  (:action go
    :parameters (?to - spot)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to)))

  (:action take
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (at ?item ?from) (imply (storage ?from) (open ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action leave
    :parameters (?item - item ?to - spot)
    :precondition (and (holding ?item) (robot-at ?to) (imply (storage ?to) (open ?to)))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action wipe
    :parameters (?board - spot)
    :precondition (and (board ?board) (robot-at ?board))
    :effect (and (wiped ?board) (forall (?text - text) (not (reads ?board ?text)))))

  (:action write
    :parameters (?board - spot ?text - text)
    :precondition (and (board ?board) (robot-at ?board))
    :effect (reads ?board ?text))

  (:action press
    :parameters (?stamp - item ?item - item ?spot - spot)
    :precondition (and (stamp ?stamp) (paper ?item) (holding ?stamp) (robot-at ?spot) (at ?item ?spot)
                       (imply (storage ?spot) (open ?spot)))
    :effect (stamped ?item ?stamp))

  (:action start
    :parameters (?device - spot)
    :precondition (and (device ?device) (robot-at ?device) (not (on ?device)))
    :effect (on ?device))

  (:action stop
    :parameters (?device - spot)
    :precondition (and (device ?device) (robot-at ?device) (on ?device))
    :effect (not (on ?device)))

  (:action unclose
    :parameters (?opening - spot)
    :precondition (and (opening ?opening) (robot-at ?opening) (not (open ?opening)))
    :effect (open ?opening))

  (:action close
    :parameters (?opening - spot)
    :precondition (and (opening ?opening) (robot-at ?opening) (open ?opening))
    :effect (not (open ?opening)))

  (:action address
    :parameters (?person - spot)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (addressed ?person)))
