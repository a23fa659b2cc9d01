;; The counter robot of a coffee bar: it makes drinks, carries things, fills, empties and cleans, switches and opens
;; things, calls guests, and smells and looks into things before it decides.
(define (domain coffeebar)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types station item - thing drink heat weight)

  (:constants espresso americano cappuccino flat_white latte - drink)

  (:predicates
    ; what never changes
    (person ?station - station)
    (machine ?station - station)
    (maker ?station - station)              ; brews and steams
    (grinder ?station - station)
    (openable ?station - station)
    (vessel ?thing - thing)
    (cup ?item - item)
    (jug ?item - item)
    (beans ?item - item)
    (extra ?item - item)
    (perishable ?item - item)
    ; where things are and how they are
    (robot-at ?thing - thing)
    (at ?item - item ?station - station)
    (holding ?item - item)
    (open ?station - station)
    (running ?station - station)
    ; what only a look or a sniff tells
    (fresh ?item - item)
    (spoiled ?item - item)
    (brimming ?thing - thing)
    (half-full ?thing - thing)
    (empty ?thing - thing)
    ; what happened
    (brewed ?drink - drink ?cup - item)
    (steamed ?jug - item ?heat - heat)
    (ground ?beans - item ?weight - weight)
    (splashed ?extra - item ?cup - item)
    (filled ?thing - thing)
    (tipped ?thing - thing)
    (cleaned ?thing - thing)
    (called ?station - station))

  (:action move
    :parameters (?to - thing)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - thing) (not (robot-at ?from))) (robot-at ?to)))

  (:action fetch
    :parameters (?item - item ?from - station)
    :precondition (and (robot-at ?from) (at ?item ?from) (imply (openable ?from) (open ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action set-down
    :parameters (?item - item ?to - station)
    :precondition (and (holding ?item) (robot-at ?to) (imply (openable ?to) (open ?to)))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action prepare
    :parameters (?drink - drink ?cup - item ?maker - station)
    :precondition (and (cup ?cup) (maker ?maker) (holding ?cup) (robot-at ?maker))
    :effect (brewed ?drink ?cup))

  (:action froth
    :parameters (?jug - item ?heat - heat ?maker - station)
    :precondition (and (jug ?jug) (maker ?maker) (holding ?jug) (robot-at ?maker))
    :effect (steamed ?jug ?heat))

  (:action mill
    :parameters (?beans - item ?weight - weight ?grinder - station)
    :precondition (and (beans ?beans) (grinder ?grinder) (holding ?beans) (robot-at ?grinder))
    :effect (ground ?beans ?weight))

  (:action splash
    :parameters (?extra - item ?cup - item)
    :precondition (and (extra ?extra) (cup ?cup) (holding ?extra) (robot-at ?cup))
    :effect (splashed ?extra ?cup))

  (:action top-up
    :parameters (?vessel - thing)
    :precondition (and (vessel ?vessel) (robot-at ?vessel))
    :effect (filled ?vessel))

  (:action tip
    :parameters (?vessel - thing)
    :precondition (and (vessel ?vessel) (robot-at ?vessel))
    :effect (tipped ?vessel))

  (:action scrub
    :parameters (?thing - thing)
    :precondition (robot-at ?thing)
    :effect (cleaned ?thing))

  (:action start
    :parameters (?machine - station)
    :precondition (and (machine ?machine) (robot-at ?machine) (not (running ?machine)))
    :effect (running ?machine))

  (:action stop
    :parameters (?machine - station)
    :precondition (and (machine ?machine) (robot-at ?machine) (running ?machine))
    :effect (not (running ?machine)))

  (:action swing-open
    :parameters (?door - station)
    :precondition (and (openable ?door) (robot-at ?door) (not (open ?door)))
    :effect (open ?door))

  (:action pull-to
    :parameters (?door - station)
    :precondition (and (openable ?door) (robot-at ?door) (open ?door))
    :effect (not (open ?door)))

  (:action shout
    :parameters (?person - station)
    :precondition (person ?person)
    :effect (called ?person))

  (:action sniff
    :parameters (?item - item)
    :precondition (and (perishable ?item) (robot-at ?item))
    :effect (and))

  (:action peek
    :parameters (?thing - thing)
    :precondition (and (vessel ?thing) (robot-at ?thing))
    :effect (and)))
