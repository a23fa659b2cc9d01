; A brewery robot: it stacks, leans and hands over things, charges and heats vessels, couples hoses, works valves, doors and pumps, rinses and pours.
(define (domain brewery)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item - thing temperature)

  (:predicates
    ; what never changes
    (hollow ?place - place)                 ; things go inside
    (flat ?place - place)                   ; things stand on it
    (raised ?place - place)                 ; there is room under it
    (upright ?place - place)                ; things can lean against it
    (vessel ?place - place)                 ; liquids are in it, ingredients go in
    (thermal ?place - place)                ; has a temperature
    (opens ?place - place)                  ; a valve or a door
    (device ?place - place)
    (basin ?place - place)                  ; things are rinsed there
    (tap ?place - place)
    (person ?place - place)
    (hose ?item - item)
    (ingredient ?item - item)
    (washable ?item - item)
    (glass ?item - item)
    (tall ?item - item)                     ; can lean against something
    ; where things are and how they are
    (robot-at ?place - place)
    (in ?item - item ?place - place)
    (on ?item - item ?place - place)
    (under ?item - item ?place - place)
    (leaning ?item - item ?place - place)
    (has ?person - place ?item - item)
    (coupled ?hose - item ?vessel - place)
    (holding ?item - item)
    (open ?place - place)
    (running ?place - place)
    (set-to ?place - place ?temperature - temperature)
    ; what happened
    (charged ?vessel - place ?item - item)
    (drawn ?glass - item ?tap - place)
    (rinsed ?item - item)
    (alerted ?person - place))

  (:action go
    :parameters (?to - place)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - place) (not (robot-at ?from))) (robot-at ?to)))

  (:action take
    :parameters (?item - item ?from - place)
    :precondition (and (robot-at ?from)
                       (or (on ?item ?from) (under ?item ?from) (leaning ?item ?from) (has ?from ?item)
                           (and (in ?item ?from) (imply (opens ?from) (open ?from))))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (in ?item ?from)) (not (on ?item ?from)) (not (under ?item ?from))
                 (not (leaning ?item ?from)) (not (has ?from ?item))))

  (:action put-in
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (hollow ?to) (imply (opens ?to) (open ?to)))
    :effect (and (in ?item ?to) (not (holding ?item))))

  (:action put-on
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (flat ?to))
    :effect (and (on ?item ?to) (not (holding ?item))))

  (:action slide-under
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (raised ?to))
    :effect (and (under ?item ?to) (not (holding ?item))))

  (:action lean
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (tall ?item) (robot-at ?to) (upright ?to))
    :effect (and (leaning ?item ?to) (not (holding ?item))))

  (:action hand-over
    :parameters (?item - item ?person - place)
    :precondition (and (holding ?item) (person ?person) (robot-at ?person))
    :effect (and (has ?person ?item) (not (holding ?item))))

  (:action couple
    :parameters (?hose - item ?vessel - place)
    :precondition (and (hose ?hose) (vessel ?vessel) (holding ?hose) (robot-at ?vessel))
    :effect (and (coupled ?hose ?vessel) (not (holding ?hose))))

  (:action uncouple
    :parameters (?hose - item ?vessel - place)
    :precondition (and (coupled ?hose ?vessel) (robot-at ?vessel)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?hose) (not (coupled ?hose ?vessel))))

  (:action charge
    :parameters (?item - item ?vessel - place)
    :precondition (and (ingredient ?item) (vessel ?vessel) (holding ?item) (robot-at ?vessel))
    :effect (charged ?vessel ?item))

  (:action draw
    :parameters (?glass - item ?tap - place)
    :precondition (and (glass ?glass) (tap ?tap) (holding ?glass) (robot-at ?tap))
    :effect (drawn ?glass ?tap))

  (:action rinse
    :parameters (?item - item ?basin - place)
    :precondition (and (washable ?item) (basin ?basin) (holding ?item) (robot-at ?basin))
    :effect (rinsed ?item))

  (:action set-temperature
    :parameters (?place - place ?temperature - temperature)
    :precondition (and (thermal ?place) (robot-at ?place) (not (set-to ?place ?temperature)))
    :effect (and (forall (?other - temperature) (not (set-to ?place ?other))) (set-to ?place ?temperature)))

  (:action unseal
    :parameters (?place - place)
    :precondition (and (opens ?place) (robot-at ?place) (not (open ?place)))
    :effect (open ?place))

  (:action seal
    :parameters (?place - place)
    :precondition (and (opens ?place) (robot-at ?place) (open ?place))
    :effect (not (open ?place)))

  (:action switch-on
    :parameters (?device - place)
    :precondition (and (device ?device) (robot-at ?device) (not (running ?device)))
    :effect (running ?device))

  (:action switch-off
    :parameters (?device - place)
    :precondition (and (device ?device) (robot-at ?device) (running ?device))
    :effect (not (running ?device)))

  (:action alert
    :parameters (?person - place)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (alerted ?person)))
