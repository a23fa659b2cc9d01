; A stage robot: it carries props, dresses actors, prompts them, works curtains, trapdoors and spotlights.
(define (domain theatre)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing line)

  (:predicates
    (actor ?spot - spot)                    ; a person
    (light ?spot - spot)
    (opening ?spot - spot)                  ; a curtain, a trapdoor, a door
    (costume ?item - item)
    (tool ?item - item)
    (robot-at ?spot - spot)
    (at ?item - item ?spot - spot)
    (holding ?item - item)
    (worn ?item - item ?actor - spot)
    (on ?light - spot)
    (open ?spot - spot)
    (points-at ?light - spot ?target - spot)
    ; what happened
    (touched-up ?item - item ?tool - item)
    (prompted ?actor - spot ?line - line))

  (:action go
    :parameters (?to - spot)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to)))

  ; Also takes off a costume that somebody wears.
  (:action pick
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (at ?item ?from) (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from)) (not (worn ?item ?from))))

  (:action leave
    :parameters (?item - item ?to - spot)
    :precondition (and (holding ?item) (robot-at ?to) (not (light ?to)))
    :effect (and (at ?item ?to) (not (holding ?item))))

  (:action dress
    :parameters (?item - item ?actor - spot)
    :precondition (and (holding ?item) (costume ?item) (actor ?actor) (robot-at ?actor))
    :effect (and (at ?item ?actor) (worn ?item ?actor) (not (holding ?item))))

  (:action work
    :parameters (?item - item ?tool - item ?spot - spot)
    :precondition (and (holding ?tool) (tool ?tool) (robot-at ?spot) (at ?item ?spot))
    :effect (touched-up ?item ?tool))

  (:action whisper
    :parameters (?actor - spot ?line - line)
    :precondition (and (actor ?actor) (robot-at ?actor))
    :effect (prompted ?actor ?line))

  ; Lights, curtains and trapdoors are worked from anywhere.
  (:action light-on
    :parameters (?light - spot)
    :precondition (and (light ?light) (not (on ?light)))
    :effect (on ?light))

  (:action light-off
    :parameters (?light - spot)
    :precondition (and (light ?light) (on ?light))
    :effect (not (on ?light)))

  (:action aim
    :parameters (?light - spot ?target - spot)
    :precondition (and (light ?light) (on ?light) (not (light ?target)) (not (points-at ?light ?target)))
    :effect (and (forall (?other - spot) (not (points-at ?light ?other))) (points-at ?light ?target)))

  (:action open
    :parameters (?spot - spot)
    :precondition (and (opening ?spot) (not (open ?spot)))
    :effect (open ?spot))

  (:action close
    :parameters (?spot - spot)
    :precondition (and (opening ?spot) (open ?spot))
    :effect (not (open ?spot))))
