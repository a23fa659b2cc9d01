; A robot in a dance school: two studios, changing rooms, music, lights, props and small gadgets with batteries.
(define (domain dancestudio)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types fixture article - entity loudness)

  (:predicates
    ; what never changes
    (human ?fixture - fixture)
    (room ?fixture - fixture)
    (light ?fixture - fixture)
    (player ?fixture - fixture)
    (movable ?fixture - fixture)            ; has a leaf, a sash or a curtain that opens
    (roomy ?fixture - fixture)              ; things can be put there
    (music ?article - article)
    (gadget ?article - article)
    ; how things are
    (robot-at ?entity - entity)
    (at ?article - article ?fixture - fixture)
    (holding ?article - article)
    (lit ?fixture - fixture)
    (open ?fixture - fixture)
    (plays ?fixture - fixture ?music - article)
    (loud ?fixture - fixture ?loudness - loudness)
    (charging ?article - article)
    ; what only a look tells
    (occupied ?fixture - fixture)
    (vacant ?fixture - fixture)
    (charged ?article - article)
    (weak ?article - article)
    (dead ?article - article)
    ; what happened
    (cleaned ?fixture - fixture)
    (told ?human - fixture ?matter - entity))

  (:action walk
    :parameters (?to - entity)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - entity) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?article - article ?from - fixture)
    :precondition (and (robot-at ?from) (at ?article ?from) (forall (?other - article) (not (holding ?other))))
    :effect (and (holding ?article) (not (at ?article ?from))))

  (:action lay
    :parameters (?article - article ?to - fixture)
    :precondition (and (holding ?article) (robot-at ?to) (roomy ?to))
    :effect (and (at ?article ?to) (not (holding ?article))))

  (:action hand
    :parameters (?article - article ?human - fixture)
    :precondition (and (holding ?article) (robot-at ?human) (human ?human))
    :effect (and (at ?article ?human) (not (holding ?article))))

  (:action light-up
    :parameters (?light - fixture)
    :precondition (and (light ?light) (robot-at ?light) (not (lit ?light)))
    :effect (lit ?light))

  (:action put-out
    :parameters (?light - fixture)
    :precondition (and (light ?light) (robot-at ?light) (lit ?light))
    :effect (not (lit ?light)))

  (:action play
    :parameters (?player - fixture ?music - article)
    :precondition (and (player ?player) (music ?music) (robot-at ?player) (not (plays ?player ?music)))
    :effect (and (forall (?other - article) (not (plays ?player ?other))) (plays ?player ?music)))

  (:action pause
    :parameters (?player - fixture)
    :precondition (and (player ?player) (robot-at ?player))
    :effect (forall (?any - article) (not (plays ?player ?any))))

  (:action turn-knob
    :parameters (?player - fixture ?loudness - loudness)
    :precondition (and (player ?player) (robot-at ?player) (not (loud ?player ?loudness)))
    :effect (and (forall (?other - loudness) (not (loud ?player ?other))) (loud ?player ?loudness)))

  (:action swing-open
    :parameters (?fixture - fixture)
    :precondition (and (movable ?fixture) (robot-at ?fixture) (not (open ?fixture)))
    :effect (open ?fixture))

  (:action draw-shut
    :parameters (?fixture - fixture)
    :precondition (and (movable ?fixture) (robot-at ?fixture) (open ?fixture))
    :effect (not (open ?fixture)))

  (:action scrub
    :parameters (?fixture - fixture)
    :precondition (and (not (human ?fixture)) (robot-at ?fixture))
    :effect (cleaned ?fixture))

  (:action plug-in
    :parameters (?gadget - article)
    :precondition (and (gadget ?gadget) (robot-at ?gadget))
    :effect (charging ?gadget))

  (:action tell
    :parameters (?human - fixture ?matter - entity)
    :precondition (and (human ?human) (robot-at ?human))
    :effect (told ?human ?matter))

  (:action look-into
    :parameters (?room - fixture)
    :precondition (and (room ?room) (robot-at ?room))
    :effect (and))

  (:action read-battery
    :parameters (?gadget - article)
    :precondition (and (gadget ?gadget) (robot-at ?gadget))
    :effect (and)))
