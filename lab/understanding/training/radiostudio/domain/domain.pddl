;; A robot in a recording and radio studio: it carries and plugs gear, moves faders, sets volumes, lamps and clocks, runs
;; recorders, changes batteries, and tests batteries and sound before it decides.
(define (domain radiostudio)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types fixture gear - unit colour level span)

  (:constants red green amber white off - colour)

  (:predicates
    ; what never changes
    (person ?fixture - fixture)
    (door ?fixture - fixture)
    (fader ?fixture - fixture)
    (input ?fixture - fixture)
    (lamp ?fixture - fixture)
    (loud ?unit - unit)                     ; has a volume
    (recorder ?unit - unit)
    (clock ?unit - unit)
    (cable ?gear - gear)
    (audio ?unit - unit)                    ; one can hear how it sounds
    (cells ?gear - gear)                    ; runs on batteries
    ; where things are and how they are
    (robot-at ?unit - unit)
    (at ?gear - gear ?fixture - fixture)
    (carried ?gear - gear)
    (plugged ?gear - gear ?fixture - fixture)
    (open ?fixture - fixture)
    (up ?fixture - fixture)
    (recording ?unit - unit)
    (shows ?fixture - fixture ?colour - colour)
    (set-to ?unit - unit ?level - level)
    ; what only a test tells
    (crackling ?unit - unit)
    (clear ?unit - unit)
    (charged ?gear - gear)
    (weak ?gear - gear)
    (dead ?gear - gear)
    ; what happened
    (renewed ?gear - gear)
    (counting ?unit - unit ?span - span))

  (:action walk
    :parameters (?to - unit)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - unit) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?gear - gear ?from - fixture)
    :precondition (and (robot-at ?from) (at ?gear ?from) (imply (door ?from) (open ?from))
                       (forall (?other - gear) (not (carried ?other))))
    :effect (and (carried ?gear) (not (at ?gear ?from)) (not (plugged ?gear ?from))))

  (:action lay
    :parameters (?gear - gear ?onto - fixture)
    :precondition (and (carried ?gear) (robot-at ?onto) (not (person ?onto)) (imply (door ?onto) (open ?onto)))
    :effect (and (at ?gear ?onto) (not (carried ?gear))))

  (:action give
    :parameters (?gear - gear ?person - fixture)
    :precondition (and (carried ?gear) (robot-at ?person) (person ?person))
    :effect (and (at ?gear ?person) (not (carried ?gear))))

  (:action plug
    :parameters (?cable - gear ?input - fixture)
    :precondition (and (cable ?cable) (input ?input) (carried ?cable) (robot-at ?input))
    :effect (and (plugged ?cable ?input) (at ?cable ?input) (not (carried ?cable))))

  (:action open-door
    :parameters (?door - fixture)
    :precondition (and (door ?door) (robot-at ?door) (not (open ?door)))
    :effect (open ?door))

  (:action close-door
    :parameters (?door - fixture)
    :precondition (and (door ?door) (robot-at ?door) (open ?door))
    :effect (not (open ?door)))

  (:action fade-in
    :parameters (?fader - fixture)
    :precondition (and (fader ?fader) (robot-at ?fader) (not (up ?fader)))
    :effect (up ?fader))

  (:action fade-out
    :parameters (?fader - fixture)
    :precondition (and (fader ?fader) (robot-at ?fader) (up ?fader))
    :effect (not (up ?fader)))

  (:action roll
    :parameters (?recorder - unit)
    :precondition (and (recorder ?recorder) (robot-at ?recorder) (not (recording ?recorder)))
    :effect (recording ?recorder))

  (:action halt
    :parameters (?recorder - unit)
    :precondition (and (recorder ?recorder) (robot-at ?recorder) (recording ?recorder))
    :effect (not (recording ?recorder)))

  (:action show
    :parameters (?lamp - fixture ?colour - colour)
    :precondition (and (lamp ?lamp) (robot-at ?lamp) (not (shows ?lamp ?colour)))
    :effect (and (forall (?other - colour) (not (shows ?lamp ?other))) (shows ?lamp ?colour)))

  (:action adjust
    :parameters (?unit - unit ?level - level)
    :precondition (and (loud ?unit) (robot-at ?unit) (not (set-to ?unit ?level)))
    :effect (and (forall (?other - level) (not (set-to ?unit ?other))) (set-to ?unit ?level)))

  (:action start-clock
    :parameters (?clock - unit ?span - span)
    :precondition (and (clock ?clock) (robot-at ?clock))
    :effect (counting ?clock ?span))

  (:action change-cells
    :parameters (?gear - gear)
    :precondition (and (cells ?gear) (robot-at ?gear))
    :effect (renewed ?gear))

  (:action listen
    :parameters (?unit - unit)
    :precondition (and (audio ?unit) (robot-at ?unit))
    :effect (and))

  (:action test-cells
    :parameters (?gear - gear)
    :precondition (and (cells ?gear) (robot-at ?gear))
    :effect (and)))
