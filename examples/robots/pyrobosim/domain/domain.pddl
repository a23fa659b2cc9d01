; A pyrobosim robot: it drives between rooms through hallways, carries one thing at a time, opens and closes.
(define (domain pyrobosim)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types site item - thing)

  (:predicates
    ; what never changes
    (room ?site - site)
    (place ?site - site)                    ; things can be put there
    (hallway ?site - site)
    (locked ?site - site)                   ; cannot be opened or closed
    (in-room ?place - site ?room - site)
    (joins ?hallway - site ?room - site)
    (shares ?place - site ?other - site)    ; two places of one piece of furniture
    ; where things are and how they are
    (on ?item - item ?place - site)
    (holding ?item - item)
    (closed ?site - site)
    (robot-at ?site - site)
    (robot-in ?room - site)
    ; what happened
    (visited ?site - site))

  ; To a room where the robot is, or through an open hallway into the next one.
  (:action enter
    :parameters (?room - site)
    :precondition (and (room ?room) (not (robot-at ?room))
                       (or (robot-in ?room)
                           (exists (?hallway - site ?from - site)
                             (and (joins ?hallway ?from) (joins ?hallway ?room) (robot-in ?from)
                                  (not (closed ?hallway))))))
    :effect (and (forall (?site - site) (and (not (robot-at ?site)) (not (robot-in ?site))))
                 (robot-at ?room) (robot-in ?room) (visited ?room)))

  ; To a place in the room, or to the near end of a hallway.
  (:action approach
    :parameters (?site - site)
    :precondition (and (not (room ?site)) (not (robot-at ?site))
                       (exists (?room - site)
                         (and (robot-in ?room) (or (in-room ?site ?room) (joins ?site ?room)))))
    :effect (and (forall (?other - site) (not (robot-at ?other))) (robot-at ?site) (visited ?site)))

  (:action pick
    :parameters (?item - item ?place - site)
    :precondition (and (on ?item ?place) (robot-at ?place) (not (closed ?place))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (on ?item ?place))))

  (:action put-down
    :parameters (?item - item ?place - site)
    :precondition (and (holding ?item) (place ?place) (robot-at ?place) (not (closed ?place)))
    :effect (and (on ?item ?place) (not (holding ?item))))

  ; It needs its hand for that.
  (:action open
    :parameters (?site - site)
    :precondition (and (not (room ?site)) (robot-at ?site) (closed ?site) (not (locked ?site))
                       (forall (?item - item) (not (holding ?item))))
    :effect (and (not (closed ?site))
                 (forall (?other - site) (when (shares ?site ?other) (not (closed ?other))))))

  (:action close
    :parameters (?site - site)
    :precondition (and (not (room ?site)) (robot-at ?site) (not (closed ?site)) (not (locked ?site))
                       (forall (?item - item) (not (holding ?item))))
    :effect (and (closed ?site)
                 (forall (?other - site) (when (shares ?site ?other) (closed ?other))))))
