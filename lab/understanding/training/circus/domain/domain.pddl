; A robot of a travelling circus that carries props and costumes, dresses artists, minds lamps, machines, curtains and hatches, sets lights, heights and prices, mends things, gives cues, and looks at seams and stands before it decides.
(define (domain circus)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot prop - thing colour height price)

  (:constants amber crimson blue white - colour)

  (:predicates
    (artist ?spot - spot)
    (powered ?spot - spot)
    (spotlight ?spot - spot)
    (curtained ?spot - spot)
    (apparatus ?spot - spot)
    (till ?spot - spot)
    (stand ?spot - spot)
    (costume ?prop - prop)
    (fabric ?prop - prop)
    (robot-at ?thing - thing)
    (at ?prop - prop ?spot - spot)
    (carrying ?prop - prop)
    (running ?spot - spot)
    (open ?spot - spot)
    (tinted ?spot - spot ?colour - colour)
    (hangs ?spot - spot ?height - height)
    (charges ?spot - spot ?price - price)
    (worn ?prop - prop ?spot - spot)
    (torn ?prop - prop)
    (whole ?prop - prop)
    (packed ?spot - spot)
    (patchy ?spot - spot)
    (deserted ?spot - spot)
    (mended ?prop - prop)
    (cued ?spot - spot))

  (:action walk
    :parameters (?to - thing)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - thing) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?prop - prop ?from - spot)
    :precondition (and (robot-at ?from) (at ?prop ?from) (forall (?other - prop) (not (carrying ?other))))
    :effect (and (carrying ?prop) (not (at ?prop ?from))))

  (:action lay
    :parameters (?prop - prop ?to - spot)
    :precondition (and (robot-at ?to) (carrying ?prop))
    :effect (and (at ?prop ?to) (not (carrying ?prop))))

  (:action dress
    :parameters (?prop - prop ?spot - spot)
    :precondition (and (costume ?prop) (artist ?spot) (carrying ?prop) (robot-at ?spot))
    :effect (and (worn ?prop ?spot) (not (carrying ?prop))))

  (:action power-up
    :parameters (?spot - spot)
    :precondition (and (powered ?spot) (robot-at ?spot) (not (running ?spot)))
    :effect (running ?spot))

  (:action power-down
    :parameters (?spot - spot)
    :precondition (and (powered ?spot) (robot-at ?spot) (running ?spot))
    :effect (not (running ?spot)))

  (:action raise
    :parameters (?spot - spot)
    :precondition (and (curtained ?spot) (robot-at ?spot) (not (open ?spot)))
    :effect (open ?spot))

  (:action lower
    :parameters (?spot - spot)
    :precondition (and (curtained ?spot) (robot-at ?spot) (open ?spot))
    :effect (not (open ?spot)))

  (:action tint
    :parameters (?spot - spot ?colour - colour)
    :precondition (and (spotlight ?spot) (robot-at ?spot) (not (tinted ?spot ?colour)))
    :effect (and (forall (?other - colour) (not (tinted ?spot ?other))) (tinted ?spot ?colour)))

  (:action hoist
    :parameters (?spot - spot ?height - height)
    :precondition (and (apparatus ?spot) (robot-at ?spot) (not (hangs ?spot ?height)))
    :effect (and (forall (?other - height) (not (hangs ?spot ?other))) (hangs ?spot ?height)))

  (:action post
    :parameters (?spot - spot ?price - price)
    :precondition (and (till ?spot) (robot-at ?spot) (not (charges ?spot ?price)))
    :effect (and (forall (?other - price) (not (charges ?spot ?other))) (charges ?spot ?price)))

  (:action sew
    :parameters (?prop - prop)
    :precondition (and (fabric ?prop) (robot-at ?prop))
    :effect (mended ?prop))

  (:action give-cue
    :parameters (?spot - spot)
    :precondition (and (artist ?spot) (robot-at ?spot))
    :effect (cued ?spot))

  (:action inspect-seams
    :parameters (?prop - prop)
    :precondition (and (fabric ?prop) (robot-at ?prop))
    :effect (and))

  (:action count-seats
    :parameters (?spot - spot)
    :precondition (and (stand ?spot) (robot-at ?spot))
    :effect (and)))
