; A pet shop robot: it carries things and animals, fills bowls, scrubs cages and tanks, and looks before it decides.
(define (domain petshop)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item - thing)

  (:predicates
    ; what never changes
    (lidded ?place - place)
    (device ?place - place)
    (person ?place - place)
    (cage ?place - place)                   ; animals live in it
    (animal ?item - item)
    (bowl ?item - item)
    (food ?item - item)
    ; where things are and how they are
    (robot-at ?place - place)
    (at ?item - item ?place - place)
    (holding ?item - item)
    (open ?place - place)
    (running ?place - place)
    (covered ?place - place)
    ; what only shows when the robot looks
    (full ?bowl - item)
    (half-full ?bowl - item)
    (empty ?bowl - item)
    (clean ?cage - place)
    (dirty ?cage - place)
    (awake ?animal - item)
    (asleep ?animal - item)
    ; what happened
    (filled ?bowl - item ?food - item)
    (was-full ?bowl - item)
    (was-half-full ?bowl - item)
    (was-empty ?bowl - item)
    (scrubbed ?cage - place)
    (was-clean ?cage - place)
    (was-dirty ?cage - place)
    (brushed ?animal - item)
    (reported ?thing - thing ?person - place))

  (:action go
    :parameters (?to - place)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - place) (not (robot-at ?from))) (robot-at ?to)))

  (:action take
    :parameters (?item - item ?from - place)
    :precondition (and (robot-at ?from) (at ?item ?from) (imply (lidded ?from) (open ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action set-down
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (imply (lidded ?to) (open ?to)))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action unlatch
    :parameters (?place - place)
    :precondition (and (lidded ?place) (robot-at ?place) (not (open ?place)))
    :effect (open ?place))

  (:action latch
    :parameters (?place - place)
    :precondition (and (lidded ?place) (robot-at ?place) (open ?place))
    :effect (not (open ?place)))

  (:action start
    :parameters (?device - place)
    :precondition (and (device ?device) (robot-at ?device) (not (running ?device)))
    :effect (running ?device))

  (:action stop
    :parameters (?device - place)
    :precondition (and (device ?device) (robot-at ?device) (running ?device))
    :effect (not (running ?device)))

  (:action drape
    :parameters (?cage - place)
    :precondition (and (cage ?cage) (robot-at ?cage) (not (covered ?cage)))
    :effect (covered ?cage))

  (:action undrape
    :parameters (?cage - place)
    :precondition (and (cage ?cage) (robot-at ?cage) (covered ?cage))
    :effect (not (covered ?cage)))

  ; How full the bowl is afterwards, only another look can tell.
  (:action pour
    :parameters (?food - item ?bowl - item)
    :precondition (and (food ?food) (bowl ?bowl) (holding ?food)
                       (exists (?place - place) (and (at ?bowl ?place) (robot-at ?place))))
    :effect (and (filled ?bowl ?food)
                 (when (full ?bowl) (was-full ?bowl))
                 (when (half-full ?bowl) (was-half-full ?bowl))
                 (when (empty ?bowl) (was-empty ?bowl))
                 (not (full ?bowl)) (not (half-full ?bowl)) (not (empty ?bowl))))

  (:action scrub
    :parameters (?cage - place)
    :precondition (and (cage ?cage) (robot-at ?cage))
    :effect (and (scrubbed ?cage)
                 (when (clean ?cage) (was-clean ?cage))
                 (when (dirty ?cage) (was-dirty ?cage))
                 (not (clean ?cage)) (not (dirty ?cage))))

  (:action brush
    :parameters (?animal - item)
    :precondition (and (animal ?animal)
                       (exists (?place - place) (and (at ?animal ?place) (robot-at ?place))))
    :effect (brushed ?animal))

  (:action report
    :parameters (?thing - thing ?person - place)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (reported ?thing ?person))

  ; To look at something, the robot only has to stand where it is.
  (:action look-how-full
    :parameters (?bowl - item)
    :precondition (and (bowl ?bowl)
                       (exists (?place - place) (and (at ?bowl ?place) (robot-at ?place))))
    :effect (and))

  (:action look-for-dirt
    :parameters (?cage - place)
    :precondition (and (cage ?cage) (robot-at ?cage))
    :effect (and))

  (:action look-for-sleep
    :parameters (?animal - item)
    :precondition (and (animal ?animal)
                       (exists (?place - place) (and (at ?animal ?place) (robot-at ?place))))
    :effect (and)))
