//! Mishaps: what goes wrong at a step, in any domain.

use std::collections::BTreeMap;

use longstep_core::environment::{EntityId, Fact, State, World};
use longstep_core::model::{Changes, RuleTime, broken_bindings, state_word};

use super::random::Random;

/// A kind of mishap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mishap {
    /// The robot says that it could not do the step, and nothing happens.
    Fails,
    /// The robot says that it did the step, and nothing happens.
    NoEffect,
    /// The object that the robot holds in the air falls back to where it was last.
    Slips,
    /// Somebody moves an object to another place.
    Moved,
    /// Somebody undoes a change that an earlier step made: closes what was opened.
    Undone,
}

impl Mishap {
    const ALL: [Self; 5] = [Self::Fails, Self::NoEffect, Self::Slips, Self::Moved, Self::Undone];

    /// Returns the kind with this name.
    pub(super) fn named(name: &str) -> Option<Self> {
        let names = ["fails", "no-effect", "slips", "moved", "undone"];
        let place = names.iter().position(|own| *own == name)?;
        Some(Self::ALL[place])
    }

    pub(super) fn drawn(random: &mut Random, kinds: &[Self]) -> Self {
        let kinds = if kinds.is_empty() { &Self::ALL } else { kinds };
        *random.choose(kinds).unwrap_or(&Self::Fails)
    }
}

/// The past of the simulated world, as far as mishaps depend on it.
#[derive(Debug, Clone, Default)]
pub(super) struct History {
    /// The last place of each object.
    places: BTreeMap<EntityId, Fact>,
    /// The properties that steps changed, with the new value, the last one last.
    changed: Vec<(Fact, bool)>,
}

impl History {
    pub(super) fn of(world: &World) -> Self {
        let mut history = Self::default();
        for fact in world.state.iter() {
            history.place(world, fact);
        }
        history
    }

    fn place(&mut self, world: &World, fact: Fact) {
        if is_place(world, fact) {
            self.places.insert(fact.argument(0), fact);
        }
    }

    pub(super) fn record(&mut self, world: &World, changes: &Changes) {
        let domain = world.domain();
        for change in &changes.facts {
            if change.holds {
                self.place(world, change.fact);
            }
            let is_property = domain.predicate(change.fact.predicate()).parameters.len() == 1;
            if is_property && state_word(domain, change.fact.predicate()).is_some() {
                self.changed.push((change.fact, change.holds));
            }
        }
    }

    /// Lets a mishap happen to the world. One that is not possible here does not happen.
    pub(super) fn befall(&mut self, mishap: Mishap, world: &World, state: &mut State, random: &mut Random) {
        let after = match mishap {
            Mishap::Fails | Mishap::NoEffect => return,
            Mishap::Slips => self.slip(world, state, random),
            Mishap::Moved => moved(world, state, random),
            Mishap::Undone => self.undone(state),
        };
        if let Some(after) = after.filter(|after| is_possible(world, state, after)) {
            *state = after;
            for fact in state.iter().collect::<Vec<_>>() {
                self.place(world, fact);
            }
        }
    }

    fn slip(&self, world: &World, state: &State, random: &mut Random) -> Option<State> {
        let has_place = |entity: EntityId| {
            state
                .iter()
                .any(|fact| is_place(world, fact) && fact.argument(0) == entity)
        };
        let lifted: Vec<(&EntityId, &Fact)> = self.places.iter().filter(|(entity, _)| !has_place(**entity)).collect();
        let (entity, place) = random.choose(&lifted)?;
        let mut after = detached(world, state, **entity);
        after.set(**place, true);
        Some(after)
    }

    /// Undoes the properties that the last step with any has changed.
    fn undone(&mut self, state: &State) -> Option<State> {
        let (fact, holds) = *self
            .changed
            .iter()
            .rev()
            .find(|(fact, holds)| state.holds(*fact) == *holds)?;
        let mut after = state.clone();
        after.set(fact, !holds);
        // What changed together with it, such as `open` with `closed`.
        let entity = fact.argument(0);
        let others = self.changed.iter().rev().take(2);
        for (other, value) in others.filter(|(other, value)| other.argument(0) == entity && *value != holds) {
            after.set(*other, !*value);
        }
        Some(after)
    }
}

/// Returns true for the fact that an object is at a place.
fn is_place(world: &World, fact: Fact) -> bool {
    let domain = world.domain();
    let id = fact.predicate();
    domain.words(id).fluent
        && domain.predicate(id).parameters.len() == 2
        && state_word(domain, id).is_some()
        && world.is_of_kind(fact.argument(0), domain.environment.object)
        // A constant of the domain, such as a hand, is no place.
        && fact.argument(1).index() >= domain.constants.len()
}

/// Returns the state in which somebody has moved an object that nobody holds.
fn moved(world: &World, state: &State, random: &mut Random) -> Option<State> {
    let domain = world.domain();
    let places: Vec<Fact> = state.iter().filter(|fact| is_place(world, *fact)).collect();
    let is_free = |entity: EntityId| {
        let stated = state.iter().filter(|fact| {
            let id = fact.predicate();
            domain.words(id).fluent
                && state_word(domain, id).is_some()
                && !domain.is_sensed(id)
                && fact.argument(0) == entity
        });
        stated.count() == 1 && !places.iter().any(|own| own.argument(1) == entity)
    };
    let free: Vec<&Fact> = places.iter().filter(|own| is_free(own.argument(0))).collect();
    let from = **random.choose(&free)?;
    let entity = from.argument(0);
    let targets: Vec<&Fact> = places
        .iter()
        .filter(|own| own.argument(1) != from.argument(1) && own.argument(1) != entity)
        .collect();
    let to = **random.choose(&targets)?;
    let mut after = detached(world, state, entity);
    after.set(from, false);
    after.set(Fact::new(to.predicate(), [entity, to.argument(1)]), true);
    Some(after)
}

/// Returns the state without the facts that tie an object to the robot: all changing facts about it, except for its
/// places and its own properties that an environment states and that do not speak of the robot.
fn detached(world: &World, state: &State, entity: EntityId) -> State {
    let domain = world.domain();
    let mut after = state.clone();
    let ties: Vec<Fact> = state
        .iter()
        .filter(|fact| {
            let words = domain.words(fact.predicate());
            words.fluent
                && !words.event
                && !domain.is_sensed(fact.predicate())
                && domain.arguments(*fact).any(|own| own == entity)
                && !is_place(world, *fact)
                && is_tie(world, *fact)
        })
        .collect();
    for fact in ties {
        after.set(fact, false);
    }
    after
}

/// Returns true for a fact that ties an object to the robot: one that no environment states, or one with a hand, or one
/// that only a step makes true and no object has at the beginning of this world.
fn is_tie(world: &World, fact: Fact) -> bool {
    let domain = world.domain();
    let id = fact.predicate();
    let constants = domain.constants.len();
    state_word(domain, id).is_none()
        || domain.arguments(fact).any(|own| own.index() < constants)
        || world.state.of_predicate(id).is_empty()
}

/// Returns true if a state breaks no rule that the state before it keeps.
fn is_possible(world: &World, before: &State, after: &State) -> bool {
    let rules = world.domain().rules.iter();
    let mut binding = rules.filter(|rule| matches!(rule.time, RuleTime::Start | RuleTime::Always));
    binding.all(|rule| broken_bindings(rule, world, after).len() <= broken_bindings(rule, world, before).len())
}
