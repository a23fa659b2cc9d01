; A town hall robot: it carries papers, parcels and flags, switches lamps and machines, minds doors, masts and radiators,
; sets rooms out, copies and stamps papers, tells people things, and listens at rooms and looks for signatures first.
(define (domain townhall)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types landmark article - entity temperature count)

  (:predicates
    ; what never changes
    (room ?landmark - landmark)
    (ledge ?landmark - landmark)
    (door ?landmark - landmark)
    (device ?landmark - landmark)
    (radiator ?landmark - landmark)
    (mast ?landmark - landmark)
    (layout ?landmark - landmark)
    (official ?landmark - landmark)
    (document ?article - article)
    (flag ?article - article)
    ; where things are and how they are
    (robot-at ?entity - entity)
    (lies ?article - article ?landmark - landmark)
    (flies ?article - article ?mast - landmark)
    (carrying ?article - article)
    (open ?landmark - landmark)
    (running ?landmark - landmark)
    (set-to ?landmark - landmark ?temperature - temperature)
    (set-out ?landmark - landmark ?layout - landmark)
    ; what only a look or a listen tells
    (deserted ?landmark - landmark)
    (in-session ?landmark - landmark)
    (being-cleaned ?landmark - landmark)
    (signed ?article - article)
    (unsigned ?article - article)
    ; what happened
    (copied ?article - article ?count - count)
    (stamped ?article - article)
    (informed ?person - landmark ?matter - entity))

  (:action proceed
    :parameters (?to - entity)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - entity) (not (robot-at ?from))) (robot-at ?to)))

  (:action collect
    :parameters (?article - article ?from - landmark)
    :precondition (and (robot-at ?from) (lies ?article ?from) (imply (door ?from) (open ?from))
                       (forall (?other - article) (not (carrying ?other))))
    :effect (and (carrying ?article) (not (lies ?article ?from))))

  (:action leave
    :parameters (?article - article ?to - landmark)
    :precondition (and (carrying ?article) (robot-at ?to) (ledge ?to) (imply (door ?to) (open ?to)))
    :effect (and (lies ?article ?to) (not (carrying ?article))))

  (:action hand-over
    :parameters (?article - article ?person - landmark)
    :precondition (and (carrying ?article) (robot-at ?person) (official ?person))
    :effect (and (lies ?article ?person) (not (carrying ?article))))

  (:action hoist
    :parameters (?flag - article ?mast - landmark)
    :precondition (and (flag ?flag) (mast ?mast) (carrying ?flag) (robot-at ?mast))
    :effect (and (flies ?flag ?mast) (not (carrying ?flag))))

  (:action lower
    :parameters (?flag - article ?mast - landmark)
    :precondition (and (flies ?flag ?mast) (robot-at ?mast) (forall (?other - article) (not (carrying ?other))))
    :effect (and (carrying ?flag) (not (flies ?flag ?mast))))

  (:action start
    :parameters (?device - landmark)
    :precondition (and (device ?device) (robot-at ?device) (not (running ?device)))
    :effect (running ?device))

  (:action stop
    :parameters (?device - landmark)
    :precondition (and (device ?device) (robot-at ?device) (running ?device))
    :effect (not (running ?device)))

  (:action swing-open
    :parameters (?door - landmark)
    :precondition (and (door ?door) (robot-at ?door) (not (open ?door)))
    :effect (open ?door))

  (:action push-to
    :parameters (?door - landmark)
    :precondition (and (door ?door) (robot-at ?door) (open ?door))
    :effect (not (open ?door)))

  (:action turn-valve
    :parameters (?radiator - landmark ?temperature - temperature)
    :precondition (and (radiator ?radiator) (robot-at ?radiator) (not (set-to ?radiator ?temperature)))
    :effect (and (forall (?other - temperature) (not (set-to ?radiator ?other))) (set-to ?radiator ?temperature)))

  (:action set-chairs
    :parameters (?room - landmark ?layout - landmark)
    :precondition (and (room ?room) (layout ?layout) (robot-at ?room) (not (set-out ?room ?layout)))
    :effect (and (forall (?other - landmark) (not (set-out ?room ?other))) (set-out ?room ?layout)))

  (:action copy
    :parameters (?document - article ?count - count)
    :precondition (and (document ?document) (robot-at ?document))
    :effect (copied ?document ?count))

  (:action stamp
    :parameters (?document - article)
    :precondition (and (document ?document) (robot-at ?document))
    :effect (stamped ?document))

  (:action inform
    :parameters (?person - landmark ?matter - entity)
    :precondition (and (official ?person) (robot-at ?person))
    :effect (informed ?person ?matter))

  ; It is enough to stand in front of the room or the paper.
  (:action listen-in
    :parameters (?landmark - landmark)
    :precondition (and (room ?landmark) (robot-at ?landmark))
    :effect (and))

  (:action look-for-signature
    :parameters (?article - article)
    :precondition (and (document ?article) (robot-at ?article))
    :effect (and)))
