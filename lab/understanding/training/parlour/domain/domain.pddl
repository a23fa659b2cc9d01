; An ice-cream parlour robot: it lodges things in, on and by others, serves, scoops and tops ices, times and switches machines, opens, wipes and chalks.
(define (domain parlour)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types fixture ware - thing scoops duration text)

  (:predicates
    (person ?fixture - fixture)
    (roomy ?fixture - fixture)              ; things go inside
    (topped-off ?fixture - fixture)         ; things stand on it
    (opens ?fixture - fixture)              ; a freezer, a door, an awning
    (device ?fixture - fixture)
    (timer ?fixture - fixture)              ; runs for a time: a waffle iron, a blender
    (board ?fixture - fixture)
    (washable ?thing - thing)
    (flavour ?ware - ware)                  ; a tub of ice cream
    (dish ?ware - ware)                     ; a cup, a cone, a bowl
    (topping ?ware - ware)
    (inside ?ware - ware ?fixture - fixture)
    (upon ?ware - ware ?fixture - fixture)
    (by ?ware - ware ?thing - thing)
    (has ?person - fixture ?ware - ware)
    (holding ?ware - ware)
    (open ?fixture - fixture)
    (on ?fixture - fixture)
    ; what happened
    (scooped ?dish - ware ?tub - ware ?scoops - scoops)
    (garnished ?dish - ware ?topping - ware)
    (ran ?machine - fixture ?duration - duration)
    (chalked ?board - fixture ?text - text)
    (wiped ?thing - thing))

  (:action pick-up
    :parameters (?ware - ware)
    :precondition (and (forall (?other - ware) (not (holding ?other)))
                       (forall (?fixture - fixture) (imply (and (inside ?ware ?fixture) (opens ?fixture)) (open ?fixture))))
    :effect (and (holding ?ware)
                 (forall (?fixture - fixture) (and (not (inside ?ware ?fixture)) (not (upon ?ware ?fixture)) (not (has ?fixture ?ware))))
                 (forall (?thing - thing) (not (by ?ware ?thing)))))

  (:action lay-in
    :parameters (?ware - ware ?fixture - fixture)
    :precondition (and (holding ?ware) (roomy ?fixture) (imply (opens ?fixture) (open ?fixture)))
    :effect (and (inside ?ware ?fixture) (not (holding ?ware))))

  (:action lay-on
    :parameters (?ware - ware ?fixture - fixture)
    :precondition (and (holding ?ware) (topped-off ?fixture))
    :effect (and (upon ?ware ?fixture) (not (holding ?ware))))

  (:action lay-by
    :parameters (?ware - ware ?thing - thing)
    :precondition (and (holding ?ware) (not (= ?ware ?thing)))
    :effect (and (by ?ware ?thing) (not (holding ?ware))))

  (:action serve
    :parameters (?ware - ware ?person - fixture)
    :precondition (and (holding ?ware) (person ?person))
    :effect (and (has ?person ?ware) (not (holding ?ware))))

  (:action scoop
    :parameters (?dish - ware ?tub - ware ?scoops - scoops)
    :precondition (and (holding ?dish) (dish ?dish) (flavour ?tub)
                       (forall (?fixture - fixture) (imply (and (inside ?tub ?fixture) (opens ?fixture)) (open ?fixture))))
    :effect (scooped ?dish ?tub ?scoops))

  (:action garnish
    :parameters (?dish - ware ?topping - ware)
    :precondition (and (holding ?topping) (dish ?dish) (topping ?topping)
                       (forall (?fixture - fixture) (imply (and (inside ?dish ?fixture) (opens ?fixture)) (open ?fixture))))
    :effect (garnished ?dish ?topping))

  (:action run-for
    :parameters (?machine - fixture ?duration - duration)
    :precondition (timer ?machine)
    :effect (ran ?machine ?duration))

  (:action chalk
    :parameters (?board - fixture ?text - text)
    :precondition (board ?board)
    :effect (chalked ?board ?text))

  (:action wipe
    :parameters (?thing - thing)
    :precondition (washable ?thing)
    :effect (wiped ?thing))

  (:action switch-on
    :parameters (?device - fixture)
    :precondition (and (device ?device) (not (on ?device)))
    :effect (on ?device))

  (:action switch-off
    :parameters (?device - fixture)
    :precondition (and (device ?device) (on ?device))
    :effect (not (on ?device)))

  (:action open-up
    :parameters (?fixture - fixture)
    :precondition (and (opens ?fixture) (not (open ?fixture)))
    :effect (open ?fixture))

  (:action close-up
    :parameters (?fixture - fixture)
    :precondition (and (opens ?fixture) (open ?fixture))
    :effect (not (open ?fixture))))
