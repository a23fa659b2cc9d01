//! The writer: converts a state to an environment.

use indexmap::IndexMap;

use super::{EntityId, Environment, Fact, State, Words, World};
use crate::call::Call;
use crate::model::entries_of;

/// Writes `state` as an environment, given the `world` with the initial state.
///
/// Only changes are written: assumed facts stay implicit, and order and style of the initial environment are preserved.
pub fn write(world: &World, state: &State) -> Environment {
    let mut environment = world.environment().clone();
    let as_list = environment.prefers_lists();
    let mut news: IndexMap<EntityId, Vec<String>> = IndexMap::new();
    for fact in state.iter().filter(|fact| !world.state.holds(*fact)) {
        for (subject, text) in entries_of(world, fact) {
            news.entry(subject).or_default().push(text);
        }
    }
    for states in [&mut environment.asset_states, &mut environment.object_states] {
        for (identifier, words) in states.iter_mut() {
            let Some(subject) = world.find(identifier) else {
                continue;
            };
            let new = news.shift_remove(&subject).unwrap_or_default();
            revise(world, state, subject, words, new);
        }
        states.retain(|_, words| !matches!(words, Words::Many(many) if many.is_empty()));
    }
    for (subject, mut new) in news {
        let identifier = world.entity(subject).identifier.clone();
        let words = match (as_list, new.len()) {
            (false, 1) => Words::One(new.remove(0)),
            _ => Words::Many(new),
        };
        let states = if environment.assets.contains(&identifier) {
            &mut environment.asset_states
        } else {
            &mut environment.object_states
        };
        states.insert(identifier, words);
    }
    environment
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
