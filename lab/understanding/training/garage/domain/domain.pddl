; A garage robot: it stows tools, parks and lifts cars, fits and pumps up wheels, tops up fluids and serves customers.
(define (domain garage)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item - thing pressure)

  (:predicates
    ; what never changes
    (car ?place - place)
    (spot ?place - place)                   ; a car can stand there
    (hollow ?place - place)                 ; things go inside
    (flat ?place - place)                   ; things lie on it
    (lidded ?place - place)
    (device ?place - place)
    (person ?place - place)
    (wheel ?item - item)
    (jack ?item - item)
    (fluid ?item - item)
    (pneumatic ?thing - thing)
    ; where things are and how they are
    (robot-at ?place - place)
    (in ?item - item ?place - place)
    (on ?item - item ?place - place)
    (fitted ?wheel - item ?car - place)
    (holding ?item - item)
    (parked ?car - place ?spot - place)
    (lifted ?car - place ?jack - item)
    (open ?place - place)
    (running ?place - place)
    (pumped ?thing - thing ?pressure - pressure)
    ; what happened
    (filled ?car - place ?fluid - item)
    (notified ?person - place))

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

  (:action fit
    :parameters (?wheel - item ?car - place)
    :precondition (and (wheel ?wheel) (car ?car) (holding ?wheel) (robot-at ?car))
    :effect (and (fitted ?wheel ?car) (not (holding ?wheel))))

  (:action unbolt
    :parameters (?wheel - item ?car - place)
    :precondition (and (fitted ?wheel ?car) (robot-at ?car)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?wheel) (not (fitted ?wheel ?car))))

  (:action drive
    :parameters (?car - place ?to - place)
    :precondition (and (car ?car) (spot ?to) (robot-at ?car) (not (parked ?car ?to))
                       (forall (?jack - item) (not (lifted ?car ?jack))))
    :effect (and (forall (?from - place) (not (parked ?car ?from))) (parked ?car ?to)))

  (:action jack-up
    :parameters (?jack - item ?car - place)
    :precondition (and (jack ?jack) (car ?car) (holding ?jack) (robot-at ?car))
    :effect (and (lifted ?car ?jack) (not (holding ?jack))))

  (:action let-down
    :parameters (?car - place ?jack - item)
    :precondition (and (lifted ?car ?jack) (robot-at ?car)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?jack) (not (lifted ?car ?jack))))

  (:action pour
    :parameters (?fluid - item ?car - place)
    :precondition (and (fluid ?fluid) (car ?car) (holding ?fluid) (robot-at ?car))
    :effect (filled ?car ?fluid))

  (:action inflate-car
    :parameters (?car - place ?pressure - pressure)
    :precondition (and (car ?car) (pneumatic ?car) (robot-at ?car) (not (pumped ?car ?pressure)))
    :effect (and (forall (?other - pressure) (not (pumped ?car ?other))) (pumped ?car ?pressure)))

  (:action inflate-wheel
    :parameters (?wheel - item ?pressure - pressure)
    :precondition (and (wheel ?wheel) (pneumatic ?wheel) (not (pumped ?wheel ?pressure))
                       (or (holding ?wheel)
                           (exists (?car - place) (and (fitted ?wheel ?car) (robot-at ?car)))))
    :effect (and (forall (?other - pressure) (not (pumped ?wheel ?other))) (pumped ?wheel ?pressure)))

  (:action unlatch
    :parameters (?place - place)
    :precondition (and (lidded ?place) (robot-at ?place) (not (open ?place)))
    :effect (open ?place))

  (:action latch
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

  (:action notify
    :parameters (?person - place)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (notified ?person)))
