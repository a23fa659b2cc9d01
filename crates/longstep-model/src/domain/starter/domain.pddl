; What the robot can do, in standard PDDL. Every planner reads this file unchanged.
;
; This robot drives between stations and carries parcels. Change it to yours: a type for what stays where it
; is, a type for what can be moved, predicates for what can be true, and an action for each thing that the
; robot can be told to do.
(define (domain NAME)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types station parcel - thing)

  (:predicates
    (at ?parcel - parcel ?station - station)
    (robot-at ?station - station)
    (carrying ?parcel - parcel))

  (:action drive
    :parameters (?to - station)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - station) (not (robot-at ?from)))
                 (robot-at ?to)))

  (:action pick
    :parameters (?parcel - parcel ?from - station)
    :precondition (and (robot-at ?from) (at ?parcel ?from)
                       (forall (?other - parcel) (not (carrying ?other))))
    :effect (and (carrying ?parcel) (not (at ?parcel ?from))))

  (:action drop
    :parameters (?parcel - parcel ?to - station)
    :precondition (and (robot-at ?to) (carrying ?parcel))
    :effect (and (at ?parcel ?to) (not (carrying ?parcel)))))
