; A swimming pool robot: it puts things away, opens and shuts doors and covers, switches devices, doses the water, backwashes
; filters, scrubs, closes basins to bathers, and looks at water, filters and lockers before it decides.
(define (domain pool)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item - thing)

  (:predicates
    ; what never changes
    (basin ?place - place)
    (filter ?place - place)
    (locker ?place - place)
    (washable ?place - place)
    (hollow ?place - place)                 ; things go inside
    (flat ?place - place)                   ; things lie on it
    (lidded ?place - place)                 ; it has a door, a lid, or is a cover
    (device ?place - place)
    (person ?place - place)
    (agent ?item - item)                    ; goes into the water
    ; where things are and how they are
    (robot-at ?place - place)
    (in ?item - item ?place - place)
    (on ?item - item ?place - place)
    (holding ?item - item)
    (open ?place - place)
    (running ?place - place)
    (barred ?basin - place)                 ; nobody may bathe in it
    ; what only shows when the robot looks
    (clear ?basin - place)
    (cloudy ?basin - place)
    (green ?basin - place)
    (clogged ?filter - place)
    (free ?filter - place)
    (occupied ?locker - place)
    (vacant ?locker - place)
    ; what happened
    (dosed ?basin - place ?agent - item)
    (rinsed ?filter - place)
    (scrubbed ?place - place)
    (reported ?about - thing ?person - place))

  (:action go
    :parameters (?to - place)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - place) (not (robot-at ?from))) (robot-at ?to)))

  (:action take-out
    :parameters (?item - item ?from - place)
    :precondition (and (robot-at ?from) (in ?item ?from) (imply (lidded ?from) (open ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (in ?item ?from))))

  (:action take-off
    :parameters (?item - item ?from - place)
    :precondition (and (robot-at ?from) (on ?item ?from)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (on ?item ?from))))

  (:action put-in
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (hollow ?to) (imply (lidded ?to) (open ?to)))
    :effect (and (in ?item ?to) (not (holding ?item))))

  (:action put-on
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (or (flat ?to) (person ?to)))
    :effect (and (on ?item ?to) (not (holding ?item))))

  (:action open-up
    :parameters (?place - place)
    :precondition (and (lidded ?place) (robot-at ?place) (not (open ?place)))
    :effect (open ?place))

  (:action shut-up
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

  (:action dose
    :parameters (?agent - item ?basin - place)
    :precondition (and (agent ?agent) (basin ?basin) (holding ?agent) (robot-at ?basin))
    :effect (dosed ?basin ?agent))

  (:action rinse
    :parameters (?filter - place)
    :precondition (and (filter ?filter) (robot-at ?filter))
    :effect (rinsed ?filter))

  (:action scrub
    :parameters (?place - place)
    :precondition (and (washable ?place) (robot-at ?place))
    :effect (scrubbed ?place))

  (:action rope-off
    :parameters (?basin - place)
    :precondition (and (basin ?basin) (robot-at ?basin) (not (barred ?basin)))
    :effect (barred ?basin))

  (:action let-in
    :parameters (?basin - place)
    :precondition (and (basin ?basin) (robot-at ?basin) (barred ?basin))
    :effect (not (barred ?basin)))

  (:action report
    :parameters (?about - thing ?person - place)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (reported ?about ?person))

  ; Looking changes nothing.
  (:action check-water
    :parameters (?basin - place)
    :precondition (and (basin ?basin) (robot-at ?basin))
    :effect (and))

  (:action check-filter
    :parameters (?filter - place)
    :precondition (and (filter ?filter) (robot-at ?filter))
    :effect (and))

  (:action check-locker
    :parameters (?locker - place)
    :precondition (and (locker ?locker) (robot-at ?locker))
    :effect (and)))
