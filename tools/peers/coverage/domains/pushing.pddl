; A robot on a grid pushes crates; cells hold one crate, and a crate in a corner stays there.
(define (domain pushing)
  (:requirements :strips :typing)
  (:types cell direction crate - object)
  (:predicates
    (step ?from - cell ?to - cell ?direction - direction)
    (at ?cell - cell)
    (stands ?crate - crate ?cell - cell)
    (empty ?cell - cell))
  (:action walk
    :parameters (?from - cell ?to - cell ?direction - direction)
    :precondition (and (at ?from) (empty ?to) (step ?from ?to ?direction))
    :effect (and (not (at ?from)) (at ?to)))
  (:action push
    :parameters (?crate - crate ?from - cell ?middle - cell ?to - cell ?direction - direction)
    :precondition (and (at ?from) (stands ?crate ?middle) (empty ?to)
                       (step ?from ?middle ?direction) (step ?middle ?to ?direction))
    :effect (and (not (at ?from)) (at ?middle) (not (stands ?crate ?middle)) (stands ?crate ?to)
                 (empty ?middle) (not (empty ?to)))))
