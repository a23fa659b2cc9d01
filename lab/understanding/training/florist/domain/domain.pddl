; A flower shop robot: it keeps flowers in buckets, vases and crates, hands them over, ties ribbons, writes cards, mists, opens, closes and switches.
(define (domain florist)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing wording)

  (:predicates
    (person ?spot - spot)
    (opens ?spot - spot)                    ; a door, a drawer, a crate with a lid
    (has-top ?spot - spot)
    (device ?spot - spot)
    (bouquet ?item - item)                  ; takes a ribbon and a card
    (ribbon ?item - item)
    (fresh ?item - item)                    ; likes to be misted
    (at ?item - item ?spot - spot)
    (atop ?item - item ?spot - spot)
    (by ?item - item ?thing - thing)
    (holding ?item - item)
    (open ?spot - spot)
    (on ?spot - spot)
    ; what happened
    (tied ?bouquet - item ?ribbon - item)
    (carded ?bouquet - item ?wording - wording)
    (misted ?item - item))

  (:action pick
    :parameters (?item - item)
    :precondition (and (forall (?other - item) (not (holding ?other)))
                       (forall (?spot - spot) (imply (and (at ?item ?spot) (opens ?spot)) (open ?spot))))
    :effect (and (holding ?item)
                 (forall (?spot - spot) (and (not (at ?item ?spot)) (not (atop ?item ?spot))))
                 (forall (?thing - thing) (not (by ?item ?thing)))))

  (:action place
    :parameters (?item - item ?spot - spot)
    :precondition (and (holding ?item) (imply (opens ?spot) (open ?spot)))
    :effect (and (at ?item ?spot) (not (holding ?item))))

  (:action perch
    :parameters (?item - item ?spot - spot)
    :precondition (and (holding ?item) (has-top ?spot))
    :effect (and (atop ?item ?spot) (not (holding ?item))))

  (:action stand-by
    :parameters (?item - item ?thing - thing)
    :precondition (and (holding ?item) (not (= ?item ?thing)))
    :effect (and (by ?item ?thing) (not (holding ?item))))

  (:action tie
    :parameters (?ribbon - item ?bouquet - item)
    :precondition (and (holding ?ribbon) (ribbon ?ribbon) (bouquet ?bouquet)
                       (forall (?spot - spot) (imply (and (at ?bouquet ?spot) (opens ?spot)) (open ?spot))))
    :effect (tied ?bouquet ?ribbon))

  (:action write-card
    :parameters (?bouquet - item ?wording - wording)
    :precondition (and (holding ?bouquet) (bouquet ?bouquet))
    :effect (carded ?bouquet ?wording))

  (:action mist
    :parameters (?item - item)
    :precondition (and (fresh ?item)
                       (forall (?spot - spot) (imply (and (at ?item ?spot) (opens ?spot)) (open ?spot))))
    :effect (misted ?item))

  (:action switch-on
    :parameters (?device - spot)
    :precondition (and (device ?device) (not (on ?device)))
    :effect (on ?device))

  (:action switch-off
    :parameters (?device - spot)
    :precondition (and (device ?device) (on ?device))
    :effect (not (on ?device)))

  (:action open-up
    :parameters (?spot - spot)
    :precondition (and (opens ?spot) (not (open ?spot)))
    :effect (open ?spot))

  (:action close
    :parameters (?spot - spot)
    :precondition (and (opens ?spot) (open ?spot))
    :effect (not (open ?spot))))
