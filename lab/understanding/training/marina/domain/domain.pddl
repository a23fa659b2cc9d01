; A robot on the jetties of a small yacht harbour: it carries gear, moves and ties boats, fuels, pumps and hoses them, sees
; to gates, devices and flags, and looks at lines and bilges before it decides what to do.
(define (domain marina)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place gear - thing mode litres)

  (:constants off low full - mode)

  (:predicates
    ; what never changes
    (stowage ?thing - thing)
    (crew ?place - place)
    (berth ?place - place)
    (gate ?place - place)
    (device ?place - place)
    (mast ?place - place)
    (boat ?gear - gear)
    (line ?gear - gear)
    (flag ?gear - gear)
    ; where things are and how they are
    (robot-at ?thing - thing)
    (lies ?gear - gear ?place - thing)
    (gripped ?gear - gear)
    (passable ?place - place)
    (runs ?place - place ?mode - mode)
    (lashed ?boat - gear ?rope - gear)
    (flying ?flag - gear ?mast - place)
    ; what only a look tells
    (sound ?gear - gear)
    (frayed ?gear - gear)
    (dry ?gear - gear)
    (damp ?gear - gear)
    (flooded ?gear - gear)
    ; what happened
    (rinsed ?thing - thing)
    (bunkered ?boat - gear ?litres - litres)
    (drained ?boat - gear)
    (called ?person - place))

  (:action drive
    :parameters (?to - thing)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - thing) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?gear - gear ?from - thing)
    :precondition (and (robot-at ?from) (lies ?gear ?from) (not (boat ?gear))
                       (forall (?other - gear) (not (gripped ?other))))
    :effect (and (gripped ?gear) (not (lies ?gear ?from))
                 (forall (?mast - place) (not (flying ?gear ?mast)))
                 (forall (?boat - gear) (not (lashed ?boat ?gear)))))

  (:action drop
    :parameters (?gear - gear ?to - thing)
    :precondition (and (gripped ?gear) (robot-at ?to) (not (= ?gear ?to)) (or (stowage ?to) (crew ?to)))
    :effect (and (lies ?gear ?to) (not (gripped ?gear))))

  (:action tow
    :parameters (?boat - gear ?from - place ?to - place)
    :precondition (and (boat ?boat) (berth ?to) (lies ?boat ?from) (robot-at ?boat) (not (= ?from ?to)))
    :effect (and (lies ?boat ?to) (not (lies ?boat ?from))))

  (:action lash
    :parameters (?boat - gear ?rope - gear)
    :precondition (and (boat ?boat) (line ?rope) (gripped ?rope) (robot-at ?boat))
    :effect (and (lashed ?boat ?rope) (lies ?rope ?boat) (not (gripped ?rope))))

  (:action slip
    :parameters (?boat - gear)
    :precondition (and (boat ?boat) (robot-at ?boat))
    :effect (forall (?rope - gear) (not (lashed ?boat ?rope))))

  (:action hose
    :parameters (?thing - thing)
    :precondition (robot-at ?thing)
    :effect (rinsed ?thing))

  (:action bunker
    :parameters (?boat - gear ?litres - litres)
    :precondition (and (boat ?boat) (robot-at ?boat))
    :effect (bunkered ?boat ?litres))

  (:action pump
    :parameters (?boat - gear)
    :precondition (and (boat ?boat) (robot-at ?boat))
    :effect (drained ?boat))

  (:action dial
    :parameters (?device - place ?mode - mode)
    :precondition (and (device ?device) (robot-at ?device) (not (runs ?device ?mode)))
    :effect (and (forall (?other - mode) (not (runs ?device ?other))) (runs ?device ?mode)))

  (:action hoist
    :parameters (?flag - gear ?mast - place)
    :precondition (and (flag ?flag) (mast ?mast) (gripped ?flag) (robot-at ?mast))
    :effect (and (flying ?flag ?mast) (lies ?flag ?mast) (not (gripped ?flag))))

  (:action unbar
    :parameters (?gate - place)
    :precondition (and (gate ?gate) (robot-at ?gate) (not (passable ?gate)))
    :effect (passable ?gate))

  (:action bar
    :parameters (?gate - place)
    :precondition (and (gate ?gate) (robot-at ?gate) (passable ?gate))
    :effect (not (passable ?gate)))

  (:action radio
    :parameters (?person - place)
    :precondition (crew ?person)
    :effect (called ?person))

  ; It is enough to stand in front of the thing.
  (:action inspect-line
    :parameters (?gear - gear)
    :precondition (and (line ?gear) (robot-at ?gear))
    :effect (and))

  (:action inspect-bilge
    :parameters (?gear - gear)
    :precondition (and (boat ?gear) (robot-at ?gear))
    :effect (and)))
