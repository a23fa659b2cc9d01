; A day nursery robot: it tidies toys in and on chests, settles, covers and dresses children, fills bottles, opens lids, switches lights and music.
(define (domain nursery)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item - thing volume)

  (:predicates
    (hollow ?place - place)                 ; things go in
    (lidded ?place - place)                 ; has a lid or a drawer
    (flat ?place - place)                   ; things go on it
    (restful ?place - place)                ; children lie or sit here
    (lamp ?place - place)
    (player ?place - place)
    (tap ?place - place)
    (person ?place - place)
    (child ?place - place)
    (blanket ?item - item)
    (garment ?item - item)
    (bottle ?item - item)
    (cloth ?item - item)
    (robot-at ?place - place)
    (in ?item - item ?place - place)
    (on ?item - item ?place - place)
    (has ?person - place ?item - item)
    (wears ?person - place ?item - item)
    (covers ?item - item ?person - place)
    (rests ?child - place ?place - place)
    (holding ?item - item)
    (open ?place - place)
    (running ?place - place)
    (contains ?bottle - item ?volume - volume)
    ; what happened
    (wiped ?place - place ?cloth - item))

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

  (:action take-from
    :parameters (?item - item ?person - place)
    :precondition (and (robot-at ?person) (or (has ?person ?item) (wears ?person ?item) (covers ?item ?person))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (has ?person ?item)) (not (wears ?person ?item)) (not (covers ?item ?person))))

  (:action drop-in
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (hollow ?to) (imply (lidded ?to) (open ?to)))
    :effect (and (in ?item ?to) (not (holding ?item))))

  (:action lay
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (flat ?to))
    :effect (and (on ?item ?to) (not (holding ?item))))

  (:action hand
    :parameters (?item - item ?person - place)
    :precondition (and (holding ?item) (robot-at ?person) (person ?person))
    :effect (and (has ?person ?item) (not (holding ?item))))

  (:action dress
    :parameters (?person - place ?item - item)
    :precondition (and (garment ?item) (child ?person) (holding ?item) (robot-at ?person))
    :effect (and (wears ?person ?item) (not (holding ?item))))

  (:action cover
    :parameters (?person - place ?item - item)
    :precondition (and (blanket ?item) (person ?person) (holding ?item) (robot-at ?person))
    :effect (and (covers ?item ?person) (not (holding ?item))))

  (:action settle
    :parameters (?child - place ?to - place)
    :precondition (and (child ?child) (restful ?to) (robot-at ?child)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (forall (?from - place) (not (rests ?child ?from))) (rests ?child ?to)))

  (:action lift-lid
    :parameters (?place - place)
    :precondition (and (lidded ?place) (robot-at ?place) (not (open ?place)))
    :effect (open ?place))

  (:action shut-lid
    :parameters (?place - place)
    :precondition (and (lidded ?place) (robot-at ?place) (open ?place))
    :effect (not (open ?place)))

  (:action switch-on
    :parameters (?place - place)
    :precondition (and (or (lamp ?place) (player ?place)) (robot-at ?place) (not (running ?place)))
    :effect (running ?place))

  (:action switch-off
    :parameters (?place - place)
    :precondition (and (or (lamp ?place) (player ?place)) (robot-at ?place) (running ?place))
    :effect (not (running ?place)))

  (:action fill
    :parameters (?bottle - item ?volume - volume ?tap - place)
    :precondition (and (bottle ?bottle) (tap ?tap) (holding ?bottle) (robot-at ?tap))
    :effect (and (forall (?other - volume) (not (contains ?bottle ?other))) (contains ?bottle ?volume)))

  (:action wipe
    :parameters (?place - place ?cloth - item)
    :precondition (and (cloth ?cloth) (holding ?cloth) (robot-at ?place))
    :effect (wiped ?place ?cloth)))
