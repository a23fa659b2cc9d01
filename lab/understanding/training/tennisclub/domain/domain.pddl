; A robot at a tennis club: it carries things, sweeps and waters courts, sets nets and flags, minds lights, machines, gates
; and lockers, calls people, and looks at courts and balls before it decides what to do.
(define (domain tennisclub)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - entity colour duration height)

  (:constants green yellow red - colour)

  (:predicates
    ; what never changes
    (person ?spot - spot)
    (court ?spot - spot)
    (lamped ?spot - spot)                ; has lights of its own
    (machine ?spot - spot)
    (hinged ?spot - spot)                ; can be opened
    (balls ?item - item)
    ; where things are and how they are
    (robot-at ?entity - entity)
    (at ?item - item ?spot - spot)
    (carried ?item - item)
    (lit ?spot - spot)
    (working ?spot - spot)
    (open ?spot - spot)
    (flag-out ?spot - spot ?colour - colour)
    (net-at ?spot - spot ?height - height)
    ; what only a look tells
    (dry ?spot - spot)
    (damp ?spot - spot)
    (waterlogged ?spot - spot)
    (bouncy ?item - item)
    (dead ?item - item)
    ; what happened
    (swept ?spot - spot)
    (sprinkled ?spot - spot ?duration - duration)
    (summoned ?spot - spot))

  (:action walk
    :parameters (?to - entity)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - entity) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (at ?item ?from) (forall (?other - item) (not (carried ?other))))
    :effect (and (carried ?item) (not (at ?item ?from))))

  (:action drop-off
    :parameters (?item - item ?to - spot)
    :precondition (and (carried ?item) (robot-at ?to))
    :effect (and (at ?item ?to) (not (carried ?item))))

  (:action lights-up
    :parameters (?spot - spot)
    :precondition (and (lamped ?spot) (not (lit ?spot)))
    :effect (lit ?spot))

  (:action lights-out
    :parameters (?spot - spot)
    :precondition (and (lamped ?spot) (lit ?spot))
    :effect (not (lit ?spot)))

  (:action set-going
    :parameters (?machine - spot)
    :precondition (and (machine ?machine) (robot-at ?machine) (not (working ?machine)))
    :effect (working ?machine))

  (:action cut-off
    :parameters (?machine - spot)
    :precondition (and (machine ?machine) (robot-at ?machine) (working ?machine))
    :effect (not (working ?machine)))

  (:action swing-open
    :parameters (?spot - spot)
    :precondition (and (hinged ?spot) (robot-at ?spot) (not (open ?spot)))
    :effect (open ?spot))

  (:action swing-shut
    :parameters (?spot - spot)
    :precondition (and (hinged ?spot) (robot-at ?spot) (open ?spot))
    :effect (not (open ?spot)))

  (:action sweep
    :parameters (?court - spot)
    :precondition (and (court ?court) (robot-at ?court))
    :effect (swept ?court))

  (:action sprinkle
    :parameters (?court - spot ?duration - duration)
    :precondition (and (court ?court) (robot-at ?court))
    :effect (sprinkled ?court ?duration))

  (:action crank-net
    :parameters (?court - spot ?height - height)
    :precondition (and (court ?court) (robot-at ?court) (not (net-at ?court ?height)))
    :effect (and (forall (?other - height) (not (net-at ?court ?other))) (net-at ?court ?height)))

  (:action hoist
    :parameters (?court - spot ?colour - colour)
    :precondition (and (court ?court) (robot-at ?court) (not (flag-out ?court ?colour)))
    :effect (and (forall (?other - colour) (not (flag-out ?court ?other))) (flag-out ?court ?colour)))

  (:action summon
    :parameters (?person - spot)
    :precondition (person ?person)
    :effect (summoned ?person))

  ; It is enough to stand beside them.
  (:action inspect-court
    :parameters (?court - spot)
    :precondition (and (court ?court) (robot-at ?court))
    :effect (and))

  (:action bounce-test
    :parameters (?item - item)
    :precondition (and (balls ?item) (robot-at ?item))
    :effect (and)))
