; A farm robot: it carries things, leads animals, waters, harvests, feeds, fills troughs, mucks out and minds gates.
(define (domain farm)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place load - thing)

  (:predicates
    (plot ?place - place)                   ; a bed, a field, a tree or a row of trees
    (gate ?place - place)
    (trough ?place - place)
    (stall ?place - place)
    (behind ?place - place ?gate - place)   ; animals reach the place through this gate only
    (animal ?load - load)
    (feed ?load - load)
    (red ?load - load)
    (green ?load - load)
    (white ?load - load)
    (brown ?load - load)
    (robot-at ?place - place)
    (at ?load - load ?place - place)
    (carrying ?load - load)
    (ripe ?place - place)
    (open ?place - place)
    (full ?place - place)
    (dirty ?place - place)
    ; what happened
    (watered ?place - place)
    (harvested ?place - place)
    (fed ?animal - load ?feed - load))

  (:action go
    :parameters (?to - place)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - place) (not (robot-at ?from))) (robot-at ?to)))

  (:action pick-up
    :parameters (?load - load ?from - place)
    :precondition (and (robot-at ?from) (at ?load ?from) (not (animal ?load))
                       (forall (?other - load) (not (carrying ?other))))
    :effect (and (carrying ?load) (not (at ?load ?from))))

  (:action put-down
    :parameters (?load - load ?to - place)
    :precondition (and (robot-at ?to) (carrying ?load))
    :effect (and (at ?load ?to) (not (carrying ?load))))

  ; An animal goes from place to place on a rope, through open gates.
  (:action lead
    :parameters (?animal - load ?from - place ?to - place)
    :precondition (and (animal ?animal) (robot-at ?from) (at ?animal ?from) (not (= ?from ?to)) (not (gate ?to))
                       (forall (?other - load) (not (carrying ?other)))
                       (forall (?gate - place)
                         (imply (or (behind ?from ?gate) (behind ?to ?gate)) (open ?gate))))
    :effect (and (not (at ?animal ?from)) (at ?animal ?to) (not (robot-at ?from)) (robot-at ?to)))

  (:action open-gate
    :parameters (?gate - place)
    :precondition (and (gate ?gate) (robot-at ?gate) (not (open ?gate)))
    :effect (open ?gate))

  (:action close-gate
    :parameters (?gate - place)
    :precondition (and (gate ?gate) (robot-at ?gate) (open ?gate))
    :effect (not (open ?gate)))

  (:action water
    :parameters (?plot - place)
    :precondition (and (plot ?plot) (robot-at ?plot))
    :effect (watered ?plot))

  (:action harvest
    :parameters (?plot - place)
    :precondition (and (plot ?plot) (robot-at ?plot) (ripe ?plot))
    :effect (and (harvested ?plot) (not (ripe ?plot))))

  (:action fill
    :parameters (?trough - place)
    :precondition (and (trough ?trough) (robot-at ?trough) (not (full ?trough)))
    :effect (full ?trough))

  (:action muck-out
    :parameters (?stall - place)
    :precondition (and (stall ?stall) (robot-at ?stall) (dirty ?stall))
    :effect (not (dirty ?stall)))

  (:action give-feed
    :parameters (?animal - load ?feed - load ?place - place)
    :precondition (and (animal ?animal) (feed ?feed) (carrying ?feed) (robot-at ?place) (at ?animal ?place))
    :effect (fed ?animal ?feed)))
