; A hotel robot: it brings things to rooms, makes rooms up, vacuums, restocks, knocks, locks, and minds curtains and heating.
(define (domain hotel)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item - thing temperature)

  (:predicates
    (guest-room ?place - place)
    (bar ?place - place)                     ; has a minibar
    (heating ?place - place)
    (window ?place - place)                  ; has curtains
    (red ?item - item)
    (blue ?item - item)
    (black ?item - item)
    (white ?item - item)
    (robot-at ?place - place)
    (at ?item - item ?place - place)
    (carrying ?item - item)
    (locked ?place - place)
    (undisturbed ?place - place)             ; the sign "do not disturb" hangs on the door
    (untidy ?place - place)
    (curtains-open ?place - place)
    (set-to ?place - place ?temperature - temperature)
    ; what happened
    (vacuumed ?place - place)
    (restocked ?place - place)
    (knocked ?place - place))

  (:action go
    :parameters (?to - place)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - place) (not (robot-at ?from))) (robot-at ?to)))

  (:action take
    :parameters (?item - item ?from - place)
    :precondition (and (robot-at ?from) (at ?item ?from) (not (locked ?from)) (not (undisturbed ?from))
                       (forall (?other - item) (not (carrying ?other))))
    :effect (and (carrying ?item) (not (at ?item ?from))))

  (:action leave
    :parameters (?item - item ?to - place)
    :precondition (and (robot-at ?to) (carrying ?item) (not (locked ?to)) (not (undisturbed ?to)))
    :effect (and (at ?item ?to) (not (carrying ?item))))

  (:action unlock
    :parameters (?room - place)
    :precondition (and (guest-room ?room) (robot-at ?room) (locked ?room) (not (undisturbed ?room)))
    :effect (not (locked ?room)))

  (:action lock
    :parameters (?room - place)
    :precondition (and (guest-room ?room) (robot-at ?room) (not (locked ?room)))
    :effect (locked ?room))

  (:action make-up
    :parameters (?room - place)
    :precondition (and (guest-room ?room) (robot-at ?room) (untidy ?room) (not (locked ?room)) (not (undisturbed ?room)))
    :effect (not (untidy ?room)))

  (:action vacuum
    :parameters (?place - place)
    :precondition (and (robot-at ?place) (not (locked ?place)) (not (undisturbed ?place)))
    :effect (vacuumed ?place))

  (:action restock
    :parameters (?place - place)
    :precondition (and (bar ?place) (robot-at ?place) (not (locked ?place)) (not (undisturbed ?place)))
    :effect (restocked ?place))

  (:action knock
    :parameters (?room - place)
    :precondition (and (guest-room ?room) (robot-at ?room) (not (undisturbed ?room)))
    :effect (knocked ?room))

  (:action open-curtains
    :parameters (?place - place)
    :precondition (and (window ?place) (robot-at ?place) (not (curtains-open ?place)) (not (locked ?place)) (not (undisturbed ?place)))
    :effect (curtains-open ?place))

  (:action draw-curtains
    :parameters (?place - place)
    :precondition (and (window ?place) (robot-at ?place) (curtains-open ?place) (not (locked ?place)) (not (undisturbed ?place)))
    :effect (not (curtains-open ?place)))

  (:action set-heating
    :parameters (?place - place ?temperature - temperature)
    :precondition (and (heating ?place) (robot-at ?place) (not (locked ?place)) (not (undisturbed ?place))
                       (not (set-to ?place ?temperature)))
    :effect (and (forall (?other - temperature) (not (set-to ?place ?other))) (set-to ?place ?temperature))))
