; A robot in a watchmaker's and jeweller's workshop.
(define (domain watchmaker)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types loc it - obj font dur)

  (:constants block script roman - font)

  (:predicates
    (pers ?loc - loc)
    (dev ?loc - loc)
    (lock ?loc - loc)
    (bathdev ?loc - loc)
    (watch ?it - it)
    (jewel ?it - it)
    (part ?it - it)
    (robot-at ?obj - obj)
    (at ?it - it ?loc - loc)
    (held ?it - it)
    (open ?loc - loc)
    (live ?loc - loc)
    (timer ?loc - loc ?dur - dur)
    (ticking ?it - it)
    (stopped ?it - it)
    (gold ?it - it)
    (silver ?it - it)
    (plated ?it - it)
    (fitted ?it - it ?part - it)
    (engraved ?it - it ?font - font)
    (polished ?it - it)
    (wound ?it - it)
    (told ?loc - loc ?obj - obj))

  (:action go
    :parameters (?to - obj)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - obj) (not (robot-at ?from))) (robot-at ?to)))

  (:action pick
    :parameters (?it - it ?from - loc)
    :precondition (and (robot-at ?from) (at ?it ?from) (forall (?x - it) (not (held ?x))))
    :effect (and (held ?it) (not (at ?it ?from))))

  (:action drop
    :parameters (?it - it ?to - loc)
    :precondition (and (robot-at ?to) (held ?it))
    :effect (and (at ?it ?to) (not (held ?it))))

  (:action install
    :parameters (?it - it ?part - it)
    :precondition (and (held ?part) (part ?part) (watch ?it) (robot-at ?it))
    :effect (and (fitted ?it ?part) (not (held ?part))))

  (:action engrave
    :parameters (?it - it ?font - font)
    :precondition (robot-at ?it)
    :effect (engraved ?it ?font))

  (:action polish
    :parameters (?it - it)
    :precondition (robot-at ?it)
    :effect (polished ?it))

  (:action wind
    :parameters (?it - it)
    :precondition (and (watch ?it) (robot-at ?it))
    :effect (wound ?it))

  (:action unlock
    :parameters (?loc - loc)
    :precondition (and (lock ?loc) (robot-at ?loc) (not (open ?loc)))
    :effect (open ?loc))

  (:action lock-up
    :parameters (?loc - loc)
    :precondition (and (lock ?loc) (robot-at ?loc) (open ?loc))
    :effect (not (open ?loc)))

  (:action sw-on
    :parameters (?loc - loc)
    :precondition (and (dev ?loc) (robot-at ?loc) (not (live ?loc)))
    :effect (live ?loc))

  (:action sw-off
    :parameters (?loc - loc)
    :precondition (and (dev ?loc) (robot-at ?loc) (live ?loc))
    :effect (not (live ?loc)))

  (:action set-timer
    :parameters (?loc - loc ?dur - dur)
    :precondition (and (bathdev ?loc) (robot-at ?loc) (not (timer ?loc ?dur)))
    :effect (and (forall (?x - dur) (not (timer ?loc ?x))) (timer ?loc ?dur)))

  (:action say
    :parameters (?loc - loc ?obj - obj)
    :precondition (and (pers ?loc) (robot-at ?loc))
    :effect (told ?loc ?obj))

  (:action listen
    :parameters (?it - it)
    :precondition (and (watch ?it) (robot-at ?it))
    :effect (and))

  (:action assay
    :parameters (?it - it)
    :precondition (and (jewel ?it) (robot-at ?it))
    :effect (and)))
