; A post office robot: it files, leaves and delivers letters and parcels, weighs, franks, stamps and labels them, announces, locks and switches.
(define (domain postoffice)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing weight message)

  (:predicates
    (person ?spot - spot)
    (opens ?spot - spot)                    ; a cabinet, a safe, a door, a window
    (lockable ?spot - spot)
    (has-top ?spot - spot)
    (device ?spot - spot)
    (scales ?spot - spot)
    (franks ?spot - spot)                   ; a franking machine
    (mail ?item - item)                     ; a letter, a parcel
    (stamp ?item - item)                    ; a rubber stamp
    (at ?item - item ?spot - spot)
    (atop ?item - item ?spot - spot)
    (beside ?item - item ?thing - thing)
    (holding ?item - item)
    (open ?spot - spot)
    (locked ?spot - spot)
    (on ?spot - spot)
    ; what happened
    (weighed ?item - item ?scales - spot)
    (franked ?item - item ?weight - weight)
    (stamped ?item - item ?stamp - item)
    (labelled ?item - item ?message - message)
    (announced ?message - message))

  (:action take
    :parameters (?item - item)
    :precondition (and (forall (?other - item) (not (holding ?other)))
                       (forall (?spot - spot) (imply (and (at ?item ?spot) (opens ?spot)) (open ?spot))))
    :effect (and (holding ?item)
                 (forall (?spot - spot) (and (not (at ?item ?spot)) (not (atop ?item ?spot))))
                 (forall (?thing - thing) (not (beside ?item ?thing)))))

  (:action set-down
    :parameters (?item - item ?spot - spot)
    :precondition (and (holding ?item) (imply (opens ?spot) (open ?spot)))
    :effect (and (at ?item ?spot) (not (holding ?item))))

  (:action lift-onto
    :parameters (?item - item ?spot - spot)
    :precondition (and (holding ?item) (has-top ?spot))
    :effect (and (atop ?item ?spot) (not (holding ?item))))

  (:action stand-beside
    :parameters (?item - item ?thing - thing)
    :precondition (and (holding ?item) (not (= ?item ?thing)))
    :effect (and (beside ?item ?thing) (not (holding ?item))))

  (:action weigh
    :parameters (?item - item ?scales - spot)
    :precondition (and (holding ?item) (scales ?scales))
    :effect (weighed ?item ?scales))

  (:action frank
    :parameters (?item - item ?machine - spot ?weight - weight)
    :precondition (and (holding ?item) (mail ?item) (franks ?machine))
    :effect (franked ?item ?weight))

  (:action use-stamp
    :parameters (?stamp - item ?item - item)
    :precondition (and (holding ?stamp) (stamp ?stamp) (mail ?item)
                       (forall (?spot - spot) (imply (and (at ?item ?spot) (opens ?spot)) (open ?spot))))
    :effect (stamped ?item ?stamp))

  (:action stick-label
    :parameters (?item - item ?message - message)
    :precondition (and (holding ?item) (mail ?item))
    :effect (labelled ?item ?message))

  (:action announce
    :parameters (?message - message)
    :precondition (and)
    :effect (announced ?message))

  (:action switch-on
    :parameters (?device - spot)
    :precondition (and (device ?device) (not (on ?device)))
    :effect (on ?device))

  (:action switch-off
    :parameters (?device - spot)
    :precondition (and (device ?device) (on ?device))
    :effect (not (on ?device)))

  (:action unlock
    :parameters (?spot - spot)
    :precondition (and (lockable ?spot) (locked ?spot))
    :effect (not (locked ?spot)))

  (:action lock
    :parameters (?spot - spot)
    :precondition (and (lockable ?spot) (not (open ?spot)) (not (locked ?spot)))
    :effect (locked ?spot))

  (:action open-up
    :parameters (?spot - spot)
    :precondition (and (opens ?spot) (not (open ?spot)) (not (locked ?spot)))
    :effect (open ?spot))

  (:action close
    :parameters (?spot - spot)
    :precondition (and (opens ?spot) (open ?spot))
    :effect (not (open ?spot))))
