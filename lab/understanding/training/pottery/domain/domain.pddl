;; A robot in a pottery studio: it shifts ware, minds wheels, kilns, windows and appliances, glazes, weighs clay, wraps and
;; cleans, and feels ware and kilns before it decides what to do.
(define (domain pottery)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types fixture ware - entity mass pace)

  (:predicates
    ; what never changes
    (bearing ?fixture - fixture)           ; ware can stand there
    (human ?fixture - fixture)
    (appliance ?fixture - fixture)
    (hinged ?fixture - fixture)
    (wheel ?fixture - fixture)
    (kiln ?fixture - fixture)
    (programme ?fixture - fixture)
    (piece ?ware - ware)                   ; something made of clay
    (clay ?ware - ware)
    (glaze ?ware - ware)
    ; where things are and how they are
    (robot-by ?entity - entity)
    (stands ?ware - ware ?fixture - fixture)
    (gripped ?ware - ware)
    (powered ?fixture - fixture)
    (unclosed ?fixture - fixture)
    (turning ?wheel - fixture ?pace - pace)
    (running-on ?kiln - fixture ?programme - fixture)
    ; what only a touch tells
    (damp ?ware - ware)
    (leather-hard ?ware - ware)
    (bone-dry ?ware - ware)
    (cooled ?fixture - fixture)
    (hot ?fixture - fixture)
    ; what happened
    (coated ?ware - ware ?glaze - ware)
    (weighed-off ?clay - ware ?mass - mass)
    (swathed ?ware - ware)
    (sponged ?entity - entity)
    (news-of ?entity - entity ?human - fixture))

  (:action drive
    :parameters (?to - entity)
    :precondition (not (robot-by ?to))
    :effect (and (forall (?from - entity) (not (robot-by ?from))) (robot-by ?to)))

  (:action lift
    :parameters (?ware - ware ?from - fixture)
    :precondition (and (robot-by ?from) (stands ?ware ?from) (forall (?other - ware) (not (gripped ?other))))
    :effect (and (gripped ?ware) (not (stands ?ware ?from))))

  (:action lower
    :parameters (?ware - ware ?to - fixture)
    :precondition (and (gripped ?ware) (robot-by ?to) (or (bearing ?to) (human ?to)))
    :effect (and (stands ?ware ?to) (not (gripped ?ware))))

  (:action power-up
    :parameters (?fixture - fixture)
    :precondition (and (appliance ?fixture) (robot-by ?fixture) (not (powered ?fixture)))
    :effect (powered ?fixture))

  (:action power-down
    :parameters (?fixture - fixture)
    :precondition (and (appliance ?fixture) (robot-by ?fixture) (powered ?fixture))
    :effect (not (powered ?fixture)))

  (:action swing-open
    :parameters (?fixture - fixture)
    :precondition (and (hinged ?fixture) (robot-by ?fixture) (not (unclosed ?fixture)))
    :effect (unclosed ?fixture))

  (:action swing-shut
    :parameters (?fixture - fixture)
    :precondition (and (hinged ?fixture) (robot-by ?fixture) (unclosed ?fixture))
    :effect (not (unclosed ?fixture)))

  (:action pace-wheel
    :parameters (?wheel - fixture ?pace - pace)
    :precondition (and (wheel ?wheel) (robot-by ?wheel) (not (turning ?wheel ?pace)))
    :effect (and (forall (?other - pace) (not (turning ?wheel ?other))) (turning ?wheel ?pace)))

  (:action run-programme
    :parameters (?kiln - fixture ?programme - fixture)
    :precondition (and (kiln ?kiln) (programme ?programme) (robot-by ?kiln) (not (running-on ?kiln ?programme)))
    :effect (and (forall (?other - fixture) (not (running-on ?kiln ?other))) (running-on ?kiln ?programme)))

  (:action dip
    :parameters (?ware - ware ?glaze - ware)
    :precondition (and (piece ?ware) (glaze ?glaze) (robot-by ?ware))
    :effect (coated ?ware ?glaze))

  (:action weigh-off
    :parameters (?clay - ware ?mass - mass)
    :precondition (and (clay ?clay) (robot-by ?clay))
    :effect (weighed-off ?clay ?mass))

  (:action swathe
    :parameters (?ware - ware)
    :precondition (and (or (piece ?ware) (clay ?ware)) (robot-by ?ware))
    :effect (swathed ?ware))

  (:action sponge
    :parameters (?entity - entity)
    :precondition (robot-by ?entity)
    :effect (sponged ?entity))

  (:action pass-on
    :parameters (?entity - entity ?human - fixture)
    :precondition (and (human ?human) (robot-by ?human))
    :effect (news-of ?entity ?human))

  ; A finger is enough.
  (:action feel
    :parameters (?ware - ware)
    :precondition (and (piece ?ware) (robot-by ?ware))
    :effect (and))

  (:action read-heat
    :parameters (?fixture - fixture)
    :precondition (and (kiln ?fixture) (robot-by ?fixture))
    :effect (and)))
