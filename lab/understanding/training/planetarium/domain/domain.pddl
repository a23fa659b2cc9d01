; Planetarium robot.
(define (domain planetarium)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types loc obj - ent colour angle level)

  (:constants red blue green white amber - colour)

  (:predicates
    (person ?loc - loc)
    (dev ?loc - loc)
    (hatch ?loc - loc)
    (lamp ?loc - loc)
    (sound ?loc - loc)
    (scope ?loc - loc)
    (cell ?obj - obj)
    (robot-at ?loc - loc)
    (at ?obj - obj ?loc - loc)
    (holding ?obj - obj)
    (powered ?loc - loc)
    (open ?loc - loc)
    (hue ?loc - loc ?colour - colour)
    (aimed ?loc - loc ?angle - angle)
    (loud ?loc - loc ?level - level)
    ; sensed
    (clear ?loc - loc)
    (fogged ?loc - loc)
    (full ?obj - obj)
    (half ?obj - obj)
    (flat ?obj - obj)
    ; done
    (wiped ?ent - ent)
    (pinged ?loc - loc))

  (:action nav
    :parameters (?to - loc)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - loc) (not (robot-at ?from))) (robot-at ?to)))

  (:action pick
    :parameters (?obj - obj ?from - loc)
    :precondition (and (robot-at ?from) (at ?obj ?from) (forall (?other - obj) (not (holding ?other))))
    :effect (and (holding ?obj) (not (at ?obj ?from))))

  (:action drop
    :parameters (?obj - obj ?to - loc)
    :precondition (and (robot-at ?to) (holding ?obj))
    :effect (and (at ?obj ?to) (not (holding ?obj))))

  (:action sw-on
    :parameters (?dev - loc)
    :precondition (and (dev ?dev) (not (powered ?dev)))
    :effect (powered ?dev))

  (:action sw-off
    :parameters (?dev - loc)
    :precondition (and (dev ?dev) (powered ?dev))
    :effect (not (powered ?dev)))

  (:action pull
    :parameters (?hatch - loc)
    :precondition (and (hatch ?hatch) (robot-at ?hatch) (not (open ?hatch)))
    :effect (open ?hatch))

  (:action push
    :parameters (?hatch - loc)
    :precondition (and (hatch ?hatch) (robot-at ?hatch) (open ?hatch))
    :effect (not (open ?hatch)))

  (:action set-hue
    :parameters (?lamp - loc ?colour - colour)
    :precondition (and (lamp ?lamp) (not (hue ?lamp ?colour)))
    :effect (and (forall (?other - colour) (not (hue ?lamp ?other))) (hue ?lamp ?colour)))

  (:action aim
    :parameters (?scope - loc ?angle - angle)
    :precondition (and (scope ?scope) (robot-at ?scope) (not (aimed ?scope ?angle)))
    :effect (and (forall (?other - angle) (not (aimed ?scope ?other))) (aimed ?scope ?angle)))

  (:action set-vol
    :parameters (?sound - loc ?level - level)
    :precondition (and (sound ?sound) (not (loud ?sound ?level)))
    :effect (and (forall (?other - level) (not (loud ?sound ?other))) (loud ?sound ?level)))

  (:action wipe-loc
    :parameters (?loc - loc)
    :precondition (and (robot-at ?loc) (not (person ?loc)))
    :effect (wiped ?loc))

  (:action wipe-obj
    :parameters (?obj - obj)
    :precondition (holding ?obj)
    :effect (wiped ?obj))

  (:action ping
    :parameters (?person - loc)
    :precondition (person ?person)
    :effect (pinged ?person))

  (:action look-glass
    :parameters (?scope - loc)
    :precondition (and (scope ?scope) (robot-at ?scope))
    :effect (and))

  (:action read-cell
    :parameters (?obj - obj)
    :precondition (cell ?obj)
    :effect (and)))
