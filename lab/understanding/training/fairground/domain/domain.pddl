; A fairground robot: it carries props between booths and people, runs rides at three paces, raises and lowers
; shutters and barriers, lights things up, chalks prices, refills snack machines, scrubs, calls people over, and
; looks at queues and stocks before it decides.
(define (domain fairground)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)

  (:types spot prop - thing pace fare)

  (:constants gentle normal wild - pace)

  (:predicates
    ; what never changes
    (person ?spot - spot)
    (ride ?spot - spot)
    (booth ?spot - spot)
    (flap ?spot - spot)
    (light ?spot - spot)
    (vendor ?spot - spot)
    (queues ?spot - spot)
    ; how things are
    (robot-at ?spot - spot)
    (at ?prop - prop ?spot - spot)
    (gripped ?prop - prop)
    (turning ?spot - spot)
    (paced ?spot - spot ?pace - pace)
    (up ?spot - spot)
    (lit ?spot - spot)
    (costs ?spot - spot ?fare - fare)
    ; what only a look tells
    (stocked ?spot - spot)
    (sold-out ?spot - spot)
    (swamped ?spot - spot)
    (steady ?spot - spot)
    (deserted ?spot - spot)
    ; what happened
    (topped-up ?spot - spot)
    (scrubbed ?spot - spot)
    (hailed ?spot - spot))

  (:action wander
    :parameters (?to - spot)
    :precondition (not (robot-at ?to))
    :effect (and (forall (?from - spot) (not (robot-at ?from))) (robot-at ?to)))

  (:action lift
    :parameters (?prop - prop ?from - spot)
    :precondition (and (robot-at ?from) (at ?prop ?from) (forall (?other - prop) (not (gripped ?other))))
    :effect (and (gripped ?prop) (not (at ?prop ?from))))

  (:action lay-down
    :parameters (?prop - prop ?to - spot)
    :precondition (and (gripped ?prop) (robot-at ?to) (not (person ?to)))
    :effect (and (at ?prop ?to) (not (gripped ?prop))))

  (:action pass-on
    :parameters (?prop - prop ?person - spot)
    :precondition (and (gripped ?prop) (robot-at ?person) (person ?person))
    :effect (and (at ?prop ?person) (not (gripped ?prop))))

  (:action start-up
    :parameters (?ride - spot)
    :precondition (and (ride ?ride) (robot-at ?ride) (not (turning ?ride)))
    :effect (turning ?ride))

  (:action bring-to-rest
    :parameters (?ride - spot)
    :precondition (and (ride ?ride) (robot-at ?ride) (turning ?ride))
    :effect (not (turning ?ride)))

  (:action regulate
    :parameters (?ride - spot ?pace - pace)
    :precondition (and (ride ?ride) (robot-at ?ride) (not (paced ?ride ?pace)))
    :effect (and (forall (?other - pace) (not (paced ?ride ?other))) (paced ?ride ?pace)))

  (:action crank-up
    :parameters (?flap - spot)
    :precondition (and (flap ?flap) (robot-at ?flap) (not (up ?flap)))
    :effect (up ?flap))

  (:action crank-down
    :parameters (?flap - spot)
    :precondition (and (flap ?flap) (robot-at ?flap) (up ?flap))
    :effect (not (up ?flap)))

  (:action light-up
    :parameters (?light - spot)
    :precondition (and (light ?light) (not (lit ?light)))
    :effect (lit ?light))

  (:action douse
    :parameters (?light - spot)
    :precondition (and (light ?light) (lit ?light))
    :effect (not (lit ?light)))

  (:action chalk-up
    :parameters (?booth - spot ?fare - fare)
    :precondition (and (booth ?booth) (robot-at ?booth) (not (costs ?booth ?fare)))
    :effect (and (forall (?other - fare) (not (costs ?booth ?other))) (costs ?booth ?fare)))

  (:action replenish
    :parameters (?vendor - spot)
    :precondition (and (vendor ?vendor) (robot-at ?vendor))
    :effect (topped-up ?vendor))

  (:action scrub
    :parameters (?spot - spot)
    :precondition (and (robot-at ?spot) (not (person ?spot)))
    :effect (scrubbed ?spot))

  (:action hail
    :parameters (?person - spot)
    :precondition (person ?person)
    :effect (hailed ?person))

  (:action peer-inside
    :parameters (?vendor - spot)
    :precondition (and (vendor ?vendor) (robot-at ?vendor))
    :effect (and))

  (:action count-heads
    :parameters (?spot - spot)
    :precondition (and (queues ?spot) (robot-at ?spot))
    :effect (and)))
