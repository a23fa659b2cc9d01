; A camping van robot: it stows bedding, bags and bottles in, on and under things, opens lids, sets up the awning and the table, switches devices.
(define (domain caravan)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item - thing temperature)

  (:predicates
    (hollow ?place - place)                 ; things go in
    (lidded ?place - place)                 ; has a lid or a door
    (flat ?place - place)                   ; things go on it
    (raised ?place - place)                 ; things go under it
    (folding ?place - place)
    (device ?place - place)
    (heater ?place - place)
    (burner ?place - place)                 ; burns gas
    (person ?place - place)
    (bottle ?item - item)
    (cloth ?item - item)
    (robot-at ?place - place)
    (in ?item - item ?place - place)
    (on ?item - item ?place - place)
    (under ?item - item ?place - place)
    (holding ?item - item)
    (open ?place - place)
    (unfolded ?place - place)
    (running ?place - place)
    (warms ?place - place ?temperature - temperature)
    (feeds ?item - item ?place - place)
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

  (:action pull-out
    :parameters (?item - item ?from - place)
    :precondition (and (robot-at ?from) (under ?item ?from)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (under ?item ?from))))

  (:action stow
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (hollow ?to) (imply (lidded ?to) (open ?to)))
    :effect (and (in ?item ?to) (not (holding ?item))))

  (:action lay
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (or (flat ?to) (person ?to)))
    :effect (and (on ?item ?to) (not (holding ?item))))

  (:action slide
    :parameters (?item - item ?to - place)
    :precondition (and (holding ?item) (robot-at ?to) (raised ?to))
    :effect (and (under ?item ?to) (not (holding ?item))))

  (:action lift-lid
    :parameters (?place - place)
    :precondition (and (lidded ?place) (robot-at ?place) (not (open ?place)))
    :effect (open ?place))

  (:action shut-lid
    :parameters (?place - place)
    :precondition (and (lidded ?place) (robot-at ?place) (open ?place))
    :effect (not (open ?place)))

  (:action unfold
    :parameters (?place - place)
    :precondition (and (folding ?place) (robot-at ?place) (not (unfolded ?place)))
    :effect (unfolded ?place))

  (:action fold
    :parameters (?place - place)
    :precondition (and (folding ?place) (robot-at ?place) (unfolded ?place))
    :effect (not (unfolded ?place)))

  (:action switch-on
    :parameters (?place - place)
    :precondition (and (device ?place) (robot-at ?place) (not (running ?place)))
    :effect (running ?place))

  (:action switch-off
    :parameters (?place - place)
    :precondition (and (device ?place) (robot-at ?place) (running ?place))
    :effect (not (running ?place)))

  (:action dial
    :parameters (?heater - place ?temperature - temperature)
    :precondition (and (heater ?heater) (robot-at ?heater) (running ?heater) (not (warms ?heater ?temperature)))
    :effect (and (forall (?other - temperature) (not (warms ?heater ?other))) (warms ?heater ?temperature)))

  (:action connect
    :parameters (?bottle - item ?burner - place)
    :precondition (and (bottle ?bottle) (burner ?burner) (holding ?bottle) (robot-at ?burner))
    :effect (feeds ?bottle ?burner))

  (:action wipe
    :parameters (?place - place ?cloth - item)
    :precondition (and (cloth ?cloth) (holding ?cloth) (robot-at ?place) (not (person ?place)))
    :effect (wiped ?place ?cloth)))
