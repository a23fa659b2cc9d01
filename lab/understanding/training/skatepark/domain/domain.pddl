; The robot of a youth club with a skate park, a games room and a snack counter: it carries gear and snacks, minds
; hatches, gadgets and music, looks after boards and ramps, and looks at these before it decides what to do.
(define (domain skatepark)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot gear - thing genre degrees minutes)
  (:constants punk hip_hop reggae lo_fi - genre)

  (:predicates
    ; what never changes
    (guest ?spot - spot)
    (gadget ?spot - spot)
    (player ?spot - spot)                   ; plays music
    (console ?spot - spot)
    (cooler ?spot - spot)
    (hinged ?spot - spot)
    (ramp ?spot - spot)
    (board ?gear - gear)
    (snack ?gear - gear)
    ; where things are and how they are
    (robot-at ?spot - spot)
    (at ?gear - gear ?spot - spot)
    (holding ?gear - gear)
    (powered ?spot - spot)
    (ajar ?spot - spot)
    (playing ?spot - spot ?genre - genre)
    (cold ?spot - spot ?degrees - degrees)
    ; what only a look tells
    (dry ?spot - spot)
    (wet ?spot - spot)
    (littered ?spot - spot)
    (sound ?gear - gear)
    (cracked ?gear - gear)
    ; what happened
    (swept ?spot - spot)
    (tight ?gear - gear)
    (toasted ?gear - gear)
    (timed ?spot - spot ?minutes - minutes)
    (fetched ?spot - spot))

  (:action skate-to
    :parameters (?to - spot)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?gear - gear ?from - spot)
    :precondition (and (robot-at ?from) (at ?gear ?from) (forall (?other - gear) (not (holding ?other))))
    :effect (and (holding ?gear) (not (at ?gear ?from))))

  (:action lay-down
    :parameters (?gear - gear ?to - spot)
    :precondition (and (holding ?gear) (robot-at ?to) (not (guest ?to)))
    :effect (and (at ?gear ?to) (not (holding ?gear))))

  (:action pass-to
    :parameters (?gear - gear ?guest - spot)
    :precondition (and (holding ?gear) (robot-at ?guest) (guest ?guest))
    :effect (and (at ?gear ?guest) (not (holding ?gear))))

  (:action power-up
    :parameters (?gadget - spot)
    :precondition (and (gadget ?gadget) (robot-at ?gadget) (not (powered ?gadget)))
    :effect (powered ?gadget))

  (:action power-down
    :parameters (?gadget - spot)
    :precondition (and (gadget ?gadget) (robot-at ?gadget) (powered ?gadget))
    :effect (not (powered ?gadget)))

  (:action swing-open
    :parameters (?hatch - spot)
    :precondition (and (hinged ?hatch) (robot-at ?hatch) (not (ajar ?hatch)))
    :effect (ajar ?hatch))

  (:action swing-shut
    :parameters (?hatch - spot)
    :precondition (and (hinged ?hatch) (robot-at ?hatch) (ajar ?hatch))
    :effect (not (ajar ?hatch)))

  (:action pick-music
    :parameters (?player - spot ?genre - genre)
    :precondition (and (player ?player) (robot-at ?player) (not (playing ?player ?genre)))
    :effect (and (forall (?other - genre) (not (playing ?player ?other))) (playing ?player ?genre)))

  (:action chill
    :parameters (?cooler - spot ?degrees - degrees)
    :precondition (and (cooler ?cooler) (robot-at ?cooler) (not (cold ?cooler ?degrees)))
    :effect (and (forall (?other - degrees) (not (cold ?cooler ?other))) (cold ?cooler ?degrees)))

  (:action allot
    :parameters (?console - spot ?minutes - minutes)
    :precondition (and (console ?console) (robot-at ?console))
    :effect (timed ?console ?minutes))

  (:action sweep
    :parameters (?spot - spot)
    :precondition (and (not (guest ?spot)) (robot-at ?spot))
    :effect (swept ?spot))

  (:action tighten
    :parameters (?gear - gear)
    :precondition (and (board ?gear) (holding ?gear))
    :effect (tight ?gear))

  (:action toast
    :parameters (?gear - gear)
    :precondition (and (snack ?gear) (holding ?gear))
    :effect (toasted ?gear))

  (:action holler
    :parameters (?guest - spot)
    :precondition (guest ?guest)
    :effect (fetched ?guest))

  ; A look and a knock are enough.
  (:action look-over
    :parameters (?ramp - spot)
    :precondition (and (ramp ?ramp) (robot-at ?ramp))
    :effect (and))

  (:action knock-on
    :parameters (?gear - gear)
    :precondition (and (board ?gear) (holding ?gear))
    :effect (and)))
