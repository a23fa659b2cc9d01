; A party robot: it brings ware to places and guests, colours lights, minds appliances and loudspeakers, unfolds and folds
; furniture, lays tables, pours drinks, wipes, fetches people, and looks how full and how dry things are.
(define (domain partyservice)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot ware - thing colour drink people loudness)

  (:constants red blue green gold violet - colour
              water punch lemonade beer red_wine - drink)

  (:predicates
    ; what never changes
    (someone ?spot - spot)                  ; a person
    (coloured-light ?spot - spot)
    (appliance ?spot - spot)
    (speaker ?spot - spot)
    (foldable ?thing - thing)
    (table ?spot - spot)
    (vessel ?ware - ware)                   ; drinks can be poured into it
    (dish ?ware - ware)                     ; it runs low: a platter, a bowl, a jug
    (fabric ?thing - thing)                 ; it gets damp
    ; how things are
    (robot-at ?thing - thing)
    (at ?ware - ware ?spot - spot)
    (holding ?ware - ware)
    (glowing ?spot - spot ?colour - colour)
    (on ?spot - spot)
    (loud ?spot - spot ?loudness - loudness)
    (spread ?thing - thing)
    (laid ?spot - spot ?people - people)
    ; what only a look or a touch tells
    (empty ?ware - ware)
    (half-full ?ware - ware)
    (full ?ware - ware)
    (damp ?thing - thing)
    (dry ?thing - thing)
    ; what happened
    (poured ?ware - ware ?drink - drink)
    (wiped ?thing - thing)
    (fetched ?spot - spot))

  (:action wander
    :parameters (?to - thing)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - thing) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?ware - ware ?from - spot)
    :precondition (and (robot-at ?from) (at ?ware ?from) (forall (?other - ware) (not (holding ?other))))
    :effect (and (holding ?ware) (not (at ?ware ?from))))

  (:action set-down
    :parameters (?ware - ware ?to - spot)
    :precondition (and (holding ?ware) (robot-at ?to))
    :effect (and (at ?ware ?to) (not (holding ?ware))))

  (:action tint
    :parameters (?light - spot ?colour - colour)
    :precondition (and (coloured-light ?light) (robot-at ?light) (not (glowing ?light ?colour)))
    :effect (and (forall (?other - colour) (not (glowing ?light ?other))) (glowing ?light ?colour)))

  (:action plug-in
    :parameters (?appliance - spot)
    :precondition (and (appliance ?appliance) (robot-at ?appliance) (not (on ?appliance)))
    :effect (on ?appliance))

  (:action pull-plug
    :parameters (?appliance - spot)
    :precondition (and (appliance ?appliance) (robot-at ?appliance) (on ?appliance))
    :effect (not (on ?appliance)))

  (:action turn-knob
    :parameters (?speaker - spot ?loudness - loudness)
    :precondition (and (speaker ?speaker) (robot-at ?speaker) (not (loud ?speaker ?loudness)))
    :effect (and (forall (?other - loudness) (not (loud ?speaker ?other))) (loud ?speaker ?loudness)))

  (:action unfold
    :parameters (?thing - thing)
    :precondition (and (foldable ?thing) (robot-at ?thing) (not (spread ?thing)))
    :effect (spread ?thing))

  (:action fold
    :parameters (?thing - thing)
    :precondition (and (foldable ?thing) (robot-at ?thing) (spread ?thing))
    :effect (not (spread ?thing)))

  (:action lay
    :parameters (?table - spot ?people - people)
    :precondition (and (table ?table) (robot-at ?table) (not (laid ?table ?people)))
    :effect (and (forall (?other - people) (not (laid ?table ?other))) (laid ?table ?people)))

  (:action pour
    :parameters (?vessel - ware ?drink - drink)
    :precondition (and (vessel ?vessel) (robot-at ?vessel))
    :effect (poured ?vessel ?drink))

  (:action wipe
    :parameters (?thing - thing)
    :precondition (robot-at ?thing)
    :effect (wiped ?thing))

  (:action fetch
    :parameters (?person - spot)
    :precondition (someone ?person)
    :effect (fetched ?person))

  (:action peek
    :parameters (?dish - ware)
    :precondition (and (dish ?dish) (robot-at ?dish))
    :effect (and))

  (:action touch
    :parameters (?fabric - thing)
    :precondition (and (fabric ?fabric) (robot-at ?fabric))
    :effect (and)))
