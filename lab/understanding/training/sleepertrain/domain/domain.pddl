; A robot on a night train: it serves passengers and crew in the corridor and the compartments.
(define (domain sleepertrain)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot item - thing shape warmth span)

  (:constants bed bench folded - shape)

  (:predicates
    (person ?spot - spot)
    (sleeper ?spot - spot)
    (room ?spot - spot)
    (appliance ?spot - spot)
    (hinged ?spot - spot)
    (heatable ?spot - spot)
    (berth ?spot - spot)
    (ticket ?item - item)
    (robot-at ?thing - thing)
    (lies ?item - item ?spot - spot)
    (holding ?item - item)
    (works ?spot - spot)
    (open ?spot - spot)
    (warm ?spot - spot ?warmth - warmth)
    (shape ?spot - spot ?shape - shape)
    (alarm ?spot - spot ?span - span)
    (vacant ?spot - spot)
    (occupied ?spot - spot)
    (asleep ?spot - spot)
    (wide-awake ?spot - spot)
    (gone ?spot - spot)
    (freshened ?thing - thing)
    (punched ?ticket - item)
    (told ?person - spot ?thing - thing))

  (:action walk
    :parameters (?to - thing)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - thing) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?item - item ?from - spot)
    :precondition (and (robot-at ?from) (lies ?item ?from) (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (lies ?item ?from))))

  (:action leave
    :parameters (?item - item ?to - spot)
    :precondition (and (robot-at ?to) (holding ?item) (not (person ?to)))
    :effect (and (lies ?item ?to) (not (holding ?item))))

  (:action present
    :parameters (?item - item ?person - spot)
    :precondition (and (robot-at ?person) (holding ?item) (person ?person))
    :effect (and (lies ?item ?person) (not (holding ?item))))

  (:action power-up
    :parameters (?appliance - spot)
    :precondition (and (appliance ?appliance) (robot-at ?appliance) (not (works ?appliance)))
    :effect (works ?appliance))

  (:action power-down
    :parameters (?appliance - spot)
    :precondition (and (appliance ?appliance) (robot-at ?appliance) (works ?appliance))
    :effect (not (works ?appliance)))

  (:action fling-open
    :parameters (?hinged - spot)
    :precondition (and (hinged ?hinged) (robot-at ?hinged) (not (open ?hinged)))
    :effect (open ?hinged))

  (:action pull-to
    :parameters (?hinged - spot)
    :precondition (and (hinged ?hinged) (robot-at ?hinged) (open ?hinged))
    :effect (not (open ?hinged)))

  (:action turn-dial
    :parameters (?place - spot ?warmth - warmth)
    :precondition (and (heatable ?place) (robot-at ?place) (not (warm ?place ?warmth)))
    :effect (and (forall (?o - warmth) (not (warm ?place ?o))) (warm ?place ?warmth)))

  (:action convert
    :parameters (?berth - spot ?shape - shape)
    :precondition (and (berth ?berth) (robot-at ?berth) (not (shape ?berth ?shape)))
    :effect (and (forall (?o - shape) (not (shape ?berth ?o))) (shape ?berth ?shape)))

  (:action set-alarm
    :parameters (?sleeper - spot ?span - span)
    :precondition (and (sleeper ?sleeper) (not (alarm ?sleeper ?span)))
    :effect (and (forall (?o - span) (not (alarm ?sleeper ?o))) (alarm ?sleeper ?span)))

  (:action freshen
    :parameters (?thing - thing)
    :precondition (robot-at ?thing)
    :effect (freshened ?thing))

  (:action punch
    :parameters (?ticket - item)
    :precondition (and (ticket ?ticket) (robot-at ?ticket))
    :effect (punched ?ticket))

  (:action tell
    :parameters (?person - spot ?thing - thing)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (told ?person ?thing))

  (:action peek
    :parameters (?spot - spot)
    :precondition (and (room ?spot) (robot-at ?spot))
    :effect (and))

  (:action look-in-on
    :parameters (?spot - spot)
    :precondition (and (sleeper ?spot) (robot-at ?spot))
    :effect (and)))
