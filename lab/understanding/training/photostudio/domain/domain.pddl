; photo studio robot
(define (domain photostudio)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing colour sec pct)

  (:constants red blue amber clear - colour)

  (:predicates
    (person ?spot - spot)
    (dev ?spot - spot)
    (lamp ?spot - spot)
    (lid ?spot - spot)
    (enl ?spot - spot)
    (tray ?spot - spot)
    (print ?item - item)
    (bat ?item - item)
    (robot-at ?thing - thing)
    (at ?item - item ?spot - spot)
    (holding ?item - item)
    (on ?spot - spot)
    (open ?spot - spot)
    (time ?spot - spot ?sec - sec)
    (level ?spot - spot ?pct - pct)
    (tint ?spot - spot ?colour - colour)
    (dry ?item - item)
    (wet ?item - item)
    (full ?item - item)
    (low ?item - item)
    (flat ?item - item)
    (soaked ?item - item ?spot - spot)
    (blown ?item - item)
    (charged ?item - item)
    (buzzed ?spot - spot))

  (:action go
    :parameters (?to - thing)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - thing) (not (robot-at ?from))) (robot-at ?to)))

  (:action pick
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (at ?item ?from) (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))

  (:action drop
    :parameters (?item - item ?to - spot)
    :precondition (and (robot-at ?to) (holding ?item))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action plug
    :parameters (?dev - spot)
    :precondition (and (dev ?dev) (robot-at ?dev) (not (on ?dev)))
    :effect (on ?dev))

  (:action unplug
    :parameters (?dev - spot)
    :precondition (and (dev ?dev) (robot-at ?dev) (on ?dev))
    :effect (not (on ?dev)))

  (:action unshut
    :parameters (?lid - spot)
    :precondition (and (lid ?lid) (robot-at ?lid) (not (open ?lid)))
    :effect (open ?lid))

  (:action shut
    :parameters (?lid - spot)
    :precondition (and (lid ?lid) (robot-at ?lid) (open ?lid))
    :effect (not (open ?lid)))

  (:action dial
    :parameters (?enl - spot ?sec - sec)
    :precondition (and (enl ?enl) (robot-at ?enl) (not (time ?enl ?sec)))
    :effect (and (forall (?o - sec) (not (time ?enl ?o))) (time ?enl ?sec)))

  (:action fade
    :parameters (?lamp - spot ?pct - pct)
    :precondition (and (lamp ?lamp) (robot-at ?lamp) (not (level ?lamp ?pct)))
    :effect (and (forall (?o - pct) (not (level ?lamp ?o))) (level ?lamp ?pct)))

  (:action fit
    :parameters (?lamp - spot ?colour - colour)
    :precondition (and (lamp ?lamp) (robot-at ?lamp) (not (tint ?lamp ?colour)))
    :effect (and (forall (?o - colour) (not (tint ?lamp ?o))) (tint ?lamp ?colour)))

  (:action dip
    :parameters (?print - item ?tray - spot)
    :precondition (and (print ?print) (tray ?tray) (holding ?print) (robot-at ?tray))
    :effect (soaked ?print ?tray))

  (:action puff
    :parameters (?item - item)
    :precondition (robot-at ?item)
    :effect (blown ?item))

  (:action boost
    :parameters (?bat - item)
    :precondition (and (bat ?bat) (robot-at ?bat))
    :effect (charged ?bat))

  (:action ring
    :parameters (?person - spot)
    :precondition (person ?person)
    :effect (buzzed ?person))

  (:action feel
    :parameters (?item - item)
    :precondition (and (print ?item) (robot-at ?item))
    :effect (and))

  (:action meter
    :parameters (?item - item)
    :precondition (and (bat ?item) (robot-at ?item))
    :effect (and)))
