; A robot in a fire station: it carries kit, hands it to people, coils and mends hoses, fills air bottles, minds doors,
; lamps and machines, and feels hoses and tests batteries before it decides what to do with them.
(define (domain firestation)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot kit - thing pressure)

  (:predicates
    ; what never changes
    (person ?spot - spot)
    (storage ?spot - spot)
    (gate ?spot - spot)
    (lamp ?thing - thing)
    (machine ?spot - spot)
    (mode ?spot - spot)                     ; a way for a lamp to be
    (hose ?kit - kit)
    (bottle ?kit - kit)
    (gadget ?kit - kit)
    ; where things are and how they are
    (robot-at ?thing - thing)
    (at ?kit - kit ?spot - spot)
    (carrying ?kit - kit)
    (open ?spot - spot)
    (powered ?spot - spot)
    (beaming ?thing - thing ?mode - spot)
    (coiled ?kit - kit)
    ; what only a look tells
    (watertight ?kit - kit)
    (leaking ?kit - kit)
    (fresh ?kit - kit)
    (weak ?kit - kit)
    (flat ?kit - kit)
    ; what happened
    (mended ?kit - kit)
    (filled-to ?kit - kit ?pressure - pressure)
    (rinsed ?thing - thing)
    (called ?spot - spot)
    (noted ?thing - thing))

  (:action drive
    :parameters (?to - thing)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - thing) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?kit - kit ?from - spot)
    :precondition (and (robot-at ?from) (at ?kit ?from) (forall (?other - kit) (not (carrying ?other))))
    :effect (and (carrying ?kit) (not (at ?kit ?from))))

  (:action set-down
    :parameters (?kit - kit ?spot - spot)
    :precondition (and (carrying ?kit) (robot-at ?spot) (storage ?spot))
    :effect (and (at ?kit ?spot) (not (carrying ?kit))))

  (:action give
    :parameters (?kit - kit ?person - spot)
    :precondition (and (carrying ?kit) (robot-at ?person) (person ?person))
    :effect (and (at ?kit ?person) (not (carrying ?kit))))

  (:action wind
    :parameters (?hose - kit)
    :precondition (and (hose ?hose) (robot-at ?hose) (not (coiled ?hose)))
    :effect (coiled ?hose))

  (:action mend
    :parameters (?kit - kit)
    :precondition (robot-at ?kit)
    :effect (mended ?kit))

  (:action fill
    :parameters (?bottle - kit ?pressure - pressure)
    :precondition (and (bottle ?bottle) (robot-at ?bottle))
    :effect (filled-to ?bottle ?pressure))

  (:action set-lamp
    :parameters (?lamp - thing ?mode - spot)
    :precondition (and (lamp ?lamp) (mode ?mode) (robot-at ?lamp) (not (beaming ?lamp ?mode)))
    :effect (and (forall (?other - spot) (not (beaming ?lamp ?other))) (beaming ?lamp ?mode)))

  (:action raise
    :parameters (?gate - spot)
    :precondition (and (gate ?gate) (robot-at ?gate) (not (open ?gate)))
    :effect (open ?gate))

  (:action lower
    :parameters (?gate - spot)
    :precondition (and (gate ?gate) (robot-at ?gate) (open ?gate))
    :effect (not (open ?gate)))

  (:action plug
    :parameters (?machine - spot)
    :precondition (and (machine ?machine) (robot-at ?machine) (not (powered ?machine)))
    :effect (powered ?machine))

  (:action unplug
    :parameters (?machine - spot)
    :precondition (and (machine ?machine) (robot-at ?machine) (powered ?machine))
    :effect (not (powered ?machine)))

  (:action rinse
    :parameters (?thing - thing)
    :precondition (robot-at ?thing)
    :effect (rinsed ?thing))

  (:action call
    :parameters (?person - spot)
    :precondition (person ?person)
    :effect (called ?person))

  (:action note
    :parameters (?thing - thing)
    :precondition (robot-at ?thing)
    :effect (noted ?thing))

  ; It is enough to stand in front of the thing.
  (:action feel-hose
    :parameters (?kit - kit)
    :precondition (and (hose ?kit) (robot-at ?kit))
    :effect (and))

  (:action test-battery
    :parameters (?kit - kit)
    :precondition (and (gadget ?kit) (robot-at ?kit))
    :effect (and)))
