; The robot of a music school: it fetches instruments, tunes and wires them, sets metronomes, amplifiers and stage light,
; charges batteries, sets out chairs, and listens or measures before it decides.
(define (domain bandroom)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types fixture gear - thing bpm percent chairs)

  (:predicates
    ; fixed
    (somebody ?fixture - fixture)
    (carries ?fixture - fixture)            ; things can be left there
    (room ?fixture - fixture)
    (amp ?fixture - fixture)
    (device ?fixture - fixture)
    (tintable ?fixture - fixture)
    (closable ?thing - thing)
    (instrument ?thing - thing)
    (pluggable ?gear - gear)
    (rechargeable ?gear - gear)
    (metronome ?gear - gear)
    (colour ?gear - gear)
    ; changing
    (near ?thing - thing)
    (at ?gear - gear ?fixture - fixture)
    (gripped ?gear - gear)
    (powered ?fixture - fixture)
    (ajar ?thing - thing)
    (wired ?gear - gear ?amp - fixture)
    (ticks ?gear - gear ?bpm - bpm)
    (volume ?amp - fixture ?percent - percent)
    (tinted ?light - fixture ?colour - gear)
    (furnished ?room - fixture ?chairs - chairs)
    ; heard or measured
    (in-tune ?thing - thing)
    (off-key ?thing - thing)
    (battery-good ?gear - gear)
    (battery-low ?gear - gear)
    (battery-dead ?gear - gear)
    ; events
    (tuned ?thing - thing)
    (charged ?gear - gear)
    (alerted ?person - fixture))

  (:action walk
    :parameters (?to - thing)
    :precondition (not (near ?to))
    :effect (and (forall (?from - thing) (not (near ?from))) (near ?to)))

  (:action grip
    :parameters (?gear - gear ?from - fixture)
    :precondition (and (near ?from) (at ?gear ?from)
                       (forall (?other - gear) (not (gripped ?other))))
    :effect (and (gripped ?gear) (not (at ?gear ?from))))

  (:action leave
    :parameters (?gear - gear ?to - fixture)
    :precondition (and (gripped ?gear) (near ?to) (or (carries ?to) (somebody ?to)))
    :effect (and (at ?gear ?to) (not (gripped ?gear))))

  (:action tune
    :parameters (?thing - thing)
    :precondition (and (instrument ?thing) (near ?thing))
    :effect (tuned ?thing))

  (:action wire
    :parameters (?gear - gear ?amp - fixture)
    :precondition (and (pluggable ?gear) (amp ?amp) (near ?amp) (not (wired ?gear ?amp)))
    :effect (and (forall (?other - fixture) (not (wired ?gear ?other))) (wired ?gear ?amp)))

  (:action power-on
    :parameters (?device - fixture)
    :precondition (and (device ?device) (near ?device) (not (powered ?device)))
    :effect (powered ?device))

  (:action power-off
    :parameters (?device - fixture)
    :precondition (and (device ?device) (near ?device) (powered ?device))
    :effect (not (powered ?device)))

  (:action uncover
    :parameters (?thing - thing)
    :precondition (and (closable ?thing) (near ?thing) (not (ajar ?thing)))
    :effect (ajar ?thing))

  (:action cover
    :parameters (?thing - thing)
    :precondition (and (closable ?thing) (near ?thing) (ajar ?thing))
    :effect (not (ajar ?thing)))

  (:action set-tempo
    :parameters (?metronome - gear ?bpm - bpm)
    :precondition (and (metronome ?metronome) (near ?metronome) (not (ticks ?metronome ?bpm)))
    :effect (and (forall (?other - bpm) (not (ticks ?metronome ?other))) (ticks ?metronome ?bpm)))

  (:action set-volume
    :parameters (?amp - fixture ?percent - percent)
    :precondition (and (amp ?amp) (near ?amp) (not (volume ?amp ?percent)))
    :effect (and (forall (?other - percent) (not (volume ?amp ?other))) (volume ?amp ?percent)))

  (:action tint
    :parameters (?light - fixture ?colour - gear)
    :precondition (and (tintable ?light) (colour ?colour) (near ?light) (not (tinted ?light ?colour)))
    :effect (and (forall (?other - gear) (not (tinted ?light ?other))) (tinted ?light ?colour)))

  (:action set-out
    :parameters (?room - fixture ?chairs - chairs)
    :precondition (and (room ?room) (near ?room) (not (furnished ?room ?chairs)))
    :effect (and (forall (?other - chairs) (not (furnished ?room ?other))) (furnished ?room ?chairs)))

  (:action charge
    :parameters (?gear - gear)
    :precondition (and (rechargeable ?gear) (near ?gear))
    :effect (charged ?gear))

  (:action alert
    :parameters (?person - fixture)
    :precondition (and (somebody ?person) (near ?person))
    :effect (alerted ?person))

  (:action listen-to
    :parameters (?thing - thing)
    :precondition (and (instrument ?thing) (near ?thing))
    :effect (and))

  (:action read-battery
    :parameters (?gear - gear)
    :precondition (and (rechargeable ?gear) (near ?gear))
    :effect (and)))
