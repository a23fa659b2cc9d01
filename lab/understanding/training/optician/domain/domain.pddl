; A robot in an optician's shop: it lays out and brings wares, polishes, tightens and tints glasses, sets trial frames,
; minds devices, doors and drawers, shows people to rooms, and looks at lenses and rooms before it decides what to do.
(define (domain optician)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types fixture ware - thing distance level)

  (:predicates
    ; what never changes
    (human ?fixture - fixture)
    (room ?fixture - fixture)
    (electric ?fixture - fixture)
    (audible ?fixture - fixture)         ; has a volume
    (openable ?fixture - fixture)
    (glassy ?thing - thing)              ; can be polished
    (lensed ?ware - ware)
    (screwed ?ware - ware)               ; has hinges and screws
    (trial ?ware - ware)
    (dye ?ware - ware)
    ; where things are and how they are
    (near ?thing - thing)
    (located ?ware - ware ?fixture - fixture)
    (gripped ?ware - ware)
    (powered ?fixture - fixture)
    (unclosed ?fixture - fixture)
    (spaced ?ware - ware ?distance - distance)
    (loud ?fixture - fixture ?level - level)
    ; what only a look tells
    (flawless ?ware - ware)
    (scratched ?ware - ware)
    (cracked ?ware - ware)
    (vacant ?fixture - fixture)
    (occupied ?fixture - fixture)
    ; what happened
    (polished ?thing - thing)
    (tightened ?ware - ware)
    (dyed ?ware - ware ?dye - ware)
    (labelled ?ware - ware ?human - fixture)
    (shown-to ?human - fixture ?room - fixture))

  (:action approach
    :parameters (?to - thing)
    :precondition (not (near ?to))
    :effect (and (forall (?from - thing) (not (near ?from))) (near ?to)))

  (:action grip
    :parameters (?ware - ware ?from - fixture)
    :precondition (and (near ?from) (located ?ware ?from) (imply (openable ?from) (unclosed ?from))
                       (forall (?other - ware) (not (gripped ?other))))
    :effect (and (gripped ?ware) (not (located ?ware ?from))))

  (:action set-down
    :parameters (?ware - ware ?to - fixture)
    :precondition (and (gripped ?ware) (near ?to) (imply (openable ?to) (unclosed ?to)))
    :effect (and (located ?ware ?to) (not (gripped ?ware))))

  (:action press-on
    :parameters (?device - fixture)
    :precondition (and (electric ?device) (near ?device) (not (powered ?device)))
    :effect (powered ?device))

  (:action press-off
    :parameters (?device - fixture)
    :precondition (and (electric ?device) (near ?device) (powered ?device))
    :effect (not (powered ?device)))

  (:action pull
    :parameters (?fixture - fixture)
    :precondition (and (openable ?fixture) (near ?fixture) (not (unclosed ?fixture)))
    :effect (unclosed ?fixture))

  (:action push
    :parameters (?fixture - fixture)
    :precondition (and (openable ?fixture) (near ?fixture) (unclosed ?fixture))
    :effect (not (unclosed ?fixture)))

  (:action rub
    :parameters (?thing - thing)
    :precondition (and (glassy ?thing) (near ?thing))
    :effect (polished ?thing))

  (:action turn-screws
    :parameters (?ware - ware)
    :precondition (and (screwed ?ware) (near ?ware))
    :effect (tightened ?ware))

  (:action dip
    :parameters (?ware - ware ?dye - ware)
    :precondition (and (lensed ?ware) (dye ?dye) (near ?ware))
    :effect (dyed ?ware ?dye))

  (:action slide
    :parameters (?ware - ware ?distance - distance)
    :precondition (and (trial ?ware) (near ?ware) (not (spaced ?ware ?distance)))
    :effect (and (forall (?other - distance) (not (spaced ?ware ?other))) (spaced ?ware ?distance)))

  (:action turn-knob
    :parameters (?device - fixture ?level - level)
    :precondition (and (audible ?device) (near ?device) (not (loud ?device ?level)))
    :effect (and (forall (?other - level) (not (loud ?device ?other))) (loud ?device ?level)))

  (:action label
    :parameters (?ware - ware ?human - fixture)
    :precondition (and (human ?human) (near ?ware))
    :effect (labelled ?ware ?human))

  (:action show-to
    :parameters (?human - fixture ?room - fixture)
    :precondition (and (human ?human) (room ?room) (near ?human))
    :effect (shown-to ?human ?room))

  ; It is enough to stand before the thing or the door.
  (:action examine-lenses
    :parameters (?ware - ware)
    :precondition (and (lensed ?ware) (near ?ware))
    :effect (and))

  (:action knock
    :parameters (?fixture - fixture)
    :precondition (and (room ?fixture) (near ?fixture))
    :effect (and)))
