; A robot with two arms in front of shelves, tables, fridges, drawers and bins.
;
; The thirteen actions of the domain household, each done by one hand, and three that take both hands at once. Each
; hand is somewhere and holds one thing at most. Both may hold the same thing: that is how a thing is handed over,
; and how one that is too heavy for a hand is carried.
(define (domain household-dual)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types asset item - thing
          hand pair - manipulator)

  (:constants right left - hand
              both - pair)

  (:predicates
    ; what never changes
    (can-open ?thing - thing)                  ; it has a handle
    (handle-of ?handle - item ?thing - thing)
    (fixed ?thing - thing)                     ; part of something, cannot be carried
    (heavy ?item - item)                       ; too heavy, or too large, for one hand
    (container ?thing - thing)                 ; what is put down in it is inside it
    (bin ?thing - thing)                       ; things may be dropped into it
    (base ?thing - thing)                      ; something may stand on it or lie in it
    (upright ?thing - thing)                   ; a plane on which nothing stays by itself
    (rotates ?handle - thing)
    (slides ?handle - thing)
    (next-to ?thing - thing ?other - thing)
    (can-reach ?hand - hand ?place - thing)    ; a place of which this is said of no hand is reached by both
    ; where things are
    (on ?thing - thing ?place - thing)
    (inside ?thing - thing ?place - thing)
    (open ?thing - thing)
    (closed ?thing - thing)
    ; the hands
    (hand-at ?hand - hand ?thing - thing)
    (holding ?item - item ?hand - hand)
    (lifted ?item - item)                      ; held, and constrained by nothing
    ; what happened
    (put-by ?item - item ?place - thing ?by - manipulator)
    (worked-by ?handle - item ?hand - hand)
    (wiped ?place - thing ?tool - item ?hand - hand)
    (adjusted ?handle - item))

  ; Of equally short plans, search prefers the action that comes first here: what is carried is moved.
  (:action move-object
    :parameters (?hand - hand ?item - item ?to - thing)
    :precondition (and (holding ?item ?hand)
                       (lifted ?item)
                       (forall (?other - hand) (or (= ?other ?hand) (not (holding ?item ?other))))
                       (or (forall (?other - hand) (not (can-reach ?other ?to))) (can-reach ?hand ?to))
                       (forall (?place - thing)
                         (imply (or (on ?to ?place) (inside ?to ?place) (handle-of ?to ?place))
                                (or (forall (?other - hand) (not (can-reach ?other ?place)))
                                    (can-reach ?hand ?place)))))
    ; the other hand, had it been at the thing, is not any more
    :effect (and (forall (?other - thing) (not (hand-at ?hand ?other)))
                 (forall (?other - hand) (not (hand-at ?other ?item)))
                 (hand-at ?hand ?to)))

  (:action move-hand
    :parameters (?hand - hand ?to - thing)
    ; a hand that holds on to something constrained, or to what the other hand holds too, cannot go elsewhere; and
    ; what rides on something lifted has no place of its own
    :precondition (and (forall (?held - item)
                         (or (and (lifted ?held)
                                  (forall (?other - hand) (or (= ?other ?hand) (not (holding ?held ?other)))))
                             (not (holding ?held ?hand))))
                       (forall (?support - item)
                         (imply (or (on ?to ?support) (inside ?to ?support) (handle-of ?to ?support))
                                (not (lifted ?support))))
                       (or (forall (?other - hand) (not (can-reach ?other ?to))) (can-reach ?hand ?to))
                       (forall (?place - thing)
                         (imply (or (on ?to ?place) (inside ?to ?place) (handle-of ?to ?place))
                                (or (forall (?other - hand) (not (can-reach ?other ?place)))
                                    (can-reach ?hand ?place)))))
    :effect (and (forall (?other - thing) (not (hand-at ?hand ?other)))
                 (forall (?other - hand ?held - item) (when (holding ?held ?hand) (not (hand-at ?other ?held))))
                 (hand-at ?hand ?to)))

  (:action grasp
    :parameters (?hand - hand ?item - item)
    :precondition (and (hand-at ?hand ?item)
                       (forall (?other - item) (not (holding ?other ?hand)))
                       (forall (?around - thing ?handle - item)
                         (imply (and (inside ?item ?around) (handle-of ?handle ?around))
                                (not (closed ?handle)))))
    :effect (holding ?item ?hand))

  (:action release
    :parameters (?hand - hand ?item - item)
    ; not in mid-air, unless over a bin or into the other hand, and not against a wall
    :precondition (and (holding ?item ?hand)
                       (or (not (lifted ?item))
                           (and (not (heavy ?item))
                                (exists (?other - hand) (and (not (= ?other ?hand)) (holding ?item ?other))))
                           (and (forall (?other - hand) (or (= ?other ?hand) (not (holding ?item ?other))))
                                (exists (?below - thing) (and (bin ?below) (hand-at ?hand ?below)))))
                       (forall (?plane - thing) (imply (upright ?plane) (not (on ?item ?plane)))))
    :effect (and (not (holding ?item ?hand))
                 (forall (?below - thing)
                   (when (and (lifted ?item) (bin ?below) (hand-at ?hand ?below)
                              (forall (?other - hand) (or (= ?other ?hand) (not (holding ?item ?other)))))
                         (and (inside ?item ?below) (put-by ?item ?below ?hand))))
                 (when (forall (?other - hand) (or (= ?other ?hand) (not (holding ?item ?other))))
                       (not (lifted ?item)))))

  (:action detach
    :parameters (?hand - hand ?item - item ?from - thing)
    :precondition (and (holding ?item ?hand)
                       (forall (?other - hand) (or (= ?other ?hand) (not (holding ?item ?other))))
                       (not (lifted ?item))
                       (not (fixed ?item))
                       (not (heavy ?item))
                       (forall (?rider - item ?other - hand)
                         (or (not (base ?item))
                             (not (holding ?rider ?other))
                             (not (or (on ?rider ?item) (inside ?rider ?item) (handle-of ?rider ?item)))))
                       (or (on ?item ?from) (inside ?item ?from)))
    :effect (and (forall (?place - thing) (and (not (on ?item ?place)) (not (inside ?item ?place))))
                 (forall (?other - hand ?rider - item)
                   (when (and (base ?item) (or (on ?rider ?item) (inside ?rider ?item) (handle-of ?rider ?item)))
                         (not (hand-at ?other ?rider))))
                 (lifted ?item)))

  (:action attach
    :parameters (?hand - hand ?item - item ?to - thing)
    :precondition (and (holding ?item ?hand)
                       (forall (?other - hand) (or (= ?other ?hand) (not (holding ?item ?other))))
                       (lifted ?item)
                       (hand-at ?hand ?to)
                       (not (= ?item ?to))
                       (not (fixed ?to))
                       (or (exists (?asset - asset) (= ?asset ?to)) (base ?to))
                       (forall (?handle - item) (imply (handle-of ?handle ?to) (not (closed ?handle)))))
    :effect (and (not (lifted ?item))
                 (put-by ?item ?to ?hand)
                 (when (container ?to) (inside ?item ?to))
                 (when (not (container ?to)) (on ?item ?to))))

  (:action open-by-rotate
    :parameters (?hand - hand ?handle - item)
    :precondition (and (holding ?handle ?hand) (closed ?handle) (rotates ?handle))
    :effect (and (open ?handle) (not (closed ?handle)) (worked-by ?handle ?hand)))

  (:action adjust-by-rotate
    :parameters (?hand - hand ?handle - item)
    :precondition (and (holding ?handle ?hand) (not (closed ?handle)) (rotates ?handle))
    :effect (and (adjusted ?handle) (worked-by ?handle ?hand)))

  (:action close-by-rotate
    :parameters (?hand - hand ?handle - item)
    ; not onto the other hand, which has hold of something inside
    :precondition (and (holding ?handle ?hand)
                       (open ?handle)
                       (rotates ?handle)
                       (forall (?thing - thing ?item - item ?other - hand)
                         (imply (and (handle-of ?handle ?thing) (inside ?item ?thing)) (not (holding ?item ?other)))))
    :effect (and (closed ?handle) (not (open ?handle)) (worked-by ?handle ?hand)))

  (:action open-by-slide
    :parameters (?hand - hand ?handle - item)
    :precondition (and (holding ?handle ?hand) (closed ?handle) (slides ?handle))
    :effect (and (open ?handle) (not (closed ?handle)) (worked-by ?handle ?hand)))

  (:action adjust-by-slide
    :parameters (?hand - hand ?handle - item)
    :precondition (and (holding ?handle ?hand) (not (closed ?handle)) (slides ?handle))
    :effect (and (adjusted ?handle) (worked-by ?handle ?hand)))

  (:action close-by-slide
    :parameters (?hand - hand ?handle - item)
    :precondition (and (holding ?handle ?hand)
                       (open ?handle)
                       (slides ?handle)
                       (forall (?thing - thing ?item - item ?other - hand)
                         (imply (and (handle-of ?handle ?thing) (inside ?item ?thing)) (not (holding ?item ?other)))))
    :effect (and (closed ?handle) (not (open ?handle)) (worked-by ?handle ?hand)))

  (:action wipe
    :parameters (?hand - hand ?tool - item ?place - thing)
    :precondition (and (holding ?tool ?hand) (not (lifted ?tool)) (not (fixed ?tool)) (on ?tool ?place))
    :effect (wiped ?place ?tool ?hand))

  (:action lift-with-both
    :parameters (?item - item ?from - thing)
    :precondition (and (forall (?hand - hand) (holding ?item ?hand))
                       (not (lifted ?item))
                       (not (fixed ?item))
                       (or (on ?item ?from) (inside ?item ?from)))
    :effect (and (forall (?place - thing) (and (not (on ?item ?place)) (not (inside ?item ?place))))
                 (lifted ?item)))

  (:action carry-with-both
    :parameters (?item - item ?to - thing)
    :precondition (and (forall (?hand - hand) (holding ?item ?hand))
                       (lifted ?item)
                       (forall (?hand - hand)
                         (or (forall (?other - hand) (not (can-reach ?other ?to))) (can-reach ?hand ?to)))
                       (forall (?place - thing ?hand - hand)
                         (imply (or (on ?to ?place) (inside ?to ?place))
                                (or (forall (?other - hand) (not (can-reach ?other ?place)))
                                    (can-reach ?hand ?place)))))
    :effect (and (forall (?hand - hand ?other - thing) (not (hand-at ?hand ?other)))
                 (forall (?hand - hand) (hand-at ?hand ?to))))

  (:action put-down-with-both
    :parameters (?item - item ?to - thing)
    :precondition (and (forall (?hand - hand) (and (holding ?item ?hand) (hand-at ?hand ?to)))
                       (lifted ?item)
                       (not (= ?item ?to))
                       (not (fixed ?to))
                       (or (exists (?asset - asset) (= ?asset ?to)) (base ?to))
                       (forall (?handle - item) (imply (handle-of ?handle ?to) (not (closed ?handle)))))
    :effect (and (not (lifted ?item))
                 (put-by ?item ?to both)
                 (when (container ?to) (inside ?item ?to))
                 (when (not (container ?to)) (on ?item ?to)))))
