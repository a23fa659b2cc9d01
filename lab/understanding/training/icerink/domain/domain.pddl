; The robot of an ice rink. It carries skates and other gear, sharpens, resurfaces and cools, minds machines, gates, light
; and the game clock, calls people over the loudspeakers, and looks at ice and blades before it decides what to do.
(define (domain icerink)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types site gear - subject depth chill period)

  (:predicates
    ; what never changes
    (somebody ?site - site)
    (roomy ?site - site)                  ; gear can be left there
    (machine ?site - site)
    (gate ?site - site)
    (pad ?site - site)                    ; a sheet of ice
    (board ?site - site)                  ; has a game clock
    (scheme ?site - site)                 ; a scheme of light, not a place
    (skates ?gear - gear)
    ; how things are
    (robot-beside ?subject - subject)
    (kept ?gear - gear ?site - site)
    (hauling ?gear - gear)
    (turning ?site - site)
    (ajar ?site - site)
    (chilled ?pad - site ?chill - chill)
    (lit-in ?pad - site ?scheme - site)
    (clock ?board - site ?period - period)
    ; what only a look tells
    (smooth ?site - site)
    (rutted ?site - site)
    (watery ?site - site)
    (keen ?gear - gear)
    (blunt ?gear - gear)
    ; what happened
    (shaved ?pad - site)
    (ground ?gear - gear ?depth - depth)
    (announced ?site - site))

  (:action glide
    :parameters (?to - subject)
    :precondition (not (robot-beside ?to))
    :effect (and (forall (?from - subject) (not (robot-beside ?from))) (robot-beside ?to)))

  (:action fetch
    :parameters (?gear - gear ?from - site)
    :precondition (and (robot-beside ?from) (kept ?gear ?from) (forall (?other - gear) (not (hauling ?other))))
    :effect (and (hauling ?gear) (not (kept ?gear ?from))))

  (:action leave
    :parameters (?gear - gear ?to - site)
    :precondition (and (hauling ?gear) (robot-beside ?to) (or (roomy ?to) (somebody ?to)))
    :effect (and (kept ?gear ?to) (not (hauling ?gear))))

  (:action rev-up
    :parameters (?machine - site)
    :precondition (and (machine ?machine) (robot-beside ?machine) (not (turning ?machine)))
    :effect (turning ?machine))

  (:action wind-down
    :parameters (?machine - site)
    :precondition (and (machine ?machine) (robot-beside ?machine) (turning ?machine))
    :effect (not (turning ?machine)))

  (:action unlatch
    :parameters (?gate - site)
    :precondition (and (gate ?gate) (robot-beside ?gate) (not (ajar ?gate)))
    :effect (ajar ?gate))

  (:action latch
    :parameters (?gate - site)
    :precondition (and (gate ?gate) (robot-beside ?gate) (ajar ?gate))
    :effect (not (ajar ?gate)))

  (:action shave
    :parameters (?pad - site)
    :precondition (and (pad ?pad) (robot-beside ?pad))
    :effect (shaved ?pad))

  (:action chill
    :parameters (?pad - site ?chill - chill)
    :precondition (and (pad ?pad) (not (chilled ?pad ?chill)))
    :effect (and (forall (?other - chill) (not (chilled ?pad ?other))) (chilled ?pad ?chill)))

  (:action light-up
    :parameters (?pad - site ?scheme - site)
    :precondition (and (pad ?pad) (scheme ?scheme) (not (lit-in ?pad ?scheme)))
    :effect (and (forall (?other - site) (not (lit-in ?pad ?other))) (lit-in ?pad ?scheme)))

  (:action set-clock
    :parameters (?board - site ?period - period)
    :precondition (and (board ?board) (not (clock ?board ?period)))
    :effect (and (forall (?other - period) (not (clock ?board ?other))) (clock ?board ?period)))

  (:action grind
    :parameters (?gear - gear ?depth - depth ?where - site)
    :precondition (and (skates ?gear) (robot-beside ?where) (kept ?gear ?where))
    :effect (ground ?gear ?depth))

  (:action announce
    :parameters (?person - site)
    :precondition (somebody ?person)
    :effect (announced ?person))

  ; A walk along the boards is enough, and a thumb on the blade.
  (:action survey
    :parameters (?pad - site)
    :precondition (and (pad ?pad) (robot-beside ?pad))
    :effect (and))

  (:action thumb
    :parameters (?gear - gear ?where - site)
    :precondition (and (skates ?gear) (robot-beside ?where) (kept ?gear ?where))
    :effect (and)))
