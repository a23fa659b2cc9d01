; Robot in a substation: carries kit, switches, locks, earths, sets taps and control modes, tops up oil, calls people.
(define (domain substation)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types loc obj - thing mode pos vol)

  (:constants local remote auto - mode)

  (:predicates
    (usr ?loc - loc)
    (eq ?loc - loc)
    (gate ?loc - loc)
    (trafo ?loc - loc)
    (panel ?loc - loc)
    (line ?loc - loc)
    (robot-at ?thing - thing)
    (at ?obj - obj ?loc - loc)
    (holding ?obj - obj)
    (energised ?loc - loc)
    (unlocked ?loc - loc)
    (earthed ?loc - loc)
    (tapped ?loc - loc ?pos - pos)
    (in-mode ?loc - loc ?mode - mode)
    ; sensed
    (leaking ?loc - loc)
    (tight ?loc - loc)
    (cool ?loc - loc)
    (warm ?loc - loc)
    (hot ?loc - loc)
    ; events
    (oiled ?loc - loc ?vol - vol)
    (called ?loc - loc)
    (logged ?thing - thing))

  (:action go
    :parameters (?to - thing)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - thing) (not (robot-at ?from))) (robot-at ?to)))

  (:action pick
    :parameters (?obj - obj ?from - loc)
    :precondition (and (robot-at ?from) (at ?obj ?from) (forall (?other - obj) (not (holding ?other))))
    :effect (and (holding ?obj) (not (at ?obj ?from))))

  (:action drop
    :parameters (?obj - obj ?to - loc)
    :precondition (and (holding ?obj) (robot-at ?to))
    :effect (and (at ?obj ?to) (not (holding ?obj))))

  (:action switch-in
    :parameters (?eq - loc)
    :precondition (and (eq ?eq) (robot-at ?eq) (not (energised ?eq)))
    :effect (energised ?eq))

  (:action switch-out
    :parameters (?eq - loc)
    :precondition (and (eq ?eq) (robot-at ?eq) (energised ?eq))
    :effect (not (energised ?eq)))

  (:action unlock
    :parameters (?gate - loc)
    :precondition (and (gate ?gate) (robot-at ?gate) (not (unlocked ?gate)))
    :effect (unlocked ?gate))

  (:action lock
    :parameters (?gate - loc)
    :precondition (and (gate ?gate) (robot-at ?gate) (unlocked ?gate))
    :effect (not (unlocked ?gate)))

  (:action ground
    :parameters (?line - loc)
    :precondition (and (line ?line) (robot-at ?line) (not (earthed ?line)))
    :effect (earthed ?line))

  (:action set-tap
    :parameters (?trafo - loc ?pos - pos)
    :precondition (and (trafo ?trafo) (robot-at ?trafo) (not (tapped ?trafo ?pos)))
    :effect (and (forall (?other - pos) (not (tapped ?trafo ?other))) (tapped ?trafo ?pos)))

  (:action set-mode
    :parameters (?panel - loc ?mode - mode)
    :precondition (and (panel ?panel) (robot-at ?panel) (not (in-mode ?panel ?mode)))
    :effect (and (forall (?other - mode) (not (in-mode ?panel ?other))) (in-mode ?panel ?mode)))

  (:action fill
    :parameters (?trafo - loc ?vol - vol)
    :precondition (and (trafo ?trafo) (robot-at ?trafo))
    :effect (oiled ?trafo ?vol))

  (:action ring
    :parameters (?usr - loc)
    :precondition (usr ?usr)
    :effect (called ?usr))

  (:action note
    :parameters (?thing - thing)
    :precondition (robot-at ?thing)
    :effect (logged ?thing))

  (:action chk-leak
    :parameters (?loc - loc)
    :precondition (and (eq ?loc) (robot-at ?loc))
    :effect (and))

  (:action chk-temp
    :parameters (?loc - loc)
    :precondition (and (eq ?loc) (robot-at ?loc))
    :effect (and)))
