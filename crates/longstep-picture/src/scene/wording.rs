//! The states of one entity in short words for a person.

use longstep_core::model::{EntityId, Fact, Fluent, PredicateId, State, Voice, World};
use serde::Serialize;

use super::placement::{Body, Placement};
use super::schema::SceneSchema;

/// A state of an entity in short words: `open`, `switched on`, `level 3 l`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[non_exhaustive]
pub struct StateText {
    /// The words.
    pub text: String,
    /// True if the environment does not say it and it is assumed.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub assumed: bool,
}

/// The states of a body, and the events that have happened to it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Words {
    pub(super) states: Vec<StateText>,
    pub(super) events: Vec<String>,
    /// Places that the nesting shows: no change of state where another picture writes them.
    pub(super) nested: Vec<String>,
}

/// Stands for the entity that a sentence is about while its template is filled.
const SUBJECT: &str = "\u{0}";

/// Returns the words for one body in a state, without those that say its place.
pub(super) fn words_of(schema: &SceneSchema, world: &World, state: &State, placement: &Placement, body: Body) -> Words {
    match body {
        Body::Entity(entity) => words_of_entity(schema, world, state, placement, entity),
        Body::Robot => {
            let facts = schema.robot_states.iter().flat_map(|own| state.of_predicate(*own));
            let further = schema.robot_places.iter().flat_map(|own| state.of_predicate(*own));
            let shown = placement.spot(Body::Robot).and_then(|spot| spot.fact);
            let facts = facts.chain(further.filter(|fact| Some(**fact) != shown));
            Words {
                states: facts
                    .map(|fact| state_text(world, *fact, sentence(world, *fact)))
                    .collect(),
                ..Words::default()
            }
        }
    }
}

fn words_of_entity(
    schema: &SceneSchema,
    world: &World,
    state: &State,
    placement: &Placement,
    entity: EntityId,
) -> Words {
    let mut words = Words::default();
    for form in &schema.states {
        let Some(subject) = form.subject else { continue };
        if is_of_robot(schema, form.predicate) {
            continue;
        }
        for fact in about(state, form.predicate, subject, entity) {
            let text = short_text(world, fact, subject);
            if says_place(schema, placement, fact) {
                words.nested.push(text);
            } else if form.event {
                words.events.push(text);
            } else {
                words.states.push(state_text(world, fact, text));
            }
        }
    }
    for function in &schema.numbers {
        if !world.domain().function(*function).parameters.is_empty() {
            words
                .states
                .extend(numbers(world, state, Fluent::new(*function, [entity])));
        }
    }
    words
}

/// Returns true for a fact that the nesting of boxes shows: one box is around the other.
fn says_place(schema: &SceneSchema, placement: &Placement, fact: Fact) -> bool {
    let form = schema.places.iter().find(|form| form.predicate == fact.predicate());
    form.is_some_and(|form| {
        let holder = form
            .place
            .map_or(Body::Robot, |place| Body::Entity(fact.argument(place)));
        let body = Body::Entity(fact.argument(form.subject));
        match placement.spot(body) {
            // The relation to the next box is shown; a second one, as held and lying, is not.
            Some(spot) if spot.holder == holder => spot.fact == Some(fact),
            _ => placement.around(body).any(|around| around == holder),
        }
    })
}

/// Returns true for a predicate that says where the robot is: it is shown at the robot.
fn is_of_robot(schema: &SceneSchema, predicate: PredicateId) -> bool {
    schema.robot_places.contains(&predicate) || schema.robot_states.contains(&predicate)
}

/// Iterates over the facts of a predicate with this entity at a position.
fn about(state: &State, predicate: PredicateId, position: usize, entity: EntityId) -> impl Iterator<Item = Fact> {
    let facts = match position {
        0 => state.of_first(predicate, entity),
        _ => state.of_predicate(predicate),
    };
    facts
        .iter()
        .copied()
        .filter(move |fact| fact.argument(position) == entity)
}

/// Returns the entity that a fact is shown at.
pub(super) fn body_of(schema: &SceneSchema, fact: Fact) -> Option<Body> {
    if is_of_robot(schema, fact.predicate()) {
        return Some(Body::Robot);
    }
    let form = schema.states.iter().find(|form| form.predicate == fact.predicate())?;
    Some(Body::Entity(fact.argument(form.subject?)))
}

/// Returns the statements about no entity: facts and numbers without arguments.
pub(super) fn statements(schema: &SceneSchema, world: &World, state: &State) -> Vec<String> {
    let forms = schema
        .states
        .iter()
        .filter(|form| form.subject.is_none() && !form.event);
    let facts = forms.flat_map(|form| state.of_predicate(form.predicate));
    let functions = schema.numbers.iter();
    let bare = functions.filter(|id| world.domain().function(**id).parameters.is_empty());
    let numbers = bare.flat_map(|id| numbers(world, state, Fluent::new(*id, [])));
    facts
        .map(|fact| sentence(world, *fact))
        .chain(numbers.map(|number| number.text))
        .collect()
}

/// Returns the numbers of a fluent and of those with further arguments.
fn numbers(world: &World, state: &State, first: Fluent) -> Vec<StateText> {
    let function = world.domain().function(first.function());
    let from = state.numbers().partition_point(|(fluent, _)| *fluent < first);
    let same = |fluent: &Fluent| {
        fluent.function() == first.function()
            && (function.parameters.is_empty() || fluent.argument(0) == first.argument(0))
    };
    let own = state.numbers()[from..].iter().take_while(|(fluent, _)| same(fluent));
    own.map(|(fluent, number)| {
        let others = (1..function.parameters.len()).map(|place| Voice::Person.name(world, fluent.argument(place)));
        let mut text = plain(&function.word);
        others.for_each(|other| text.extend([" ", &other]));
        StateText {
            text: format!("{text} {}", Voice::Person.number(world, *fluent, *number)),
            assumed: false,
        }
    })
    .collect()
}

fn state_text(world: &World, fact: Fact, text: String) -> StateText {
    StateText {
        text,
        assumed: world.assumed(fact).is_some() && world.state.holds(fact),
    }
}

/// Writes a fact as a sentence.
fn sentence(world: &World, fact: Fact) -> String {
    let words = &world.domain().words(fact.predicate()).says;
    let text = words.fill(|place| Voice::Person.name(world, fact.argument(place)));
    if is_pddl(world, fact, &text) {
        return pddl_text(world, fact, usize::MAX);
    }
    text
}

/// Writes a fact as it stands under one of its entities: "open" for "the fridge is open".
fn short_text(world: &World, fact: Fact, subject: usize) -> String {
    let words = world.domain().words(fact.predicate());
    let name = |place: usize| Voice::Person.name(world, fact.argument(place));
    if let Some(short) = words.short.as_ref().filter(|_| subject == 0) {
        return short.fill(name);
    }
    let with_subject = |place: usize| {
        if place == subject {
            SUBJECT.to_owned()
        } else {
            name(place)
        }
    };
    let text = words.says.fill(with_subject);
    if is_pddl(world, fact, &text) {
        return pddl_text(world, fact, subject);
    }
    match text.strip_prefix(SUBJECT) {
        Some(rest) => rest.trim_start().trim_start_matches("is ").to_owned(),
        None => text.replace(SUBJECT, "it"),
    }
}

/// Returns true if a sentence is only the fact in PDDL, since the domain has no words.
fn is_pddl(world: &World, fact: Fact, text: &str) -> bool {
    let name = &world.domain().predicate(fact.predicate()).name;
    let inside = text.strip_prefix('(').and_then(|rest| rest.strip_prefix(name.as_str()));
    inside.is_some_and(|rest| rest.starts_with([' ', ')']))
}

/// Writes a fact of a domain without words: the name of the predicate and of its entities, without one of them.
fn pddl_text(world: &World, fact: Fact, left_out: usize) -> String {
    let mut text = plain(&world.domain().predicate(fact.predicate()).name);
    for (place, entity) in world.domain().arguments(fact).enumerate() {
        if place != left_out {
            text.extend([" ", &world.entity(entity).name]);
        }
    }
    text
}

/// Returns a name of the domain as words.
fn plain(name: &str) -> String {
    name.replace(['_', '-'], " ")
}
