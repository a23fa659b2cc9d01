; A ground robot at an airport: it moves luggage and carts, guides passengers, works doors and screens, checks luggage.
(define (domain airport)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing message)

  (:predicates
    (door ?spot - spot)
    (screen ?spot - spot)
    (person ?item - item)
    (cart ?item - item)
    (device ?item - item)                   ; a scanner, a scale
    (robot-at ?spot - spot)
    (at ?item - item ?spot - spot)
    (on ?item - item ?cart - item)
    (holding ?item - item)
    (open ?spot - spot)
    (locked ?spot - spot)
    (shows ?spot - spot ?message - message)
    ; what happened
    (examined ?item - item ?device - item))

  (:action go
    :parameters (?to - spot)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to)))

  (:action take
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (at ?item ?from) (not (person ?item)) (not (cart ?item))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action leave
    :parameters (?item - item ?to - spot)
    :precondition (and (holding ?item) (robot-at ?to))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action load
    :parameters (?item - item ?cart - item ?spot - spot)
    :precondition (and (holding ?item) (cart ?cart) (robot-at ?spot) (at ?cart ?spot))
    :effect (and (on ?item ?cart) (not (holding ?item))))

  (:action unload
    :parameters (?item - item ?cart - item ?spot - spot)
    :precondition (and (on ?item ?cart) (robot-at ?spot) (at ?cart ?spot)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (on ?item ?cart))))

  ; A cart is pushed, a person is walked with; both need free hands.
  (:action lead
    :parameters (?item - item ?from - spot ?to - spot)
    :precondition (and (or (person ?item) (cart ?item)) (robot-at ?from) (at ?item ?from) (not (= ?from ?to))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (at ?item ?to) (not (at ?item ?from)) (robot-at ?to) (not (robot-at ?from))))

  (:action examine
    :parameters (?item - item ?device - item ?spot - spot)
    :precondition (and (device ?device) (holding ?device) (robot-at ?spot) (at ?item ?spot) (not (person ?item)))
    :effect (examined ?item ?device))

  (:action open-door
    :parameters (?door - spot)
    :precondition (and (door ?door) (robot-at ?door) (not (open ?door)) (not (locked ?door)))
    :effect (open ?door))

  (:action close-door
    :parameters (?door - spot)
    :precondition (and (door ?door) (robot-at ?door) (open ?door))
    :effect (not (open ?door)))

  (:action lock
    :parameters (?door - spot)
    :precondition (and (door ?door) (robot-at ?door) (not (open ?door)) (not (locked ?door)))
    :effect (locked ?door))

  (:action unlock
    :parameters (?door - spot)
    :precondition (and (door ?door) (robot-at ?door) (locked ?door))
    :effect (not (locked ?door)))

  (:action show
    :parameters (?screen - spot ?message - message)
    :precondition (and (screen ?screen) (not (shows ?screen ?message)))
    :effect (and (forall (?other - message) (not (shows ?screen ?other))) (shows ?screen ?message))))
