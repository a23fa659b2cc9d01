; A hair salon robot: it parks and passes things, seats people, runs dryers for minutes, writes in the appointment book, opens, closes and switches.
(define (domain salon)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types place item - thing minutes entry)

  (:predicates
    (person ?place - place)
    (roomy ?place - place)                  ; things go inside
    (flat ?place - place)                   ; things lie or stand on it
    (seat ?place - place)
    (opens ?place - place)
    (switchable ?place - place)
    (timer ?place - place)                  ; runs for a number of minutes
    (inside ?item - item ?place - place)
    (upon ?item - item ?place - place)
    (by ?item - item ?thing - thing)
    (has ?person - place ?item - item)
    (sits ?person - place ?seat - place)
    (holding ?item - item)
    (open ?place - place)
    (powered ?place - place)
    ; what happened
    (run-for ?place - place ?minutes - minutes)
    (written ?entry - entry))

  (:action grab
    :parameters (?item - item)
    :precondition (and (forall (?other - item) (not (holding ?other)))
                       (forall (?place - place) (imply (and (inside ?item ?place) (opens ?place)) (open ?place))))
    :effect (and (holding ?item)
                 (forall (?place - place) (and (not (inside ?item ?place)) (not (upon ?item ?place)) (not (has ?place ?item))))
                 (forall (?thing - thing) (not (by ?item ?thing)))))

  (:action stow
    :parameters (?item - item ?place - place)
    :precondition (and (holding ?item) (roomy ?place) (imply (opens ?place) (open ?place)))
    :effect (and (inside ?item ?place) (not (holding ?item))))

  (:action lay
    :parameters (?item - item ?place - place)
    :precondition (and (holding ?item) (flat ?place))
    :effect (and (upon ?item ?place) (not (holding ?item))))

  (:action stand-by
    :parameters (?item - item ?thing - thing)
    :precondition (and (holding ?item) (not (= ?item ?thing)))
    :effect (and (by ?item ?thing) (not (holding ?item))))

  (:action pass
    :parameters (?item - item ?person - place)
    :precondition (and (holding ?item) (person ?person))
    :effect (and (has ?person ?item) (not (holding ?item))))

  (:action show-to-seat
    :parameters (?person - place ?seat - place)
    :precondition (and (person ?person) (seat ?seat)
                       (forall (?other - place) (not (sits ?other ?seat))))
    :effect (and (forall (?other - place) (not (sits ?person ?other)))
                 (sits ?person ?seat)))

  (:action set-timer
    :parameters (?device - place ?minutes - minutes)
    :precondition (timer ?device)
    :effect (run-for ?device ?minutes))

  (:action write
    :parameters (?entry - entry)
    :precondition (and)
    :effect (written ?entry))

  (:action power-up
    :parameters (?device - place)
    :precondition (and (switchable ?device) (not (powered ?device)))
    :effect (powered ?device))

  (:action power-down
    :parameters (?device - place)
    :precondition (and (switchable ?device) (powered ?device))
    :effect (not (powered ?device)))

  (:action pull-open
    :parameters (?place - place)
    :precondition (and (opens ?place) (not (open ?place)))
    :effect (open ?place))

  (:action push-shut
    :parameters (?place - place)
    :precondition (and (opens ?place) (open ?place))
    :effect (not (open ?place))))
