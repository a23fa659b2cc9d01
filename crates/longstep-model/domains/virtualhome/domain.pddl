; VirtualHome with the nine actions of Wake et al. (2023), for somebody who carries one thing at a time.
(define (domain virtualhome)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types asset item - thing)

  (:predicates
    ; what never changes
    (can-open ?thing - thing)
    (has-switch ?thing - thing)
    (room ?thing - thing)
    (base ?thing - thing)                      ; something may stand on it
    (heats ?thing - thing)
    (hot-on-top ?thing - thing)                ; what lies on it gets hot too
    (cookware ?item - item)                    ; made to stand on such a thing
    (drinkable ?thing - thing)
    (basin ?thing - thing)                     ; water runs into it
    (tap ?thing - thing)                       ; water runs out of it
    (part-of ?thing - thing ?other - thing)
    ; where things are and how they are
    (on ?thing - thing ?place - thing)
    (inside ?thing - thing ?place - thing)
    (open ?thing - thing)
    (closed ?thing - thing)
    (switched-on ?thing - thing)
    (holding ?item - item)
    (near ?thing - thing)                      ; within reach
    ; what happened
    (picked-up ?item - item)
    (placed ?item - item ?place - thing)
    (filled ?thing - thing ?item - item)
    (drunk ?item - item))

  ; Whoever walks to a thing reaches it, what is on it or in it, what it stands on if that does not move,
  ; and what belongs to it; and keeps what is in hand.
  (:action walk-towards
    :parameters (?to - thing)
    :precondition (and)
    :effect (and (forall (?thing - thing) (not (near ?thing)))
                 (near ?to)
                 (forall (?thing - thing)
                   (when (and (not (room ?to))
                              (or (on ?thing ?to) (inside ?thing ?to)
                                  (part-of ?thing ?to) (part-of ?to ?thing)))
                         (near ?thing)))
                 (forall (?asset - asset ?under - asset)
                   (when (and (= ?asset ?to) (on ?asset ?under)) (near ?under)))
                 (forall (?item - item) (when (holding ?item) (near ?item)))))

  (:action grab
    :parameters (?item - item)
    :precondition (and (near ?item)
                       (forall (?other - item) (not (holding ?other)))
                       (forall (?around - thing)
                         (imply (inside ?item ?around) (not (closed ?around)))))
    :effect (and (holding ?item)
                 (picked-up ?item)
                 (forall (?place - thing)
                   (when (not (room ?place)) (and (not (on ?item ?place)) (not (inside ?item ?place)))))))

  (:action open
    :parameters (?thing - thing)
    :precondition (and (near ?thing) (can-open ?thing) (not (open ?thing))
                       (imply (heats ?thing) (not (switched-on ?thing))))
    :effect (and (open ?thing) (not (closed ?thing))))

  (:action close
    :parameters (?thing - thing)
    :precondition (and (near ?thing) (can-open ?thing) (not (closed ?thing)))
    :effect (and (closed ?thing) (not (open ?thing))))

  (:action put
    :parameters (?item - item ?place - thing)
    :precondition (and (holding ?item) (near ?place) (not (= ?item ?place))
                       (imply (and (hot-on-top ?place) (switched-on ?place)) (cookware ?item)))
    :effect (and (not (holding ?item)) (on ?item ?place) (placed ?item ?place)))

  (:action put-in
    :parameters (?item - item ?container - thing)
    :precondition (and (holding ?item) (near ?container) (not (= ?item ?container))
                       (can-open ?container) (not (closed ?container)))
    :effect (and (not (holding ?item)) (inside ?item ?container) (placed ?item ?container)
                 (filled ?container ?item)))

  (:action switch-on
    :parameters (?thing - thing)
    ; nothing but cookware may lie on a stove that gets hot
    :precondition (and (near ?thing) (has-switch ?thing) (not (switched-on ?thing))
                       (imply (heats ?thing) (not (open ?thing)))
                       (forall (?item - item)
                         (imply (and (hot-on-top ?thing) (on ?item ?thing)) (cookware ?item))))
    :effect (switched-on ?thing))

  (:action switch-off
    :parameters (?thing - thing)
    :precondition (and (near ?thing) (has-switch ?thing) (switched-on ?thing))
    :effect (not (switched-on ?thing)))

  (:action drink
    :parameters (?item - item)
    :precondition (and (near ?item) (picked-up ?item) (drinkable ?item))
    :effect (drunk ?item)))
