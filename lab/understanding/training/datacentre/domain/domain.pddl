; A robot in a computer centre: it carries kit, plugs cables, starts and halts servers, minds locks, coolers and power
; strips, files tickets and tells people, and looks at server lights and coolers before it decides what to do.
(define (domain datacentre)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types location kit - entity temperature current)

  (:predicates
    ; what never changes
    (space ?entity - entity)
    (person ?location - location)
    (socket ?location - location)
    (cooler ?location - location)
    (strip ?location - location)
    (lockable ?location - location)
    (mode ?location - location)
    (server ?kit - kit)
    (cable ?kit - kit)
    ; where things are and how they are
    (robot-at ?entity - entity)
    (at ?kit - kit ?where - entity)
    (holding ?kit - kit)
    (plugged ?cable - kit ?socket - location)
    (up ?kit - kit)
    (locked ?location - location)
    (set-to ?location - location ?temperature - temperature)
    (blows ?location - location ?mode - location)
    (limited ?location - location ?current - current)
    ; what only a look tells
    (healthy ?kit - kit)
    (degraded ?kit - kit)
    (failed ?kit - kit)
    (leaking ?location - location)
    (tight ?location - location)
    ; what happened
    (filed ?entity - entity)
    (told ?person - location ?entity - entity))

  (:action drive
    :parameters (?to - entity)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - entity) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?kit - kit ?from - entity)
    :precondition (and (robot-at ?from) (at ?kit ?from)
                       (forall (?other - kit) (not (holding ?other))))
    :effect (and (holding ?kit) (not (at ?kit ?from))))

  (:action set-down
    :parameters (?kit - kit ?to - entity)
    :precondition (and (holding ?kit) (robot-at ?to) (space ?to) (not (= ?kit ?to)))
    :effect (and (at ?kit ?to) (not (holding ?kit))))

  (:action give
    :parameters (?kit - kit ?person - location)
    :precondition (and (holding ?kit) (robot-at ?person) (person ?person))
    :effect (and (at ?kit ?person) (not (holding ?kit))))

  (:action connect
    :parameters (?cable - kit ?socket - location)
    :precondition (and (holding ?cable) (robot-at ?socket) (cable ?cable) (socket ?socket))
    :effect (and (plugged ?cable ?socket) (not (holding ?cable))))

  (:action pull
    :parameters (?cable - kit ?socket - location)
    :precondition (and (plugged ?cable ?socket) (robot-at ?socket)
                       (forall (?other - kit) (not (holding ?other))))
    :effect (and (holding ?cable) (not (plugged ?cable ?socket))))

  (:action start-up
    :parameters (?server - kit)
    :precondition (and (server ?server) (robot-at ?server) (not (up ?server)))
    :effect (up ?server))

  (:action shut-down
    :parameters (?server - kit)
    :precondition (and (server ?server) (robot-at ?server) (up ?server))
    :effect (not (up ?server)))

  (:action turn-key
    :parameters (?door - location)
    :precondition (and (lockable ?door) (robot-at ?door) (not (locked ?door)))
    :effect (locked ?door))

  (:action release
    :parameters (?door - location)
    :precondition (and (lockable ?door) (robot-at ?door) (locked ?door))
    :effect (not (locked ?door)))

  (:action adjust
    :parameters (?cooler - location ?temperature - temperature)
    :precondition (and (cooler ?cooler) (robot-at ?cooler) (not (set-to ?cooler ?temperature)))
    :effect (and (forall (?other - temperature) (not (set-to ?cooler ?other))) (set-to ?cooler ?temperature)))

  (:action change-mode
    :parameters (?cooler - location ?mode - location)
    :precondition (and (cooler ?cooler) (mode ?mode) (robot-at ?cooler) (not (blows ?cooler ?mode)))
    :effect (and (forall (?other - location) (not (blows ?cooler ?other))) (blows ?cooler ?mode)))

  (:action limit
    :parameters (?strip - location ?current - current)
    :precondition (and (strip ?strip) (robot-at ?strip) (not (limited ?strip ?current)))
    :effect (and (forall (?other - current) (not (limited ?strip ?other))) (limited ?strip ?current)))

  (:action file-ticket
    :parameters (?entity - entity)
    :precondition (not (filed ?entity))
    :effect (filed ?entity))

  (:action tell
    :parameters (?person - location ?entity - entity)
    :precondition (and (person ?person) (robot-at ?person))
    :effect (told ?person ?entity))

  ; It is enough to stand in front of the thing.
  (:action read-light
    :parameters (?kit - kit)
    :precondition (and (server ?kit) (robot-at ?kit))
    :effect (and))

  (:action look-for-water
    :parameters (?location - location)
    :precondition (and (cooler ?location) (robot-at ?location))
    :effect (and)))
