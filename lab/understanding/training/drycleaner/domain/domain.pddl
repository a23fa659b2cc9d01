; A dry cleaner's robot: it carries garments, steams, sprays, bags and tickets them, fills machines, serves customers,
; and can look at a garment before it decides.
(define (domain drycleaner)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item)

  (:predicates
    ; what never changes
    (store ?place - place)                  ; things can lie, hang or be put there
    (lidded ?place - place)
    (device ?place - place)
    (fillable ?place - place)
    (person ?place - place)
    (cloth ?item - item)
    (fluid ?item - item)
    ; where things are and how they are
    (robot-at ?place - place)
    (at ?item - item ?place - place)
    (holding ?item - item)
    (open ?place - place)
    (running ?place - place)
    (bagged ?item - item)
    (ticketed ?item - item)
    ; what only shows when the robot looks
    (spotless ?item - item)
    (stained ?item - item)
    (dry ?item - item)
    (damp ?item - item)
    (wet ?item - item)
    (whole ?item - item)
    (torn ?item - item)
    ; what happened
    (steamed ?item - item)
    (treated ?item - item)
    (topped-up ?place - place ?fluid - item)
    (told ?person - place))

  (:action go
    :parameters (?to - place)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - place) (not (robot-at ?from))) (robot-at ?to)))

  (:action take
    :parameters (?item - item ?from - place)
    :precondition (and (robot-at ?from) (at ?item ?from) (imply (lidded ?from) (open ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action put
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (store ?to) (imply (lidded ?to) (open ?to)))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action hand-over
    :parameters (?item - item ?person - place)
    :precondition (and (holding ?item) (robot-at ?person) (person ?person))
    :effect (and (at ?item ?person) (not (holding ?item))))

  (:action steam
    :parameters (?item - item ?place - place)
    :precondition (and (cloth ?item) (robot-at ?place) (at ?item ?place) (imply (lidded ?place) (open ?place)))
    :effect (steamed ?item))

  (:action treat
    :parameters (?item - item ?place - place)
    :precondition (and (cloth ?item) (robot-at ?place) (at ?item ?place) (imply (lidded ?place) (open ?place)))
    :effect (treated ?item))

  (:action bag
    :parameters (?item - item ?place - place)
    :precondition (and (cloth ?item) (not (bagged ?item)) (robot-at ?place) (at ?item ?place)
                       (imply (lidded ?place) (open ?place)))
    :effect (bagged ?item))

  (:action pin-ticket
    :parameters (?item - item ?place - place)
    :precondition (and (cloth ?item) (not (ticketed ?item)) (robot-at ?place) (at ?item ?place)
                       (imply (lidded ?place) (open ?place)))
    :effect (ticketed ?item))

  (:action pour
    :parameters (?fluid - item ?machine - place)
    :precondition (and (fluid ?fluid) (holding ?fluid) (fillable ?machine) (robot-at ?machine))
    :effect (topped-up ?machine ?fluid))

  (:action unlatch
    :parameters (?place - place)
    :precondition (and (lidded ?place) (robot-at ?place) (not (open ?place)))
    :effect (open ?place))

  (:action latch
    :parameters (?place - place)
    :precondition (and (lidded ?place) (robot-at ?place) (open ?place))
    :effect (not (open ?place)))

  (:action switch-on
    :parameters (?place - place)
    :precondition (and (device ?place) (robot-at ?place) (not (running ?place)))
    :effect (running ?place))

  (:action switch-off
    :parameters (?place - place)
    :precondition (and (device ?place) (robot-at ?place) (running ?place))
    :effect (not (running ?place)))

  (:action tell
    :parameters (?person - place)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (told ?person))

  ; Sensing: the robot needs only to be where the garment is, or to have it in its hand.
  (:action check-stains
    :parameters (?item - item)
    :precondition (and (cloth ?item)
                       (or (holding ?item)
                           (exists (?place - place) (and (at ?item ?place) (robot-at ?place)))))
    :effect (and))

  (:action check-damp
    :parameters (?item - item)
    :precondition (and (cloth ?item)
                       (or (holding ?item)
                           (exists (?place - place) (and (at ?item ?place) (robot-at ?place)))))
    :effect (and))

  (:action check-seams
    :parameters (?item - item)
    :precondition (and (cloth ?item)
                       (or (holding ?item)
                           (exists (?place - place) (and (at ?item ?place) (robot-at ?place)))))
    :effect (and)))
