; A robot in a toy shop: it puts toys where they belong, gives them to people, gift-wraps and prices them, changes
; batteries, minds displays and music, and tries toys and counts pieces before it decides what to do with them.
(define (domain toyshop)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types fixture ware - thing price level)

  (:predicates
    ; what never changes
    (human ?fixture - fixture)
    (display ?thing - thing)                ; wares can be put there
    (closable ?thing - thing)
    (switchable ?thing - thing)
    (player ?fixture - fixture)
    (paper ?fixture - fixture)              ; a kind of gift wrap
    (toy ?ware - ware)
    (electric ?ware - ware)
    (set-of-parts ?ware - ware)
    ; where things are and how they are
    (robot-by ?thing - thing)
    (located ?ware - ware ?thing - thing)
    (in-arms ?ware - ware)
    (ajar ?thing - thing)
    (live ?thing - thing)
    (tagged ?ware - ware ?price - price)
    (loud ?fixture - fixture ?level - level)
    ; what only a look tells
    (works ?ware - ware)
    (drained ?ware - ware)
    (broken ?ware - ware)
    (complete ?ware - ware)
    (incomplete ?ware - ware)
    ; what happened
    (wrapped ?ware - ware ?paper - fixture)
    (refreshed ?ware - ware)
    (dusted ?thing - thing)
    (informed ?human - fixture ?thing - thing))

  (:action roll-to
    :parameters (?to - thing)
    :precondition (not (robot-by ?to))
    :effect (and (forall (?from - thing) (not (robot-by ?from))) (robot-by ?to)))

  (:action pick
    :parameters (?ware - ware ?from - thing)
    :precondition (and (robot-by ?from) (located ?ware ?from) (forall (?other - ware) (not (in-arms ?other))))
    :effect (and (in-arms ?ware) (not (located ?ware ?from))))

  (:action arrange
    :parameters (?ware - ware ?to - thing)
    :precondition (and (in-arms ?ware) (robot-by ?to) (display ?to) (not (= ?ware ?to)))
    :effect (and (located ?ware ?to) (not (in-arms ?ware))))

  (:action offer
    :parameters (?ware - ware ?human - fixture)
    :precondition (and (in-arms ?ware) (robot-by ?human) (human ?human))
    :effect (and (located ?ware ?human) (not (in-arms ?ware))))

  (:action wrap
    :parameters (?ware - ware ?paper - fixture)
    :precondition (and (toy ?ware) (paper ?paper) (robot-by ?ware))
    :effect (wrapped ?ware ?paper))

  (:action price-tag
    :parameters (?ware - ware ?price - price)
    :precondition (and (toy ?ware) (robot-by ?ware) (not (tagged ?ware ?price)))
    :effect (and (forall (?other - price) (not (tagged ?ware ?other))) (tagged ?ware ?price)))

  (:action open-up
    :parameters (?thing - thing)
    :precondition (and (closable ?thing) (robot-by ?thing) (not (ajar ?thing)))
    :effect (ajar ?thing))

  (:action close-up
    :parameters (?thing - thing)
    :precondition (and (closable ?thing) (robot-by ?thing) (ajar ?thing))
    :effect (not (ajar ?thing)))

  (:action flick-on
    :parameters (?thing - thing)
    :precondition (and (switchable ?thing) (robot-by ?thing) (not (live ?thing)))
    :effect (live ?thing))

  (:action flick-off
    :parameters (?thing - thing)
    :precondition (and (switchable ?thing) (robot-by ?thing) (live ?thing))
    :effect (not (live ?thing)))

  (:action turn-knob
    :parameters (?player - fixture ?level - level)
    :precondition (and (player ?player) (robot-by ?player) (not (loud ?player ?level)))
    :effect (and (forall (?other - level) (not (loud ?player ?other))) (loud ?player ?level)))

  (:action change-batteries
    :parameters (?ware - ware)
    :precondition (and (electric ?ware) (robot-by ?ware))
    :effect (refreshed ?ware))

  (:action dust
    :parameters (?thing - thing)
    :precondition (robot-by ?thing)
    :effect (dusted ?thing))

  (:action inform
    :parameters (?human - fixture ?thing - thing)
    :precondition (and (human ?human) (robot-by ?human))
    :effect (informed ?human ?thing))

  ; It is enough to stand in front of the toy.
  (:action try-out
    :parameters (?ware - ware)
    :precondition (and (electric ?ware) (robot-by ?ware))
    :effect (and))

  (:action count-pieces
    :parameters (?ware - ware)
    :precondition (and (set-of-parts ?ware) (robot-by ?ware))
    :effect (and)))
