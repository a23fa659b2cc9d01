; fish hall robot
(define (domain fishmarket)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types loc obj - thing temp mass colour)

  (:constants red blue green yellow white - colour)

  (:predicates
    (person ?loc - loc)
    (lid ?thing - thing)
    (dev ?loc - loc)
    (chiller ?loc - loc)
    (fish ?obj - obj)
    (crate ?obj - obj)
    (robot-at ?thing - thing)
    (at ?obj - obj ?thing - thing)
    (grip ?obj - obj)
    (open ?thing - thing)
    (powered ?loc - loc)
    (temp ?loc - loc ?temp - temp)
    (iced ?obj - obj ?mass - mass)
    (tag ?obj - obj ?colour - colour)
    ; sensed
    (fresh ?obj - obj)
    (tired ?obj - obj)
    (spoiled ?obj - obj)
    (leaky ?obj - obj)
    (sound ?obj - obj)
    ; events
    (gutted ?obj - obj)
    (jetted ?thing - thing)
    (buzzed ?loc - loc))

  (:action go
    :parameters (?to - thing)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - thing) (not (robot-at ?from))) (robot-at ?to)))

  (:action pick
    :parameters (?obj - obj ?from - thing)
    :precondition (and (robot-at ?from) (at ?obj ?from) (forall (?other - obj) (not (grip ?other))))
    :effect (and (grip ?obj) (not (at ?obj ?from))))

  (:action drop
    :parameters (?obj - obj ?to - thing)
    :precondition (and (grip ?obj) (robot-at ?to) (not (= ?obj ?to)))
    :effect (and (at ?obj ?to) (not (grip ?obj))))

  (:action open-it
    :parameters (?thing - thing)
    :precondition (and (lid ?thing) (robot-at ?thing) (not (open ?thing)))
    :effect (open ?thing))

  (:action close-it
    :parameters (?thing - thing)
    :precondition (and (lid ?thing) (robot-at ?thing) (open ?thing))
    :effect (not (open ?thing)))

  (:action power-on
    :parameters (?dev - loc)
    :precondition (and (dev ?dev) (robot-at ?dev) (not (powered ?dev)))
    :effect (powered ?dev))

  (:action power-off
    :parameters (?dev - loc)
    :precondition (and (dev ?dev) (robot-at ?dev) (powered ?dev))
    :effect (not (powered ?dev)))

  (:action set-temp
    :parameters (?chiller - loc ?temp - temp)
    :precondition (and (chiller ?chiller) (robot-at ?chiller) (not (temp ?chiller ?temp)))
    :effect (and (forall (?other - temp) (not (temp ?chiller ?other))) (temp ?chiller ?temp)))

  (:action add-ice
    :parameters (?crate - obj ?mass - mass)
    :precondition (and (crate ?crate) (robot-at ?crate) (not (iced ?crate ?mass)))
    :effect (and (forall (?other - mass) (not (iced ?crate ?other))) (iced ?crate ?mass)))

  (:action clip-tag
    :parameters (?obj - obj ?colour - colour)
    :precondition (and (robot-at ?obj) (not (tag ?obj ?colour)))
    :effect (and (forall (?other - colour) (not (tag ?obj ?other))) (tag ?obj ?colour)))

  (:action gut-it
    :parameters (?fish - obj)
    :precondition (and (fish ?fish) (robot-at ?fish))
    :effect (gutted ?fish))

  (:action jet-it
    :parameters (?thing - thing)
    :precondition (robot-at ?thing)
    :effect (jetted ?thing))

  (:action buzz-it
    :parameters (?person - loc)
    :precondition (person ?person)
    :effect (buzzed ?person))

  (:action sniff
    :parameters (?obj - obj)
    :precondition (and (fish ?obj) (robot-at ?obj))
    :effect (and))

  (:action drip-test
    :parameters (?obj - obj)
    :precondition (and (crate ?obj) (robot-at ?obj))
    :effect (and)))
