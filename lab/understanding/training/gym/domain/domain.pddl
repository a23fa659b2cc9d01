; A fitness studio robot: it racks and hands over kit, wipes things down, locks lockers, switches devices and sets treadmills and fans.
(define (domain gym)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing speed level)

  (:predicates
    (person ?spot - spot)
    (lockable ?spot - spot)
    (has-roof ?spot - spot)                 ; things can go on top of it
    (powered ?spot - spot)                  ; has a switch
    (treadmill ?spot - spot)
    (fan ?spot - spot)
    (wipeable ?thing - thing)
    (at ?item - item ?spot - spot)
    (above ?item - item ?spot - spot)
    (near ?item - item ?thing - thing)
    (carried ?item - item)
    (locked ?spot - spot)
    (on ?spot - spot)
    (runs-at ?spot - spot ?speed - speed)
    (blows-at ?spot - spot ?level - level)
    ; what happened
    (wiped ?thing - thing))

  (:action pick-up
    :parameters (?item - item)
    :precondition (and (forall (?other - item) (not (carried ?other)))
                       (forall (?spot - spot) (imply (at ?item ?spot) (not (locked ?spot)))))
    :effect (and (carried ?item)
                 (forall (?spot - spot) (and (not (at ?item ?spot)) (not (above ?item ?spot))))
                 (forall (?thing - thing) (not (near ?item ?thing)))))

  (:action rack
    :parameters (?item - item ?spot - spot)
    :precondition (and (carried ?item) (not (person ?spot)) (not (locked ?spot)))
    :effect (and (at ?item ?spot) (not (carried ?item))))

  (:action heave-above
    :parameters (?item - item ?spot - spot)
    :precondition (and (carried ?item) (has-roof ?spot))
    :effect (and (above ?item ?spot) (not (carried ?item))))

  (:action flank
    :parameters (?item - item ?thing - thing)
    :precondition (and (carried ?item) (not (= ?item ?thing)))
    :effect (and (near ?item ?thing) (not (carried ?item))))

  (:action supply
    :parameters (?person - spot ?item - item)
    :precondition (and (carried ?item) (person ?person))
    :effect (and (at ?item ?person) (not (carried ?item))))

  (:action wipe
    :parameters (?thing - thing)
    :precondition (wipeable ?thing)
    :effect (wiped ?thing))

  (:action turn-on
    :parameters (?device - spot)
    :precondition (and (powered ?device) (not (on ?device)))
    :effect (on ?device))

  (:action turn-off
    :parameters (?device - spot)
    :precondition (and (powered ?device) (on ?device))
    :effect (not (on ?device)))

  (:action set-speed
    :parameters (?treadmill - spot ?speed - speed)
    :precondition (and (treadmill ?treadmill) (on ?treadmill) (not (runs-at ?treadmill ?speed)))
    :effect (and (forall (?other - speed) (not (runs-at ?treadmill ?other))) (runs-at ?treadmill ?speed)))

  (:action set-level
    :parameters (?fan - spot ?level - level)
    :precondition (and (fan ?fan) (on ?fan) (not (blows-at ?fan ?level)))
    :effect (and (forall (?other - level) (not (blows-at ?fan ?other))) (blows-at ?fan ?level)))

  (:action unlock
    :parameters (?spot - spot)
    :precondition (and (lockable ?spot) (locked ?spot))
    :effect (not (locked ?spot)))

  (:action lock
    :parameters (?spot - spot)
    :precondition (and (lockable ?spot) (not (locked ?spot)))
    :effect (locked ?spot)))
