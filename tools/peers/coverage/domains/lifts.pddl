; Lifts with places for passengers; express lifts stop on some floors only.
(define (domain lifts)
  (:requirements :strips :typing)
  (:types lift seat passenger floor - object)
  (:predicates
    (stops ?lift - lift ?floor - floor)
    (seat-of ?seat - seat ?lift - lift)
    (at-floor ?lift - lift ?floor - floor)
    (waits ?passenger - passenger ?floor - floor)
    (sits ?passenger - passenger ?seat - seat)
    (free ?seat - seat))
  (:action ride
    :parameters (?lift - lift ?from - floor ?to - floor)
    :precondition (and (at-floor ?lift ?from) (stops ?lift ?to))
    :effect (and (not (at-floor ?lift ?from)) (at-floor ?lift ?to)))
  (:action board
    :parameters (?passenger - passenger ?lift - lift ?seat - seat ?floor - floor)
    :precondition (and (waits ?passenger ?floor) (at-floor ?lift ?floor) (seat-of ?seat ?lift) (free ?seat))
    :effect (and (sits ?passenger ?seat) (not (waits ?passenger ?floor)) (not (free ?seat))))
  (:action leave
    :parameters (?passenger - passenger ?lift - lift ?seat - seat ?floor - floor)
    :precondition (and (sits ?passenger ?seat) (seat-of ?seat ?lift) (at-floor ?lift ?floor))
    :effect (and (waits ?passenger ?floor) (free ?seat) (not (sits ?passenger ?seat)))))
