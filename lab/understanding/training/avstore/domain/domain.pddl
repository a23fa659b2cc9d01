; A robot in a store that lends out cameras, microphones and lights. It stows and hands out gear, charges, cleans, tags and
; scans it, and can look at batteries, lenses and cases before it decides.
(define (domain avstore)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item - thing)

  (:predicates
    ; what never changes
    (base ?place - place)                   ; things are put on it or in it
    (charger ?place - place)
    (stand ?place - place)
    (person ?place - place)
    (lidded ?place - place)
    (device ?place - place)
    (powered ?item - item)                  ; it is a battery or has one
    (lens ?item - item)                     ; it is a lens or has one
    (kit ?item - item)                      ; a case, bag or kit of several parts
    ; where things are and how they are
    (robot-at ?place - place)
    (at ?item - item ?place - place)
    (holding ?item - item)
    (open ?place - place)
    (running ?place - place)
    ; what only shows when the robot looks
    (charged ?item - item)
    (low ?item - item)
    (dead ?item - item)
    (flawless ?item - item)
    (scratched ?item - item)
    (complete ?item - item)
    (incomplete ?item - item)
    ; what happened
    (wiped ?thing - thing)
    (tagged ?item - item)
    (scanned ?item - item)
    (reported ?item - item ?person - place))

  (:action go
    :parameters (?to - place)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - place) (not (robot-at ?from))) (robot-at ?to)))

  (:action take
    :parameters (?item - item ?from - place)
    :precondition (and (robot-at ?from) (at ?item ?from) (imply (lidded ?from) (open ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action put-down
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (base ?to) (imply (lidded ?to) (open ?to)))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action hand-over
    :parameters (?item - item ?person - place)
    :precondition (and (holding ?item) (robot-at ?person) (person ?person))
    :effect (and (at ?item ?person) (not (holding ?item))))

  (:action plug-in
    :parameters (?item - item ?charger - place)
    :precondition (and (holding ?item) (powered ?item) (robot-at ?charger) (charger ?charger))
    :effect (and (at ?item ?charger) (not (holding ?item))))

  (:action mount
    :parameters (?item - item ?stand - place)
    :precondition (and (holding ?item) (robot-at ?stand) (stand ?stand))
    :effect (and (at ?item ?stand) (not (holding ?item))))

  (:action unlock
    :parameters (?place - place)
    :precondition (and (lidded ?place) (robot-at ?place) (not (open ?place)))
    :effect (open ?place))

  (:action shut
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

  (:action wipe-item
    :parameters (?item - item ?place - place)
    :precondition (and (robot-at ?place) (at ?item ?place) (imply (lidded ?place) (open ?place)))
    :effect (wiped ?item))

  (:action wipe-place
    :parameters (?place - place)
    :precondition (and (robot-at ?place) (not (person ?place)))
    :effect (wiped ?place))

  (:action tag
    :parameters (?item - item ?place - place)
    :precondition (and (robot-at ?place) (at ?item ?place) (imply (lidded ?place) (open ?place)))
    :effect (tagged ?item))

  (:action scan
    :parameters (?item - item ?place - place)
    :precondition (and (robot-at ?place) (at ?item ?place) (imply (lidded ?place) (open ?place)))
    :effect (scanned ?item))

  (:action report
    :parameters (?item - item ?person - place)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (reported ?item ?person))

  ; The robot sees from where the thing is, in its hand as well.
  (:action check-battery
    :parameters (?item - item)
    :precondition (and (powered ?item)
                       (or (holding ?item)
                           (exists (?place - place) (and (at ?item ?place) (robot-at ?place)))))
    :effect (and))

  (:action check-lens
    :parameters (?item - item)
    :precondition (and (lens ?item)
                       (or (holding ?item)
                           (exists (?place - place) (and (at ?item ?place) (robot-at ?place)))))
    :effect (and))

  (:action check-contents
    :parameters (?item - item)
    :precondition (and (kit ?item)
                       (or (holding ?item)
                           (exists (?place - place) (and (at ?item ?place) (robot-at ?place)))))
    :effect (and)))
