//! The writer: converts a state to an environment.

use indexmap::IndexMap;
use rustc_hash::FxHashSet;

use super::statement::{Statement, is_stated, number_of, statement};
use super::{EntityId, Environment, Fact, Fluent, State, Words, World};
use crate::call::Call;
use crate::model::{entries_of, entry_of_number};

/// Writes `state` as an environment, given the `world` with the initial state.
///
/// Only changes are written: assumed facts stay implicit, and order and style of the initial environment are preserved.
pub fn write(world: &World, state: &State) -> Environment {
    let mut environment = world.environment().clone();
    let as_list = environment.prefers_lists();
    let mut news: IndexMap<EntityId, Vec<String>> = IndexMap::new();
    for fact in state.iter().filter(|fact| !world.state.holds(*fact)) {
        if world.domain().predicate(fact.predicate()).parameters.is_empty() {
            continue;
        }
        for (subject, text) in entries_of(world, fact) {
            news.entry(subject).or_default().push(text);
        }
    }
    let given = |fluent: &Fluent| world.state.number(*fluent).is_some();
    for (fluent, number) in state.numbers().iter().filter(|(fluent, _)| !given(fluent)) {
        if let (Some(subject), text) = entry_of_number(world, *fluent, *number) {
            news.entry(subject).or_default().push(text);
        }
    }
    environment.facts = facts(world, state);
    for states in [&mut environment.asset_states, &mut environment.object_states] {
        for (identifier, words) in states.iter_mut() {
            let Some(subject) = world.find(identifier) else {
                continue;
            };
            renumber(world, state, Some(subject), words.as_mut_slice());
            let new = news.get_mut(&subject).map(std::mem::take).unwrap_or_default();
            revise(world, state, subject, words, new);
        }
        states.retain(|_, words| !matches!(words, Words::Many(many) if many.is_empty()));
    }
    let assets: FxHashSet<&String> = world.environment().assets.iter().collect();
    for (subject, mut new) in news.into_iter().filter(|(_, new)| !new.is_empty()) {
        let identifier = world.entity(subject).identifier.clone();
        let words = match (as_list, new.len()) {
            (false, 1) => Words::One(new.remove(0)),
            _ => Words::Many(new),
        };
        let states = if assets.contains(&identifier) {
            &mut environment.asset_states
        } else {
            &mut environment.object_states
        };
        states.insert(identifier, words);
    }
    environment
}

/// Replaces the numbers that have changed.
fn renumber(world: &World, state: &State, subject: Option<EntityId>, words: &mut [String]) {
    for text in words {
        let Some((fluent, before)) = number_of(world, subject, text) else {
            continue;
        };
        if let Some(after) = state.number(fluent).filter(|after| *after != before) {
            *text = entry_of_number(world, fluent, after).1;
        }
    }
}

/// Returns the statements without a subject in a state. An environment that has none says nothing about facts without
/// arguments, and so does the new one.
fn facts(world: &World, state: &State) -> Option<Vec<String>> {
    let domain = world.domain();
    let given = world.environment().facts.clone();
    let mut facts = given.clone().unwrap_or_default();
    renumber(world, state, None, &mut facts);
    facts.retain(|text| !matches!(statement(world, text), Some(Statement::Fact(fact)) if !state.holds(fact)));
    if given.is_some() {
        let new = state.iter().filter(|fact| !world.state.holds(*fact));
        let new = new.filter(|fact| is_stated(domain, fact.predicate()));
        facts.extend(new.map(|fact| domain.predicate(fact.predicate()).name.clone()));
    }
    let numbers = state.numbers().iter();
    let new = numbers.filter(|(fluent, _)| world.state.number(*fluent).is_none());
    let new = new.map(|(fluent, number)| entry_of_number(world, *fluent, *number));
    facts.extend(new.filter(|(subject, _)| subject.is_none()).map(|(_, text)| text));
    (given.is_some() || !facts.is_empty()).then_some(facts)
}

/// Removes the states that no longer hold from an entry and inserts `new` at the position of the first one.
fn revise(world: &World, state: &State, subject: EntityId, words: &mut Words, new: Vec<String>) {
    let old = words.as_slice();
    let kept = |text: &String| fact_of(world, subject, text).is_none_or(|fact| state.holds(fact));
    let place = old.iter().position(|text| !kept(text));
    if place.is_none() && new.is_empty() {
        return;
    }
    let place = place.unwrap_or(old.len());
    let mut revised: Vec<String> = old[..place].to_vec();
    revised.extend(new);
    revised.extend(old[place..].iter().filter(|text| kept(text)).cloned());
    *words = match (&*words, revised.len()) {
        (Words::One(_), 1) => Words::One(revised.remove(0)),
        _ => Words::Many(revised),
    };
}

/// Parses a state in the entry of `subject`; none if the domain has no such state or the world no such entity.
pub fn fact_of(world: &World, subject: EntityId, text: &str) -> Option<Fact> {
    let call = Call::parse(text).ok()?;
    let word = world
        .domain()
        .states
        .iter()
        .find(|s| s.word == call.name && s.parameters.len() == call.arguments.len())?;
    let mut bindings = vec![subject];
    for argument in &call.arguments {
        bindings.push(world.exactly(argument)?);
    }
    Some(crate::model::ground(&word.atom, &bindings))
}
