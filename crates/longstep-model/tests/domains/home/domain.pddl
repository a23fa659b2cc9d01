; A home whose robot sets the thermostat, heats meals and speaks.
(define (domain home)
  (:requirements :strips :typing :negative-preconditions :conditional-effects)
  (:types device meal - object  temperature duration message colour - object)
  (:constants red green - colour)
  (:predicates
    (set-to ?d - device ?t - temperature)
    (is-oven ?d - device)
    (heated ?m - meal ?d - device ?t - duration)
    (announced ?m - message)
    (shines ?d - device ?c - colour))

  (:action set
    :parameters (?d - device ?t - temperature)
    :precondition (not (set-to ?d ?t))
    :effect (and (set-to ?d ?t) (forall (?o - temperature) (when (set-to ?d ?o) (not (set-to ?d ?o))))))

  (:action heat
    :parameters (?m - meal ?d - device ?t - duration)
    :precondition (is-oven ?d)
    :effect (heated ?m ?d ?t))

  (:action announce
    :parameters (?m - message)
    :effect (announced ?m))

  (:action shine
    :parameters (?d - device ?c - colour)
    :effect (shines ?d ?c)))
