; A ski rental robot: it houses gear, equips guests, sets bindings, waxes, hangs name tags, prints tickets, works devices, doors and locks.
(define (domain skirental)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot gear - thing din words)

  (:predicates
    (person ?spot - spot)
    (opens ?spot - spot)                    ; a cabinet, a locker, a door
    (lockable ?spot - spot)
    (flat-top ?spot - spot)
    (electric ?spot - spot)                 ; can be switched
    (bindings ?gear - gear)                 ; skis with bindings to set
    (glides ?gear - gear)                   ; takes wax
    (in ?gear - gear ?spot - spot)
    (atop ?gear - gear ?spot - spot)
    (alongside ?gear - gear ?thing - thing)
    (carrying ?gear - gear)
    (open ?spot - spot)
    (bolted ?spot - spot)
    (powered ?spot - spot)
    (set-to ?gear - gear ?din - din)
    ; what happened
    (waxed ?gear - gear)
    (badged ?gear - gear ?words - words)
    (ticketed ?words - words))

  (:action pick
    :parameters (?gear - gear)
    :precondition (and (forall (?other - gear) (not (carrying ?other)))
                       (forall (?spot - spot) (imply (and (in ?gear ?spot) (opens ?spot)) (open ?spot))))
    :effect (and (carrying ?gear)
                 (forall (?spot - spot) (and (not (in ?gear ?spot)) (not (atop ?gear ?spot))))
                 (forall (?thing - thing) (not (alongside ?gear ?thing)))))

  (:action house
    :parameters (?gear - gear ?spot - spot)
    :precondition (and (carrying ?gear) (imply (opens ?spot) (open ?spot)))
    :effect (and (in ?gear ?spot) (not (carrying ?gear))))

  (:action heave
    :parameters (?gear - gear ?spot - spot)
    :precondition (and (carrying ?gear) (flat-top ?spot))
    :effect (and (atop ?gear ?spot) (not (carrying ?gear))))

  (:action line-up
    :parameters (?gear - gear ?thing - thing)
    :precondition (and (carrying ?gear) (not (= ?gear ?thing)))
    :effect (and (alongside ?gear ?thing) (not (carrying ?gear))))

  (:action screw
    :parameters (?gear - gear ?din - din)
    :precondition (and (carrying ?gear) (bindings ?gear) (not (set-to ?gear ?din)))
    :effect (and (forall (?other - din) (not (set-to ?gear ?other))) (set-to ?gear ?din)))

  (:action wax
    :parameters (?gear - gear)
    :precondition (and (carrying ?gear) (glides ?gear))
    :effect (waxed ?gear))

  (:action badge
    :parameters (?gear - gear ?words - words)
    :precondition (carrying ?gear)
    :effect (badged ?gear ?words))

  (:action print
    :parameters (?words - words)
    :precondition (and)
    :effect (ticketed ?words))

  (:action start
    :parameters (?device - spot)
    :precondition (and (electric ?device) (not (powered ?device)))
    :effect (powered ?device))

  (:action stop
    :parameters (?device - spot)
    :precondition (and (electric ?device) (powered ?device))
    :effect (not (powered ?device)))

  (:action unbolt
    :parameters (?spot - spot)
    :precondition (and (lockable ?spot) (bolted ?spot))
    :effect (not (bolted ?spot)))

  (:action bolt
    :parameters (?spot - spot)
    :precondition (and (lockable ?spot) (not (open ?spot)) (not (bolted ?spot)))
    :effect (bolted ?spot))

  (:action throw-open
    :parameters (?spot - spot)
    :precondition (and (opens ?spot) (not (open ?spot)) (not (bolted ?spot)))
    :effect (open ?spot))

  (:action pull-shut
    :parameters (?spot - spot)
    :precondition (and (opens ?spot) (open ?spot))
    :effect (not (open ?spot))))
