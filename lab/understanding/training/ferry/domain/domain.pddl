; A ferry robot: it carries luggage and gear, opens and shuts doors and ramps, minds devices, makes announcements, lashes
; vehicles, looks after floors and passengers, and looks at floors and passengers before it decides what to do.
(define (domain ferry)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot baggage - thing announcement language straps)

  (:constants safety boarding arrival dinner - announcement
              english german french swedish - language)

  (:predicates
    ; what never changes
    (human ?spot - spot)
    (passenger ?spot - spot)
    (way ?spot - spot)                      ; a door, hatch or ramp
    (floor ?spot - spot)
    (vehicle ?spot - spot)
    (electric ?spot - spot)
    ; where things are and how they are
    (robot-at ?spot - spot)
    (at ?baggage - baggage ?spot - spot)
    (carrying ?baggage - baggage)
    (open ?spot - spot)
    (live ?spot - spot)
    (lashed ?spot - spot ?straps - straps)
    ; what only a look tells
    (dry ?spot - spot)
    (wet ?spot - spot)
    (icy ?spot - spot)
    (well ?spot - spot)
    (seasick ?spot - spot)
    ; what happened
    (called-out ?announcement - announcement ?language - language)
    (mopped ?spot - spot)
    (gritted ?spot - spot)
    (walked ?person - spot ?to - spot)
    (told ?person - spot ?about - thing))

  (:action walk
    :parameters (?to - spot)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?baggage - baggage ?from - spot)
    :precondition (and (robot-at ?from) (at ?baggage ?from)
                       (forall (?other - baggage) (not (carrying ?other))))
    :effect (and (carrying ?baggage) (not (at ?baggage ?from))))

  (:action set-down
    :parameters (?baggage - baggage ?to - spot)
    :precondition (and (carrying ?baggage) (robot-at ?to) (not (human ?to)))
    :effect (and (at ?baggage ?to) (not (carrying ?baggage))))

  (:action pass
    :parameters (?baggage - baggage ?person - spot)
    :precondition (and (carrying ?baggage) (robot-at ?person) (human ?person))
    :effect (and (at ?baggage ?person) (not (carrying ?baggage))))

  (:action unbar
    :parameters (?way - spot)
    :precondition (and (way ?way) (robot-at ?way) (not (open ?way)))
    :effect (open ?way))

  (:action bar
    :parameters (?way - spot)
    :precondition (and (way ?way) (robot-at ?way) (open ?way))
    :effect (not (open ?way)))

  (:action plug-in
    :parameters (?device - spot)
    :precondition (and (electric ?device) (robot-at ?device) (not (live ?device)))
    :effect (live ?device))

  (:action cut-off
    :parameters (?device - spot)
    :precondition (and (electric ?device) (robot-at ?device) (live ?device))
    :effect (not (live ?device)))

  (:action speak
    :parameters (?announcement - announcement ?language - language)
    :precondition (and)
    :effect (called-out ?announcement ?language))

  (:action lash
    :parameters (?vehicle - spot ?straps - straps)
    :precondition (and (vehicle ?vehicle) (robot-at ?vehicle) (not (lashed ?vehicle ?straps)))
    :effect (and (forall (?other - straps) (not (lashed ?vehicle ?other))) (lashed ?vehicle ?straps)))

  (:action mop
    :parameters (?floor - spot)
    :precondition (and (floor ?floor) (robot-at ?floor))
    :effect (mopped ?floor))

  (:action grit
    :parameters (?floor - spot)
    :precondition (and (floor ?floor) (robot-at ?floor))
    :effect (gritted ?floor))

  (:action escort
    :parameters (?person - spot ?to - spot)
    :precondition (and (human ?person) (robot-at ?person) (not (= ?person ?to)))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to) (walked ?person ?to)))

  (:action tell
    :parameters (?person - spot ?about - thing)
    :precondition (and (human ?person) (robot-at ?person))
    :effect (told ?person ?about))

  (:action feel-floor
    :parameters (?floor - spot)
    :precondition (floor ?floor)
    :effect (and))

  (:action look-after
    :parameters (?person - spot)
    :precondition (passenger ?person)
    :effect (and)))
