; A robot in a chemist's shop: it stocks, hands out, measures, grinds and labels remedies, minds doors and devices, orders
; and informs, and looks at dates and dispensers before it decides what to do.
(define (domain pharmacy)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types fixture article - entity volume minutes packs usage)

  (:constants before_meals after_meals bedtime external - usage)

  (:predicates
    ; what never changes
    (human ?fixture - fixture)
    (storage ?entity - entity)
    (barrier ?entity - entity)
    (appliance ?fixture - fixture)
    (remedy ?article - article)
    (dispenser ?entity - entity)
    ; where things are and how they are
    (robot-near ?entity - entity)
    (located ?article - article ?entity - entity)
    (carried ?article - article)
    (ajar ?entity - entity)
    (live ?fixture - fixture)
    (contents ?entity - entity ?volume - volume)
    (alarm ?fixture - fixture ?minutes - minutes)
    (directions ?article - article ?usage - usage)
    ; what only a look tells
    (in-date ?article - article)
    (expiring ?article - article)
    (expired ?article - article)
    (run-out ?entity - entity)
    (supplied ?entity - entity)
    ; what happened
    (powdered ?article - article)
    (sanitary ?entity - entity)
    (aware ?entity - entity ?human - fixture)
    (ordered ?article - article ?packs - packs))

  (:action approach
    :parameters (?to - entity)
    :precondition (not (robot-near ?to))
    :effect (and (forall (?from - entity) (not (robot-near ?from))) (robot-near ?to)))

  (:action lift
    :parameters (?article - article ?from - entity)
    :precondition (and (robot-near ?from) (located ?article ?from) (forall (?other - article) (not (carried ?other))))
    :effect (and (carried ?article) (not (located ?article ?from))))

  (:action shelve
    :parameters (?article - article ?to - entity)
    :precondition (and (carried ?article) (robot-near ?to) (storage ?to) (not (= ?article ?to)))
    :effect (and (located ?article ?to) (not (carried ?article))))

  (:action present
    :parameters (?article - article ?human - fixture)
    :precondition (and (carried ?article) (robot-near ?human) (human ?human))
    :effect (and (located ?article ?human) (not (carried ?article))))

  (:action unlatch
    :parameters (?entity - entity)
    :precondition (and (barrier ?entity) (robot-near ?entity) (not (ajar ?entity)))
    :effect (ajar ?entity))

  (:action latch
    :parameters (?entity - entity)
    :precondition (and (barrier ?entity) (robot-near ?entity) (ajar ?entity))
    :effect (not (ajar ?entity)))

  (:action start-up
    :parameters (?appliance - fixture)
    :precondition (and (appliance ?appliance) (robot-near ?appliance) (not (live ?appliance)))
    :effect (live ?appliance))

  (:action shut-off
    :parameters (?appliance - fixture)
    :precondition (and (appliance ?appliance) (robot-near ?appliance) (live ?appliance))
    :effect (not (live ?appliance)))

  (:action pour
    :parameters (?vessel - entity ?volume - volume)
    :precondition (and (dispenser ?vessel) (robot-near ?vessel) (not (contents ?vessel ?volume)))
    :effect (and (forall (?other - volume) (not (contents ?vessel ?other))) (contents ?vessel ?volume)))

  (:action wind
    :parameters (?appliance - fixture ?minutes - minutes)
    :precondition (and (appliance ?appliance) (robot-near ?appliance) (not (alarm ?appliance ?minutes)))
    :effect (and (forall (?other - minutes) (not (alarm ?appliance ?other))) (alarm ?appliance ?minutes)))

  (:action write-directions
    :parameters (?remedy - article ?usage - usage)
    :precondition (and (remedy ?remedy) (robot-near ?remedy) (not (directions ?remedy ?usage)))
    :effect (and (forall (?other - usage) (not (directions ?remedy ?other))) (directions ?remedy ?usage)))

  (:action crush
    :parameters (?remedy - article)
    :precondition (and (remedy ?remedy) (robot-near ?remedy))
    :effect (powdered ?remedy))

  (:action disinfect
    :parameters (?entity - entity)
    :precondition (robot-near ?entity)
    :effect (sanitary ?entity))

  (:action inform
    :parameters (?entity - entity ?human - fixture)
    :precondition (and (human ?human) (robot-near ?human))
    :effect (aware ?entity ?human))

  (:action place-order
    :parameters (?article - article ?packs - packs)
    :precondition (not (ordered ?article ?packs))
    :effect (ordered ?article ?packs))

  ; Standing in front of the thing is enough.
  (:action read-date
    :parameters (?remedy - article)
    :precondition (and (remedy ?remedy) (robot-near ?remedy))
    :effect (and))

  (:action look-inside
    :parameters (?vessel - entity)
    :precondition (and (dispenser ?vessel) (robot-near ?vessel))
    :effect (and)))
