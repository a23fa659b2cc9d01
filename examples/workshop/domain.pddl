; A workshop robot that clamps, drills, sands and paints workpieces, with machines that have guards.
(define (domain workshop)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality :numeric-fluents)

  (:types station item - thing depth)

  (:predicates
    (drill ?station - station)
    (bench ?station - station)
    (sharp ?station - station)               ; has a guard
    (workpiece ?item - item)
    (bit ?item - item)
    (paint ?item - item)
    (sander ?item - item)
    (at ?item - item ?station - station)
    (holding ?item - item)
    (mounted ?bit - item ?station - station)
    (clamped ?item - item ?station - station)
    (guard-open ?station - station)
    (powered ?station - station)
    (drilled ?item - item ?bit - item)
    (drilled-to ?item - item ?bit - item ?depth - depth)
    (painted ?item - item ?paint - item)
    (sanded ?item - item)
    (vacuumed ?station - station))

  (:functions (holes ?item - item))

  (:action take
    :parameters (?item - item ?from - station)
    :precondition (and (at ?item ?from) (not (clamped ?item ?from)) (not (mounted ?item ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action lay
    :parameters (?item - item ?to - station)
    :precondition (holding ?item)
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action clamp
    :parameters (?item - item ?station - station)
    :precondition (and (workpiece ?item) (or (drill ?station) (bench ?station)) (at ?item ?station)
                       (not (powered ?station))
                       (forall (?other - item) (and (not (holding ?other)) (not (clamped ?other ?station)))))
    :effect (clamped ?item ?station))

  (:action unclamp
    :parameters (?item - item ?station - station)
    :precondition (and (clamped ?item ?station) (not (powered ?station))
                       (forall (?other - item) (not (holding ?other))))
    :effect (not (clamped ?item ?station)))

  (:action mount
    :parameters (?bit - item ?station - station)
    :precondition (and (bit ?bit) (drill ?station) (at ?bit ?station) (not (powered ?station))
                       (forall (?other - item) (and (not (holding ?other)) (not (mounted ?other ?station)))))
    :effect (mounted ?bit ?station))

  (:action unmount
    :parameters (?bit - item ?station - station)
    :precondition (and (mounted ?bit ?station) (not (powered ?station))
                       (forall (?other - item) (not (holding ?other))))
    :effect (not (mounted ?bit ?station)))

  (:action open-guard
    :parameters (?station - station)
    :precondition (and (sharp ?station) (not (guard-open ?station)) (not (powered ?station)))
    :effect (guard-open ?station))

  (:action close-guard
    :parameters (?station - station)
    :precondition (and (sharp ?station) (guard-open ?station))
    :effect (not (guard-open ?station)))

  (:action switch-on
    :parameters (?station - station)
    :precondition (and (sharp ?station) (not (guard-open ?station)) (not (powered ?station)))
    :effect (powered ?station))

  (:action switch-off
    :parameters (?station - station)
    :precondition (powered ?station)
    :effect (not (powered ?station)))

  (:action bore
    :parameters (?item - item ?bit - item ?station - station)
    :precondition (and (powered ?station) (clamped ?item ?station) (mounted ?bit ?station))
    :effect (and (drilled ?item ?bit) (increase (holes ?item) 1)))

  (:action bore-to
    :parameters (?item - item ?bit - item ?depth - depth ?station - station)
    :precondition (and (powered ?station) (clamped ?item ?station) (mounted ?bit ?station))
    :effect (and (drilled ?item ?bit) (increase (holes ?item) 1) (drilled-to ?item ?bit ?depth)))

  (:action sand
    :parameters (?item - item ?sander - item ?station - station)
    :precondition (and (bench ?station) (clamped ?item ?station) (sander ?sander) (holding ?sander))
    :effect (and (sanded ?item) (forall (?paint - item) (not (painted ?item ?paint)))))

  (:action paint
    :parameters (?item - item ?paint - item ?station - station)
    :precondition (and (bench ?station) (at ?item ?station) (workpiece ?item) (paint ?paint) (holding ?paint))
    :effect (and (forall (?other - item) (not (painted ?item ?other))) (painted ?item ?paint)))

  (:action vacuum
    :parameters (?station - station)
    :precondition (and (not (powered ?station)) (forall (?other - item) (not (holding ?other))))
    :effect (vacuumed ?station)))
