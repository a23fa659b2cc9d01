; A robot with one gripper between racks and centrifuges. A centrifuge spins with its lid closed and capped tubes.
(define (domain lab)
  (:requirements :strips :typing :negative-preconditions :quantified-preconditions :conditional-effects
                 :disjunctive-preconditions)
  (:types tube place - object rack centrifuge - place)
  (:predicates
    (at ?place - place)
    (in ?tube - tube ?place - place)
    (holding ?tube - tube)
    (hand-free)
    (capped ?tube - tube)
    (lid-open ?centrifuge - centrifuge)
    (filled ?tube - tube)
    (spun ?tube - tube))
  (:action go
    :parameters (?from - place ?to - place)
    :precondition (at ?from)
    :effect (and (not (at ?from)) (at ?to)))
  (:action take
    :parameters (?tube - tube ?rack - rack)
    :precondition (and (at ?rack) (in ?tube ?rack) (hand-free))
    :effect (and (holding ?tube) (not (in ?tube ?rack)) (not (hand-free))))
  (:action put
    :parameters (?tube - tube ?rack - rack)
    :precondition (and (at ?rack) (holding ?tube))
    :effect (and (in ?tube ?rack) (hand-free) (not (holding ?tube))))
  (:action load
    :parameters (?tube - tube ?centrifuge - centrifuge)
    :precondition (and (at ?centrifuge) (holding ?tube) (lid-open ?centrifuge))
    :effect (and (in ?tube ?centrifuge) (hand-free) (not (holding ?tube))))
  (:action unload
    :parameters (?tube - tube ?centrifuge - centrifuge)
    :precondition (and (at ?centrifuge) (in ?tube ?centrifuge) (hand-free) (lid-open ?centrifuge))
    :effect (and (holding ?tube) (not (in ?tube ?centrifuge)) (not (hand-free))))
  (:action cap
    :parameters (?tube - tube ?rack - rack)
    :precondition (and (at ?rack) (in ?tube ?rack) (hand-free) (not (capped ?tube)))
    :effect (capped ?tube))
  (:action uncap
    :parameters (?tube - tube ?rack - rack)
    :precondition (and (at ?rack) (in ?tube ?rack) (hand-free) (capped ?tube))
    :effect (not (capped ?tube)))
  (:action pour
    :parameters (?from - tube ?to - tube ?rack - rack)
    :precondition (and (at ?rack) (holding ?from) (in ?to ?rack) (filled ?from) (not (filled ?to))
                       (not (capped ?from)) (not (capped ?to)))
    :effect (and (filled ?to) (not (filled ?from)) (not (spun ?to)) (when (spun ?from) (spun ?to))))
  (:action open-lid
    :parameters (?centrifuge - centrifuge)
    :precondition (and (at ?centrifuge) (hand-free) (not (lid-open ?centrifuge)))
    :effect (lid-open ?centrifuge))
  (:action close-lid
    :parameters (?centrifuge - centrifuge)
    :precondition (and (at ?centrifuge) (hand-free) (lid-open ?centrifuge))
    :effect (not (lid-open ?centrifuge)))
  (:action spin
    :parameters (?centrifuge - centrifuge)
    :precondition (and (at ?centrifuge) (hand-free) (not (lid-open ?centrifuge))
                       (exists (?tube - tube) (in ?tube ?centrifuge))
                       (forall (?tube - tube) (imply (in ?tube ?centrifuge) (capped ?tube))))
    :effect (forall (?tube - tube) (when (in ?tube ?centrifuge) (spun ?tube)))))
