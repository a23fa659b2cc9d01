//! Goals about things whose state becomes unknown again when something is done to them.

use super::*;
use crate::domain::{self, Files};
use crate::environment;
use crate::goal;
use crate::json::Path;
use crate::model::Environment;
use crate::verify::check as verify;

/// Bowls that are filled from a jug or a bag, of which the robot can hold one. Filling a bowl hides how full it was.
const PDDL: &str = "
(define (domain bowls)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions :quantified-preconditions
                 :conditional-effects)
  (:types place item)
  (:predicates (bowl ?item - item) (food ?item - item) (robot-at ?place - place) (at ?item - item ?place - place)
               (holding ?item - item) (full ?item - item) (half-full ?item - item) (empty ?item - item)
               (was-full ?item - item) (was-half-full ?item - item) (was-empty ?item - item)
               (filled ?item - item ?food - item))
  (:action go :parameters (?to - place) :precondition (not (robot-at ?to))
    :effect (and (forall (?from - place) (not (robot-at ?from))) (robot-at ?to)))
  (:action take :parameters (?item - item ?from - place)
    :precondition (and (robot-at ?from) (at ?item ?from) (forall (?other - item) (not (holding ?other))))
    :effect (and (holding ?item) (not (at ?item ?from))))
  (:action leave :parameters (?item - item ?to - place) :precondition (and (holding ?item) (robot-at ?to))
    :effect (and (at ?item ?to) (not (holding ?item))))
  (:action pour :parameters (?food - item ?bowl - item)
    :precondition (and (food ?food) (bowl ?bowl) (holding ?food)
                       (exists (?place - place) (and (robot-at ?place) (at ?bowl ?place))))
    :effect (and (filled ?bowl ?food) (when (full ?bowl) (was-full ?bowl))
                 (when (half-full ?bowl) (was-half-full ?bowl)) (when (empty ?bowl) (was-empty ?bowl))
                 (not (full ?bowl)) (not (half-full ?bowl)) (not (empty ?bowl))))
  (:action look :parameters (?bowl - item)
    :precondition (and (bowl ?bowl) (exists (?place - place) (and (robot-at ?place) (at ?bowl ?place))))
    :effect (and)))
";

/// The predicates with their sentences.
const SAYS: [(&str, &str); 12] = [
    ("bowl", "{item} is a bowl"),
    ("food", "{item} is food"),
    ("robot-at", "the robot is at {place}"),
    ("at", "{item} is at {place}"),
    ("holding", "the robot holds {item}"),
    ("full", "{item} is full"),
    ("half-full", "{item} is half full"),
    ("empty", "{item} is empty"),
    ("was-full", "{item} was full"),
    ("was-half-full", "{item} was half full"),
    ("was-empty", "{item} was empty"),
    ("filled", "{item} has been filled from {food}"),
];

const WORDS: &str = r#"
name = "bowls"
about = "A robot that fills bowls."
[environment]
assets = "place"
objects = "item"
[[property]]
word = "BOWL"
facts = ["(bowl ?self)"]
[[property]]
word = "FOOD"
facts = ["(food ?self)"]
[[state]]
word = "here()"
fact = "(robot-at ?self)"
means = "The robot is there."
[[state]]
word = "at(<place>)"
fact = "(at ?self ?place)"
means = "It is there."
[[state]]
word = "full()"
fact = "(full ?self)"
means = "It is full."
[[state]]
word = "half_full()"
fact = "(half-full ?self)"
means = "It is half full."
[[state]]
word = "empty()"
fact = "(empty ?self)"
means = "It is empty."
[[goal]]
form = "filled({item}, {food})"
parameters = "?item - item ?food - item"
subject = "?item"
condition = "(filled ?item ?food)"
offered = "(and (bowl ?item) (food ?food))"
says = "{item} has been filled from {food}"
means = "Fill a bowl."
[[action]]
name = "go"
call = "go(to)"
says = "go to {to}"
means = "Drive there."
[[action]]
name = "take"
call = "take(item, from)"
says = "take {item} from {from}"
means = "Take it."
[[action]]
name = "leave"
call = "leave(item, to)"
says = "leave {item} at {to}"
means = "Put it down."
[[action]]
name = "pour"
call = "pour(food, bowl)"
says = "fill {bowl} from {food}"
means = "Fill it."
[[action]]
name = "look"
call = "look(bowl)"
senses = ["(full ?bowl)", "(half-full ?bowl)", "(empty ?bowl)"]
says = "look how full {bowl} is"
means = "Tell how full it is."
[[rule]]
name = "hand-empty"
holds = "end"
condition = "(forall (?item - item) (not (holding ?item)))"
says = "the robot's hand must be empty"
"#;

const SCENE: &str = r#"{"assets": ["<table>", "<kennel>"], "asset_states": {"<table>": "here()"},
    "objects": ["<jug>", "<bag>", "<water_bowl>", "<cat_bowl>"],
    "object_states": {"<jug>": "at(<table>)", "<bag>": "at(<table>)", "<cat_bowl>": "at(<table>)",
        "<water_bowl>": "at(<kennel>)"},
    "object_properties": {"<jug>": ["FOOD"], "<bag>": ["FOOD"], "<water_bowl>": ["BOWL"], "<cat_bowl>": ["BOWL"]}}"#;

fn world() -> World {
    let says = SAYS.map(|(name, says)| {
        let denies = says.replace(" is ", " is not ").replace(" has ", " has not ");
        let denies = denies
            .replace(" was ", " was not ")
            .replace(" holds ", " does not hold ");
        format!("[[predicate]]\nname = \"{name}\"\nsays = \"{says}\"\ndenies = \"{denies}\"\n")
    });
    let files = Files {
        pddl: PDDL.to_owned(),
        words: format!("{WORDS}{}", says.concat()),
        ..Files::default()
    };
    let domain = domain::load(&files).unwrap_or_else(|findings| panic!("{findings}"));
    let environment = Environment::from_json(SCENE).unwrap();
    environment::read(&domain, &environment, "", SCENE, &Path::default()).unwrap()
}

#[test]
fn two_things_can_be_filled_that_may_need_it() {
    let world = world();
    for text in [
        "if half_full(water bowl) then filled(water bowl, jug)",
        "if half_full(water bowl) then filled(water bowl, jug) & if empty(cat bowl) then filled(cat bowl, bag)",
        "if not full(water bowl) then filled(water bowl, jug) & if empty(cat bowl) then filled(cat bowl, bag)",
    ] {
        let goal = goal::parse(&world, text).unwrap();
        let purpose = goal.purpose(&world);
        match solve(&world, &Target::of(world.domain(), &purpose), &Limits::default()) {
            Outcome::Solved { plan, .. } => assert_eq!(verify(&world, plan, &purpose).violations, [], "{text}"),
            outcome => panic!("{text}: {outcome:?}"),
        }
    }
}
