; A tailor's robot: it carries clothes and haberdashery, sews and presses, minds machines and doors, measures and calls
; people, and looks at garments and bobbins before it decides what to do.
(define (domain tailor)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types station article - object length)

  (:predicates
    (person ?station - station)
    (appliance ?station - station)
    (sewer ?station - station)
    (shutter ?station - station)
    (fabric ?station - station)
    (garment ?article - article)
    (notion ?article - article)
    (spool ?article - article)
    (robot-at ?station - station)
    (at ?article - article ?station - station)
    (carrying ?article - article)
    (working ?station - station)
    (open ?station - station)
    (threaded ?station - station ?spool - article)
    ; what only a look tells
    (intact ?article - article)
    (stained ?article - article)
    (torn ?article - article)
    (bobbin-full ?station - station)
    (bobbin-empty ?station - station)
    ; what happened
    (hemmed ?article - article ?length - length)
    (pressed ?article - article ?fabric - station)
    (sewn ?article - article ?notion - article)
    (brushed ?article - article)
    (measured ?station - station)
    (called ?station - station))

  (:action walk
    :parameters (?to - station)
    :precondition (and (not (robot-at ?to)) (not (fabric ?to)))
    :effect (and (forall (?from - station) (not (robot-at ?from))) (robot-at ?to)))

  (:action pick
    :parameters (?article - article ?from - station)
    :precondition (and (robot-at ?from) (at ?article ?from)
                       (forall (?other - article) (not (carrying ?other))))
    :effect (and (carrying ?article) (not (at ?article ?from))))

  (:action drop
    :parameters (?article - article ?to - station)
    :precondition (and (carrying ?article) (robot-at ?to))
    :effect (and (at ?article ?to) (not (carrying ?article))))

  (:action switch
    :parameters (?appliance - station)
    :precondition (and (appliance ?appliance) (robot-at ?appliance) (not (working ?appliance)))
    :effect (working ?appliance))

  (:action unplug
    :parameters (?appliance - station)
    :precondition (and (appliance ?appliance) (robot-at ?appliance) (working ?appliance))
    :effect (not (working ?appliance)))

  (:action draw
    :parameters (?shutter - station)
    :precondition (and (shutter ?shutter) (robot-at ?shutter) (not (open ?shutter)))
    :effect (open ?shutter))

  (:action push
    :parameters (?shutter - station)
    :precondition (and (shutter ?shutter) (robot-at ?shutter) (open ?shutter))
    :effect (not (open ?shutter)))

  (:action load
    :parameters (?sewer - station ?spool - article)
    :precondition (and (sewer ?sewer) (spool ?spool) (robot-at ?sewer) (not (threaded ?sewer ?spool)))
    :effect (and (forall (?other - article) (not (threaded ?sewer ?other))) (threaded ?sewer ?spool)))

  (:action turn-up
    :parameters (?article - article ?length - length ?where - station)
    :precondition (and (garment ?article) (robot-at ?where) (at ?article ?where))
    :effect (hemmed ?article ?length))

  (:action steam
    :parameters (?article - article ?fabric - station ?where - station)
    :precondition (and (garment ?article) (fabric ?fabric) (robot-at ?where) (at ?article ?where))
    :effect (pressed ?article ?fabric))

  (:action stitch
    :parameters (?article - article ?notion - article ?where - station)
    :precondition (and (garment ?article) (notion ?notion) (robot-at ?where) (at ?article ?where))
    :effect (sewn ?article ?notion))

  (:action dust
    :parameters (?article - article ?where - station)
    :precondition (and (garment ?article) (robot-at ?where) (at ?article ?where))
    :effect (brushed ?article))

  (:action size
    :parameters (?person - station)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (measured ?person))

  (:action shout
    :parameters (?person - station)
    :precondition (person ?person)
    :effect (called ?person))

  (:action inspect
    :parameters (?article - article ?where - station)
    :precondition (and (garment ?article) (robot-at ?where) (at ?article ?where))
    :effect (and))

  (:action peek
    :parameters (?sewer - station)
    :precondition (and (sewer ?sewer) (robot-at ?sewer))
    :effect (and)))
