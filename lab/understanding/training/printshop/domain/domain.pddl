; A print shop robot: it moves, pins up and hands over things, loads machines, copies, laminates, trims and captions sheets, works switches, lids and doors.
(define (domain printshop)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing copies width wording)

  (:predicates
    (person ?spot - spot)
    (holds ?spot - spot)                    ; a drawer, a folder, a bin
    (flat ?spot - spot)                     ; a counter, a shelf, a machine with a flat lid
    (board ?spot - spot)                    ; a pinboard
    (feeds ?spot - spot)                    ; a printer or paper tray that paper and ink go into
    (opens ?spot - spot)
    (device ?spot - spot)
    (copier ?spot - spot)
    (laminator ?spot - spot)
    (cutter ?spot - spot)
    (sheet ?item - item)                    ; printed matter
    (supply ?item - item)                   ; paper, ink, toner
    (inside ?item - item ?spot - spot)
    (upon ?item - item ?spot - spot)
    (by ?item - item ?thing - thing)
    (pinned ?item - item ?board - spot)
    (loaded ?item - item ?machine - spot)
    (with ?item - item ?person - spot)
    (holding ?item - item)
    (open ?spot - spot)
    (on ?spot - spot)
    ; what happened
    (run-off ?item - item ?copies - copies)
    (laminated ?item - item)
    (trimmed ?item - item ?width - width)
    (captioned ?item - item ?wording - wording))

  (:action pick-up
    :parameters (?item - item)
    :precondition (and (forall (?other - item) (not (holding ?other)))
                       (forall (?spot - spot) (imply (and (inside ?item ?spot) (opens ?spot)) (open ?spot))))
    :effect (and (holding ?item)
                 (forall (?spot - spot) (and (not (inside ?item ?spot)) (not (upon ?item ?spot)) (not (pinned ?item ?spot))
                                             (not (loaded ?item ?spot)) (not (with ?item ?spot))))
                 (forall (?thing - thing) (not (by ?item ?thing)))))

  (:action slip-in
    :parameters (?item - item ?spot - spot)
    :precondition (and (holding ?item) (holds ?spot) (imply (opens ?spot) (open ?spot)))
    :effect (and (inside ?item ?spot) (not (holding ?item))))

  (:action lay-upon
    :parameters (?item - item ?spot - spot)
    :precondition (and (holding ?item) (flat ?spot))
    :effect (and (upon ?item ?spot) (not (holding ?item))))

  (:action set-by
    :parameters (?item - item ?thing - thing)
    :precondition (and (holding ?item) (not (= ?item ?thing)))
    :effect (and (by ?item ?thing) (not (holding ?item))))

  (:action pin
    :parameters (?item - item ?board - spot)
    :precondition (and (holding ?item) (sheet ?item) (board ?board))
    :effect (and (pinned ?item ?board) (not (holding ?item))))

  (:action load
    :parameters (?item - item ?machine - spot)
    :precondition (and (holding ?item) (supply ?item) (feeds ?machine))
    :effect (and (loaded ?item ?machine) (not (holding ?item))))

  (:action hand-over
    :parameters (?item - item ?person - spot)
    :precondition (and (holding ?item) (person ?person))
    :effect (and (with ?item ?person) (not (holding ?item))))

  (:action copy
    :parameters (?item - item ?copier - spot ?copies - copies)
    :precondition (and (holding ?item) (sheet ?item) (copier ?copier))
    :effect (run-off ?item ?copies))

  (:action laminate
    :parameters (?item - item ?laminator - spot)
    :precondition (and (holding ?item) (sheet ?item) (laminator ?laminator))
    :effect (laminated ?item))

  (:action trim
    :parameters (?item - item ?cutter - spot ?width - width)
    :precondition (and (holding ?item) (sheet ?item) (cutter ?cutter))
    :effect (trimmed ?item ?width))

  (:action caption
    :parameters (?item - item ?wording - wording)
    :precondition (holding ?item)
    :effect (captioned ?item ?wording))

  (:action power-up
    :parameters (?device - spot)
    :precondition (and (device ?device) (not (on ?device)))
    :effect (on ?device))

  (:action power-down
    :parameters (?device - spot)
    :precondition (and (device ?device) (on ?device))
    :effect (not (on ?device)))

  (:action pull-open
    :parameters (?spot - spot)
    :precondition (and (opens ?spot) (not (open ?spot)))
    :effect (open ?spot))

  (:action push-closed
    :parameters (?spot - spot)
    :precondition (and (opens ?spot) (open ?spot))
    :effect (not (open ?spot))))
