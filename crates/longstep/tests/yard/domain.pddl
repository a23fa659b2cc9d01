(define (domain yard)
  (:requirements :strips :typing :negative-preconditions)
  (:types thing - object
          place item - thing
          dock bay - place
          person - item)
  (:predicates (at ?item - item ?place - place)
               (with ?item - item ?person - person)
               (red ?item - item)
               (blue ?item - item)
               (fragile ?item - item)
               (capped ?item - item)
               (gone ?item - item))
  (:action bring
    :parameters (?item - item ?from - place ?to - place)
    :precondition (and (at ?item ?from) (not (gone ?item)))
    :effect (and (not (at ?item ?from)) (at ?item ?to)))
  (:action give
    :parameters (?item - item ?from - place ?person - person)
    :precondition (at ?item ?from)
    :effect (and (not (at ?item ?from)) (with ?item ?person)))
  (:action discard
    :parameters (?item - item)
    :precondition (and (capped ?item) (not (gone ?item)))
    :effect (gone ?item)))
