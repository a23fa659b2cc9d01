; A robot with one arm in front of shelves, tables, fridges and drawers.
;
; The thirteen actions of Wake et al. (2023) change how a grasped thing is held by its surroundings: a thing
; on a plane is constrained by it until it is detached, and a handle stays where it is and only turns or
; slides.
(define (domain household)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types asset item - thing)

  (:predicates
    ; what never changes
    (can-open ?thing - thing)                  ; it has a handle
    (handle-of ?handle - item ?thing - thing)
    (fixed ?thing - thing)                     ; part of something, cannot be carried
    (container ?thing - thing)                 ; what is put down in it is inside it
    (bin ?thing - thing)                       ; things may be dropped into it
    (base ?thing - thing)                      ; something may stand on it or lie in it
    (upright ?thing - thing)                   ; a plane on which nothing stays by itself
    (rotates ?handle - thing)
    (slides ?handle - thing)
    (next-to ?thing - thing ?other - thing)
    ; where things are
    (on ?thing - thing ?place - thing)
    (inside ?thing - thing ?place - thing)
    (open ?thing - thing)
    (closed ?thing - thing)
    ; the hand
    (hand-at ?thing - thing)
    (holding ?item - item)
    (lifted ?item - item)                      ; held, and constrained by nothing
    ; what happened
    (wiped ?place - thing ?tool - item)
    (adjusted ?handle - item))

  ; Of equally short plans, search prefers the action that comes first here: what is carried is moved.
  (:action move-object
    :parameters (?item - item ?to - thing)
    :precondition (and (holding ?item) (lifted ?item))
    :effect (and (forall (?other - thing) (not (hand-at ?other)))
                 (hand-at ?to)))

  (:action move-hand
    :parameters (?to - thing)
    ; a hand that holds on to something constrained cannot go elsewhere
    :precondition (forall (?held - item) (imply (holding ?held) (lifted ?held)))
    :effect (and (forall (?other - thing) (not (hand-at ?other)))
                 (hand-at ?to)))

  (:action grasp
    :parameters (?item - item)
    :precondition (and (hand-at ?item)
                       (forall (?other - item) (not (holding ?other)))
                       (forall (?around - thing ?handle - item)
                         (imply (and (inside ?item ?around) (handle-of ?handle ?around))
                                (not (closed ?handle)))))
    :effect (holding ?item))

  (:action release
    :parameters (?item - item)
    ; not in mid-air, unless over a bin, and not against a wall
    :precondition (and (holding ?item)
                       (or (not (lifted ?item))
                           (exists (?below - thing) (and (bin ?below) (hand-at ?below))))
                       (forall (?plane - thing) (imply (upright ?plane) (not (on ?item ?plane)))))
    :effect (and (not (holding ?item))
                 (forall (?below - thing)
                   (when (and (lifted ?item) (bin ?below) (hand-at ?below)) (inside ?item ?below)))
                 (not (lifted ?item))))

  (:action detach
    :parameters (?item - item ?from - thing)
    :precondition (and (holding ?item)
                       (not (lifted ?item))
                       (not (fixed ?item))
                       (or (on ?item ?from) (inside ?item ?from)))
    :effect (and (forall (?place - thing) (and (not (on ?item ?place)) (not (inside ?item ?place))))
                 (lifted ?item)))

  (:action attach
    :parameters (?item - item ?to - thing)
    :precondition (and (holding ?item)
                       (lifted ?item)
                       (hand-at ?to)
                       (not (= ?item ?to))
                       (not (fixed ?to))
                       (forall (?handle - item) (imply (handle-of ?handle ?to) (not (closed ?handle)))))
    :effect (and (not (lifted ?item))
                 (when (container ?to) (inside ?item ?to))
                 (when (not (container ?to)) (on ?item ?to))))

  (:action open-by-rotate
    :parameters (?handle - item)
    :precondition (and (holding ?handle) (closed ?handle) (rotates ?handle))
    :effect (and (open ?handle) (not (closed ?handle))))

  (:action adjust-by-rotate
    :parameters (?handle - item)
    :precondition (and (holding ?handle) (not (closed ?handle)) (rotates ?handle))
    :effect (adjusted ?handle))

  (:action close-by-rotate
    :parameters (?handle - item)
    :precondition (and (holding ?handle) (open ?handle) (rotates ?handle))
    :effect (and (closed ?handle) (not (open ?handle))))

  (:action open-by-slide
    :parameters (?handle - item)
    :precondition (and (holding ?handle) (closed ?handle) (slides ?handle))
    :effect (and (open ?handle) (not (closed ?handle))))

  (:action adjust-by-slide
    :parameters (?handle - item)
    :precondition (and (holding ?handle) (not (closed ?handle)) (slides ?handle))
    :effect (adjusted ?handle))

  (:action close-by-slide
    :parameters (?handle - item)
    :precondition (and (holding ?handle) (open ?handle) (slides ?handle))
    :effect (and (closed ?handle) (not (open ?handle))))

  (:action wipe
    :parameters (?tool - item ?place - thing)
    :precondition (and (holding ?tool) (not (lifted ?tool)) (not (fixed ?tool)) (on ?tool ?place))
    :effect (wiped ?place ?tool)))
