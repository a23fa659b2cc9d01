; A robot in the reception and waiting rooms of a physiotherapy practice: it tidies and hands things over, walks patients
; to their rooms, minds doors, blinds, lamps, heaters and music, disinfects, refills dispensers, tells people how long it
; takes, and looks at dispensers and at waiting patients before it decides what to do.
(define (domain waitingroom)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types fixture belonging - entity minutes degrees)

  (:predicates
    ; what never changes
    (holds-things ?fixture - fixture)
    (room ?fixture - fixture)
    (opening ?fixture - fixture)
    (appliance ?fixture - fixture)
    (heater ?fixture - fixture)
    (dispenser ?fixture - fixture)
    (person ?fixture - fixture)
    (patient ?fixture - fixture)
    (programme ?fixture - fixture)
    ; where things and people are and how they are
    (robot-near ?entity - entity)
    (kept-at ?belonging - belonging ?fixture - fixture)
    (carried ?belonging - belonging)
    (sits-in ?patient - fixture ?room - fixture)
    (is-open ?fixture - fixture)
    (runs ?fixture - fixture)
    (heated-to ?fixture - fixture ?degrees - degrees)
    (audible ?programme - fixture)
    ; what only a look tells
    (plenty ?dispenser - fixture)
    (low ?dispenser - fixture)
    (empty ?dispenser - fixture)
    (asleep ?patient - fixture)
    (awake ?patient - fixture)
    ; what happened
    (disinfected ?entity - entity)
    (refilled ?dispenser - fixture)
    (told-delay ?person - fixture ?minutes - minutes)
    (asked-to-come ?person - fixture))

  (:action approach
    :parameters (?entity - entity)
    :precondition (not (robot-near ?entity))
    :effect (and (forall (?other - entity) (not (robot-near ?other))) (robot-near ?entity)))

  (:action fetch
    :parameters (?belonging - belonging ?fixture - fixture)
    :precondition (and (robot-near ?fixture) (kept-at ?belonging ?fixture)
                       (forall (?other - belonging) (not (carried ?other))))
    :effect (and (carried ?belonging) (not (kept-at ?belonging ?fixture))))

  (:action lay-down
    :parameters (?belonging - belonging ?fixture - fixture)
    :precondition (and (carried ?belonging) (robot-near ?fixture) (holds-things ?fixture))
    :effect (and (kept-at ?belonging ?fixture) (not (carried ?belonging))))

  (:action offer
    :parameters (?belonging - belonging ?person - fixture)
    :precondition (and (carried ?belonging) (robot-near ?person) (person ?person))
    :effect (and (kept-at ?belonging ?person) (not (carried ?belonging))))

  (:action walk-with
    :parameters (?patient - fixture ?room - fixture)
    :precondition (and (patient ?patient) (room ?room) (robot-near ?patient) (not (sits-in ?patient ?room)))
    :effect (and (forall (?other - fixture) (not (sits-in ?patient ?other))) (sits-in ?patient ?room)))

  (:action draw-open
    :parameters (?opening - fixture)
    :precondition (and (opening ?opening) (robot-near ?opening) (not (is-open ?opening)))
    :effect (is-open ?opening))

  (:action draw-shut
    :parameters (?opening - fixture)
    :precondition (and (opening ?opening) (robot-near ?opening) (is-open ?opening))
    :effect (not (is-open ?opening)))

  (:action press-on
    :parameters (?appliance - fixture)
    :precondition (and (appliance ?appliance) (robot-near ?appliance) (not (runs ?appliance)))
    :effect (runs ?appliance))

  (:action press-off
    :parameters (?appliance - fixture)
    :precondition (and (appliance ?appliance) (robot-near ?appliance) (runs ?appliance))
    :effect (not (runs ?appliance)))

  (:action turn-knob
    :parameters (?heater - fixture ?degrees - degrees)
    :precondition (and (heater ?heater) (robot-near ?heater) (not (heated-to ?heater ?degrees)))
    :effect (and (forall (?other - degrees) (not (heated-to ?heater ?other))) (heated-to ?heater ?degrees)))

  (:action play
    :parameters (?programme - fixture)
    :precondition (and (programme ?programme) (not (audible ?programme)))
    :effect (and (forall (?other - fixture) (not (audible ?other))) (audible ?programme)))

  (:action spray
    :parameters (?entity - entity)
    :precondition (robot-near ?entity)
    :effect (disinfected ?entity))

  (:action refill
    :parameters (?dispenser - fixture)
    :precondition (and (dispenser ?dispenser) (robot-near ?dispenser))
    :effect (refilled ?dispenser))

  (:action announce-delay
    :parameters (?person - fixture ?minutes - minutes)
    :precondition (and (person ?person) (robot-near ?person))
    :effect (told-delay ?person ?minutes))

  (:action send-for
    :parameters (?person - fixture)
    :precondition (person ?person)
    :effect (asked-to-come ?person))

  ; It is enough to stand in front of them.
  (:action check-level
    :parameters (?dispenser - fixture)
    :precondition (and (dispenser ?dispenser) (robot-near ?dispenser))
    :effect (and))

  (:action glance-at
    :parameters (?patient - fixture)
    :precondition (and (patient ?patient) (robot-near ?patient))
    :effect (and)))
