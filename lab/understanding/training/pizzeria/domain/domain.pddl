; A pizzeria robot for the dining room and the front counter: it carries food and things, seats people, notes bookings and
; bills, refills jugs and dispensers, minds lights, doors and music, and looks at tables and vessels before it acts.
(define (domain pizzeria)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot ware - entity heads amount)

  (:predicates
    ; what never changes
    (person ?spot - spot)
    (surface ?spot - spot)
    (table ?spot - spot)
    (light ?spot - spot)
    (hinged ?spot - spot)
    (vessel ?ware - ware)
    (supply ?ware - ware)
    (playlist ?ware - ware)
    ; where things are and how they are
    (robot-at ?entity - entity)
    (at ?ware - ware ?spot - spot)
    (carrying ?ware - ware)
    (sits ?guest - spot ?table - spot)
    (lit ?spot - spot)
    (open ?spot - spot)
    (sounding ?ware - ware)
    (kept ?table - spot ?heads - heads)
    ; what only a look tells
    (vacant ?spot - spot)
    (taken ?spot - spot)
    (stocked ?ware - ware)
    (low ?ware - ware)
    (empty ?ware - ware)
    ; what happened
    (wiped ?spot - spot)
    (poured ?supply - ware ?vessel - ware)
    (billed ?table - spot ?amount - amount)
    (called ?spot - spot))

  (:action head-to
    :parameters (?to - entity)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - entity) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?ware - ware ?from - spot)
    :precondition (and (robot-at ?from) (at ?ware ?from)
                       (forall (?other - ware) (not (carrying ?other))))
    :effect (and (carrying ?ware) (not (at ?ware ?from))))

  (:action lay
    :parameters (?ware - ware ?to - spot)
    :precondition (and (carrying ?ware) (robot-at ?to) (surface ?to))
    :effect (and (at ?ware ?to) (not (carrying ?ware))))

  (:action pass
    :parameters (?ware - ware ?person - spot)
    :precondition (and (carrying ?ware) (robot-at ?person) (person ?person))
    :effect (and (at ?ware ?person) (not (carrying ?ware))))

  (:action usher
    :parameters (?guest - spot ?table - spot)
    :precondition (and (person ?guest) (table ?table) (robot-at ?table))
    :effect (and (forall (?other - spot) (not (sits ?guest ?other))) (sits ?guest ?table)))

  (:action wipe
    :parameters (?spot - spot)
    :precondition (and (surface ?spot) (robot-at ?spot))
    :effect (wiped ?spot))

  (:action light-up
    :parameters (?light - spot)
    :precondition (and (light ?light) (robot-at ?light) (not (lit ?light)))
    :effect (lit ?light))

  (:action put-out
    :parameters (?light - spot)
    :precondition (and (light ?light) (robot-at ?light) (lit ?light))
    :effect (not (lit ?light)))

  (:action open-up
    :parameters (?door - spot)
    :precondition (and (hinged ?door) (robot-at ?door) (not (open ?door)))
    :effect (open ?door))

  (:action pull-to
    :parameters (?door - spot)
    :precondition (and (hinged ?door) (robot-at ?door) (open ?door))
    :effect (not (open ?door)))

  (:action pour
    :parameters (?supply - ware ?vessel - ware)
    :precondition (and (supply ?supply) (vessel ?vessel) (robot-at ?vessel))
    :effect (poured ?supply ?vessel))

  (:action put-on-music
    :parameters (?playlist - ware)
    :precondition (and (playlist ?playlist) (not (sounding ?playlist)))
    :effect (and (forall (?other - ware) (not (sounding ?other))) (sounding ?playlist)))

  (:action book
    :parameters (?table - spot ?heads - heads)
    :precondition (table ?table)
    :effect (and (forall (?other - heads) (not (kept ?table ?other))) (kept ?table ?heads)))

  (:action ring-up
    :parameters (?table - spot ?amount - amount)
    :precondition (table ?table)
    :effect (billed ?table ?amount))

  (:action call
    :parameters (?person - spot)
    :precondition (person ?person)
    :effect (called ?person))

  ; It is enough to be there.
  (:action look-at-table
    :parameters (?table - spot)
    :precondition (and (table ?table) (robot-at ?table))
    :effect (and))

  (:action look-into
    :parameters (?vessel - ware)
    :precondition (and (vessel ?vessel) (robot-at ?vessel))
    :effect (and)))
