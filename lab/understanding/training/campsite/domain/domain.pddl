; A camping ground robot: it lays things in, on and behind others, hangs things up, opens tents and cool boxes, tends lanterns, cans, fires and bikes.
(define (domain campsite)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing brightness)

  (:predicates
    (roomy ?spot - spot)                    ; things go in
    (fastening ?spot - spot)                ; has a zip or a lid
    (flat ?spot - spot)                     ; things go on it
    (backed ?spot - spot)                   ; things go behind it
    (hook ?spot - spot)                     ; things hang on it
    (hearth ?spot - spot)
    (tap ?spot - spot)
    (bike ?spot - spot)
    (person ?spot - spot)
    (lantern ?item - item)
    (can ?item - item)
    (wood ?item - item)
    (robot-at ?spot - spot)
    (in ?item - item ?spot - spot)
    (on ?item - item ?spot - spot)
    (behind ?item - item ?spot - spot)
    (hangs ?item - item ?spot - spot)
    (burns ?item - item ?spot - spot)
    (holding ?item - item)
    (open ?spot - spot)
    (chained ?spot - spot)
    (asleep ?spot - spot)
    (glowing ?item - item)
    (shines ?item - item ?brightness - brightness)
    (full ?item - item))

  (:action go
    :parameters (?to - spot)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to)))

  (:action take-out
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (in ?item ?from) (imply (fastening ?from) (open ?from))
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (in ?item ?from))))

  (:action take-off
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (on ?item ?from)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (on ?item ?from))))

  (:action fetch-from-behind
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (behind ?item ?from)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (behind ?item ?from))))

  (:action unhook
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (hangs ?item ?from)
                       (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (hangs ?item ?from))))

  (:action stow
    :parameters (?item - item ?to - spot)
    :precondition (and (holding ?item) (robot-at ?to) (roomy ?to) (imply (fastening ?to) (open ?to)))
    :effect (and (in ?item ?to) (not (holding ?item))))

  (:action lay
    :parameters (?item - item ?to - spot)
    :precondition (and (holding ?item) (robot-at ?to) (or (flat ?to) (person ?to)))
    :effect (and (on ?item ?to) (not (holding ?item))))

  (:action tuck-behind
    :parameters (?item - item ?to - spot)
    :precondition (and (holding ?item) (robot-at ?to) (backed ?to))
    :effect (and (behind ?item ?to) (not (holding ?item))))

  (:action hang
    :parameters (?item - item ?to - spot)
    :precondition (and (holding ?item) (robot-at ?to) (hook ?to))
    :effect (and (hangs ?item ?to) (not (holding ?item))))

  (:action stoke
    :parameters (?hearth - spot ?wood - item)
    :precondition (and (holding ?wood) (robot-at ?hearth) (hearth ?hearth) (wood ?wood))
    :effect (and (burns ?wood ?hearth) (not (holding ?wood))))

  (:action unfasten
    :parameters (?spot - spot)
    :precondition (and (fastening ?spot) (robot-at ?spot) (not (open ?spot)))
    :effect (open ?spot))

  (:action fasten
    :parameters (?spot - spot)
    :precondition (and (fastening ?spot) (robot-at ?spot) (open ?spot))
    :effect (not (open ?spot)))

  (:action chain
    :parameters (?bike - spot)
    :precondition (and (bike ?bike) (robot-at ?bike) (not (chained ?bike)))
    :effect (chained ?bike))

  (:action unchain
    :parameters (?bike - spot)
    :precondition (and (bike ?bike) (robot-at ?bike) (chained ?bike))
    :effect (not (chained ?bike)))

  (:action rouse
    :parameters (?person - spot)
    :precondition (and (person ?person) (robot-at ?person) (asleep ?person))
    :effect (not (asleep ?person)))

  ; Lanterns are switched by radio, wherever they are.
  (:action light
    :parameters (?lantern - item)
    :precondition (and (lantern ?lantern) (not (glowing ?lantern)))
    :effect (glowing ?lantern))

  (:action darken
    :parameters (?lantern - item)
    :precondition (and (lantern ?lantern) (glowing ?lantern))
    :effect (not (glowing ?lantern)))

  (:action dim
    :parameters (?lantern - item ?brightness - brightness)
    :precondition (and (lantern ?lantern) (glowing ?lantern) (not (shines ?lantern ?brightness)))
    :effect (and (forall (?other - brightness) (not (shines ?lantern ?other))) (shines ?lantern ?brightness)))

  (:action fill
    :parameters (?can - item ?tap - spot)
    :precondition (and (can ?can) (holding ?can) (tap ?tap) (robot-at ?tap) (not (full ?can)))
    :effect (full ?can))

  (:action pour-out
    :parameters (?can - item)
    :precondition (and (can ?can) (holding ?can) (full ?can))
    :effect (not (full ?can))))
