; A robot in a bakery: it carries things, finishes and cuts bakes, minds machines and doors, and calls people.
(define (domain bakery)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing temperature)

  (:predicates
    (person ?spot - spot)
    (machine ?spot - spot)
    (door ?spot - spot)
    (oven ?spot - spot)
    (bake ?item - item)
    (topping ?item - item)
    (blade ?item - item)
    (robot-at ?spot - spot)
    (at ?item - item ?spot - spot)
    (holding ?item - item)
    (running ?spot - spot)
    (open ?spot - spot)
    (heat ?spot - spot ?temperature - temperature)
    ; what happened
    (topped ?item - item ?topping - item)
    (cut-with ?item - item ?blade - item)
    (paged ?spot - spot))

  (:action roll
    :parameters (?to - spot)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to)))

  (:action grab
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (at ?item ?from)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action release
    :parameters (?item - item ?to - spot)
    :precondition (and (holding ?item) (robot-at ?to))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action top
    :parameters (?item - item ?topping - item ?where - spot)
    :precondition (and (bake ?item) (topping ?topping) (holding ?topping) (robot-at ?where) (at ?item ?where))
    :effect (topped ?item ?topping))

  (:action cut
    :parameters (?item - item ?blade - item ?where - spot)
    :precondition (and (bake ?item) (blade ?blade) (holding ?blade) (robot-at ?where) (at ?item ?where))
    :effect (cut-with ?item ?blade))

  (:action start
    :parameters (?machine - spot)
    :precondition (and (machine ?machine) (robot-at ?machine) (not (running ?machine)))
    :effect (running ?machine))

  (:action stop
    :parameters (?machine - spot)
    :precondition (and (machine ?machine) (robot-at ?machine) (running ?machine))
    :effect (not (running ?machine)))

  (:action pull-open
    :parameters (?door - spot)
    :precondition (and (door ?door) (robot-at ?door) (not (open ?door)))
    :effect (open ?door))

  (:action push-shut
    :parameters (?door - spot)
    :precondition (and (door ?door) (robot-at ?door) (open ?door))
    :effect (not (open ?door)))

  (:action dial
    :parameters (?oven - spot ?temperature - temperature)
    :precondition (and (oven ?oven) (robot-at ?oven) (not (heat ?oven ?temperature)))
    :effect (and (forall (?other - temperature) (not (heat ?oven ?other))) (heat ?oven ?temperature)))

  (:action page
    :parameters (?person - spot)
    :precondition (person ?person)
    :effect (paged ?person)))
