; A robot in a library: it files and fetches things, lends, renews and mends books, minds locks and devices, and passes words on.
(define (domain library)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing period message)

  (:predicates
    (person ?spot - spot)
    (device ?spot - spot)
    (lockable ?spot - spot)
    (loanable ?item - item)
    (supply ?item - item)
    (robot-at ?spot - spot)
    (at ?item - item ?spot - spot)
    (holding ?item - item)
    (powered ?spot - spot)
    (locked ?spot - spot)
    (borrowed ?item - item ?reader - spot)
    ; what happened
    (renewed ?item - item ?period - period)
    (mended ?item - item ?supply - item)
    (told ?person - spot ?message - message))

  (:action drive
    :parameters (?to - spot)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (at ?item ?from)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action lay
    :parameters (?item - item ?to - spot)
    :precondition (and (holding ?item) (robot-at ?to))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action lend
    :parameters (?item - item ?reader - spot)
    :precondition (and (loanable ?item) (person ?reader) (not (borrowed ?item ?reader)))
    :effect (borrowed ?item ?reader))

  (:action extend
    :parameters (?item - item ?period - period)
    :precondition (loanable ?item)
    :effect (renewed ?item ?period))

  (:action mend
    :parameters (?item - item ?supply - item ?where - spot)
    :precondition (and (supply ?supply) (holding ?supply) (not (supply ?item)) (robot-at ?where) (at ?item ?where))
    :effect (mended ?item ?supply))

  (:action lock
    :parameters (?spot - spot)
    :precondition (and (lockable ?spot) (robot-at ?spot) (not (locked ?spot)))
    :effect (locked ?spot))

  (:action unlock
    :parameters (?spot - spot)
    :precondition (and (lockable ?spot) (robot-at ?spot) (locked ?spot))
    :effect (not (locked ?spot)))

  (:action power-up
    :parameters (?device - spot)
    :precondition (and (device ?device) (robot-at ?device) (not (powered ?device)))
    :effect (powered ?device))

  (:action power-down
    :parameters (?device - spot)
    :precondition (and (device ?device) (robot-at ?device) (powered ?device))
    :effect (not (powered ?device)))

  (:action say
    :parameters (?person - spot ?message - message)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (told ?person ?message)))
