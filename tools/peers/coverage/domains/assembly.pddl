; Parts join into assemblies in a fixture; a joint needs its tool and what lies below it, and may need a part to be off.
(define (domain assembly)
  (:requirements :strips :typing :negative-preconditions :quantified-preconditions :disjunctive-preconditions)
  (:types part tool station - object)
  (:predicates
    (needs ?part - part ?below - part)          ; fitted after ?below
    (joined-with ?part - part ?tool - tool)
    (blocks ?part - part ?other - part)         ; ?other is neither fitted nor removed while ?part is on
    (at ?station - station)
    (part-at ?part - part ?station - station)
    (tool-at ?tool - tool ?station - station)
    (fixture ?station - station)
    (holds-part ?part - part)
    (holds-tool ?tool - tool)
    (hand-free)
    (placed ?part - part)
    (fitted ?part - part))
  (:action go
    :parameters (?from - station ?to - station)
    :precondition (at ?from)
    :effect (and (not (at ?from)) (at ?to)))
  (:action take-part
    :parameters (?part - part ?station - station)
    :precondition (and (at ?station) (part-at ?part ?station) (hand-free) (not (placed ?part)))
    :effect (and (holds-part ?part) (not (part-at ?part ?station)) (not (hand-free))))
  (:action put-part
    :parameters (?part - part ?station - station)
    :precondition (and (at ?station) (holds-part ?part))
    :effect (and (part-at ?part ?station) (hand-free) (not (holds-part ?part))))
  (:action take-tool
    :parameters (?tool - tool ?station - station)
    :precondition (and (at ?station) (tool-at ?tool ?station) (hand-free))
    :effect (and (holds-tool ?tool) (not (tool-at ?tool ?station)) (not (hand-free))))
  (:action put-tool
    :parameters (?tool - tool ?station - station)
    :precondition (and (at ?station) (holds-tool ?tool))
    :effect (and (tool-at ?tool ?station) (hand-free) (not (holds-tool ?tool))))
  (:action insert
    :parameters (?part - part ?station - station)
    :precondition (and (at ?station) (fixture ?station) (holds-part ?part)
                       (forall (?below - part) (imply (needs ?part ?below) (fitted ?below)))
                       (forall (?other - part) (imply (blocks ?other ?part) (not (placed ?other)))))
    :effect (and (placed ?part) (part-at ?part ?station) (hand-free) (not (holds-part ?part))))
  (:action fasten
    :parameters (?part - part ?tool - tool ?station - station)
    :precondition (and (at ?station) (fixture ?station) (placed ?part) (part-at ?part ?station) (not (fitted ?part))
                       (holds-tool ?tool) (joined-with ?part ?tool))
    :effect (fitted ?part))
  (:action loosen
    :parameters (?part - part ?tool - tool ?station - station)
    :precondition (and (at ?station) (fixture ?station) (fitted ?part) (part-at ?part ?station)
                       (holds-tool ?tool) (joined-with ?part ?tool)
                       (forall (?above - part) (imply (needs ?above ?part) (not (placed ?above))))
                       (forall (?other - part) (imply (blocks ?other ?part) (not (placed ?other)))))
    :effect (not (fitted ?part)))
  (:action remove
    :parameters (?part - part ?station - station)
    :precondition (and (at ?station) (fixture ?station) (placed ?part) (part-at ?part ?station)
                       (not (fitted ?part)) (hand-free))
    :effect (and (holds-part ?part) (not (placed ?part)) (not (part-at ?part ?station)) (not (hand-free)))))
