; A home system with a kitchen arm: devices that are switched, doors that are locked, dishes that are heated.
(define (domain home)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types device item colour - thing temperature duration message)

  (:constants red green blue orange warm_white - colour)

  (:predicates
    (switchable ?device - device)
    (light ?device - device)
    (heater ?device - device)                ; a microwave, an oven
    (brewer ?device - device)                ; a coffee machine
    (openable ?device - device)
    (lockable ?device - device)
    (alarm ?device - device)
    (thermostat ?device - device)
    (phone ?device - device)                 ; a person's phone, or a speaker in a room
    (on ?device - device)
    (open ?device - device)
    (locked ?device - device)
    (armed ?device - device)
    (colour-of ?device - device ?colour - colour)
    (at ?item - item ?device - device)
    (cup ?item - item)
    (set-to ?device - device ?temperature - temperature)
    ; what happened
    (warmed ?device - device)
    (cooled ?device - device)
    (heated ?item - item ?device - device)
    (heated-for ?item - item ?device - device ?duration - duration)
    (brewed ?item - item)
    (notified ?device - device)
    (sent ?device - device ?message - message))

  (:action switch-on
    :parameters (?device - device)
    :precondition (and (switchable ?device) (not (on ?device)))
    :effect (on ?device))

  (:action switch-off
    :parameters (?device - device)
    :precondition (and (switchable ?device) (on ?device))
    :effect (not (on ?device)))

  (:action set-colour
    :parameters (?device - device ?colour - colour)
    :precondition (and (light ?device) (on ?device) (not (colour-of ?device ?colour)))
    :effect (and (forall (?other - colour) (not (colour-of ?device ?other)))
                 (colour-of ?device ?colour)))

  (:action warm
    :parameters (?device - device)
    :precondition (thermostat ?device)
    :effect (warmed ?device))

  (:action cool
    :parameters (?device - device)
    :precondition (thermostat ?device)
    :effect (cooled ?device))

  (:action set
    :parameters (?device - device ?temperature - temperature)
    :precondition (and (thermostat ?device) (not (set-to ?device ?temperature)))
    :effect (and (forall (?other - temperature) (not (set-to ?device ?other))) (set-to ?device ?temperature)))

  (:action open
    :parameters (?device - device)
    :precondition (and (openable ?device) (not (open ?device)) (not (locked ?device)))
    :effect (open ?device))

  (:action close
    :parameters (?device - device)
    :precondition (and (openable ?device) (open ?device))
    :effect (not (open ?device)))

  (:action lock
    :parameters (?device - device)
    :precondition (and (lockable ?device) (not (open ?device)) (not (locked ?device)))
    :effect (locked ?device))

  (:action unlock
    :parameters (?device - device)
    :precondition (and (lockable ?device) (locked ?device)
                       (forall (?alarm - device) (not (armed ?alarm))))
    :effect (not (locked ?device)))

  (:action arm
    :parameters (?device - device)
    :precondition (and (alarm ?device) (not (armed ?device))
                       (forall (?door - device) (imply (lockable ?door) (locked ?door))))
    :effect (armed ?device))

  (:action disarm
    :parameters (?device - device)
    :precondition (and (alarm ?device) (armed ?device))
    :effect (not (armed ?device)))

  ; The kitchen arm reaches into what is open, and into what has no door.
  (:action carry
    :parameters (?item - item ?from - device ?to - device)
    :precondition (and (at ?item ?from) (not (= ?from ?to))
                       (imply (openable ?from) (open ?from))
                       (imply (openable ?to) (open ?to)))
    :effect (and (at ?item ?to) (not (at ?item ?from))))

  (:action heat
    :parameters (?item - item ?device - device)
    :precondition (and (heater ?device) (at ?item ?device) (not (open ?device)))
    :effect (heated ?item ?device))

  (:action heat-for
    :parameters (?item - item ?device - device ?duration - duration)
    :precondition (and (heater ?device) (at ?item ?device) (not (open ?device)))
    :effect (and (heated ?item ?device) (heated-for ?item ?device ?duration)))

  (:action brew
    :parameters (?item - item ?device - device)
    :precondition (and (brewer ?device) (on ?device) (cup ?item) (at ?item ?device))
    :effect (brewed ?item))

  (:action notify
    :parameters (?device - device)
    :precondition (phone ?device)
    :effect (notified ?device))

  (:action send
    :parameters (?device - device ?message - message)
    :precondition (phone ?device)
    :effect (and (notified ?device) (sent ?device ?message))))
