; Archive robot.
(define (domain archive)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types loc doc - ent dpi pct)

  (:predicates
    (surf ?l - loc)
    (flap ?l - loc)
    (dev ?l - loc)
    (hygro ?l - loc)
    (usr ?l - loc)
    (seat ?l - loc)
    (col ?l - loc)
    (paper ?d - doc)
    (robot-at ?e - ent)
    (at ?d - doc ?l - loc)
    (held ?d - doc)
    (is-open ?l - loc)
    (on ?l - loc)
    (rh-is ?l - loc ?p - pct)
    (tagged ?d - doc ?c - loc)
    ; sensed
    (fine ?d - doc)
    (torn ?d - doc)
    (mouldy ?d - doc)
    (vacant ?l - loc)
    (taken ?l - loc)
    ; done
    (scanned ?d - doc ?r - dpi)
    (wrapped ?d - doc)
    (dusted ?e - ent)
    (rung ?l - loc))

  (:action go
    :parameters (?e - ent)
    :precondition (not (robot-at ?e))
    :effect (and (forall (?x - ent) (not (robot-at ?x))) (robot-at ?e)))

  (:action pick
    :parameters (?d - doc ?l - loc)
    :precondition (and (robot-at ?l) (at ?d ?l) (forall (?x - doc) (not (held ?x))))
    :effect (and (held ?d) (not (at ?d ?l))))

  (:action drop
    :parameters (?d - doc ?l - loc)
    :precondition (and (held ?d) (robot-at ?l) (or (surf ?l) (usr ?l)))
    :effect (and (at ?d ?l) (not (held ?d))))

  (:action unlatch
    :parameters (?l - loc)
    :precondition (and (flap ?l) (robot-at ?l) (not (is-open ?l)))
    :effect (is-open ?l))

  (:action latch
    :parameters (?l - loc)
    :precondition (and (flap ?l) (robot-at ?l) (is-open ?l))
    :effect (not (is-open ?l)))

  (:action start
    :parameters (?l - loc)
    :precondition (and (dev ?l) (robot-at ?l) (not (on ?l)))
    :effect (on ?l))

  (:action stop
    :parameters (?l - loc)
    :precondition (and (dev ?l) (robot-at ?l) (on ?l))
    :effect (not (on ?l)))

  (:action capture
    :parameters (?d - doc ?r - dpi)
    :precondition (and (paper ?d) (robot-at ?d))
    :effect (scanned ?d ?r))

  (:action set-rh
    :parameters (?l - loc ?p - pct)
    :precondition (and (hygro ?l) (robot-at ?l) (not (rh-is ?l ?p)))
    :effect (and (forall (?x - pct) (not (rh-is ?l ?x))) (rh-is ?l ?p)))

  (:action stick
    :parameters (?d - doc ?c - loc)
    :precondition (and (col ?c) (robot-at ?d) (not (tagged ?d ?c)))
    :effect (and (forall (?x - loc) (not (tagged ?d ?x))) (tagged ?d ?c)))

  (:action pack
    :parameters (?d - doc)
    :precondition (robot-at ?d)
    :effect (wrapped ?d))

  (:action wipe
    :parameters (?e - ent)
    :precondition (robot-at ?e)
    :effect (dusted ?e))

  (:action phone
    :parameters (?l - loc)
    :precondition (usr ?l)
    :effect (rung ?l))

  (:action inspect
    :parameters (?d - doc)
    :precondition (and (paper ?d) (robot-at ?d))
    :effect (and))

  (:action peek
    :parameters (?l - loc)
    :precondition (and (seat ?l) (robot-at ?l))
    :effect (and)))
