; Parcels, trucks within cities, and planes between airports.
(define (domain logistics)
  (:requirements :strips :typing)
  (:types vehicle parcel place city - object truck plane - vehicle airport - place)
  (:predicates
    (at-vehicle ?vehicle - vehicle ?place - place)
    (at-parcel ?parcel - parcel ?place - place)
    (aboard ?parcel - parcel ?vehicle - vehicle)
    (in-city ?place - place ?city - city))
  (:action drive
    :parameters (?truck - truck ?from - place ?to - place ?city - city)
    :precondition (and (at-vehicle ?truck ?from) (in-city ?from ?city) (in-city ?to ?city))
    :effect (and (not (at-vehicle ?truck ?from)) (at-vehicle ?truck ?to)))
  (:action fly
    :parameters (?plane - plane ?from - airport ?to - airport)
    :precondition (at-vehicle ?plane ?from)
    :effect (and (not (at-vehicle ?plane ?from)) (at-vehicle ?plane ?to)))
  (:action load
    :parameters (?parcel - parcel ?vehicle - vehicle ?place - place)
    :precondition (and (at-parcel ?parcel ?place) (at-vehicle ?vehicle ?place))
    :effect (and (not (at-parcel ?parcel ?place)) (aboard ?parcel ?vehicle)))
  (:action unload
    :parameters (?parcel - parcel ?vehicle - vehicle ?place - place)
    :precondition (and (aboard ?parcel ?vehicle) (at-vehicle ?vehicle ?place))
    :effect (and (at-parcel ?parcel ?place) (not (aboard ?parcel ?vehicle)))))
