//! Claims: the environment that a plan claims for its end.

use rustc_hash::FxHashSet;

use super::statement::{Statement, number_of, statement};
use super::write::fact_of;
use super::{
    Bindings, Difference, EntityId, Environment, Fact, Fluent, Moment, Number, State, World, differences, holds,
};
use crate::model::{Domain, ground, subject_of};

/// A claimed environment, as facts about the entities of the world.
///
/// A claim is evidence, not input: unreadable parts are skipped and listed, and a claim says nothing about entities
/// that it does not mention.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Claim {
    /// The claimed state; the initial state for entities that the claim does not mention.
    pub state: State,
    /// The unreadable parts of the claim, as sentences.
    pub ignored: Vec<String>,
    mentioned: FxHashSet<EntityId>,
    /// The claimed numbers, sorted by fluent.
    numbers: Vec<(Fluent, Number)>,
}

impl Claim {
    /// Reads a claimed environment.
    pub fn read(world: &World, claimed: &Environment) -> Self {
        let domain = world.domain();
        let mut claim = Self {
            state: world.state.clone(),
            ignored: Vec::new(),
            mentioned: FxHashSet::default(),
            numbers: Vec::new(),
        };
        let listed = claimed.assets.iter().chain(&claimed.objects);
        let entries = claimed.asset_states.iter().chain(&claimed.object_states);
        for identifier in listed.chain(entries.clone().map(|(identifier, _)| identifier)) {
            match world.find(identifier) {
                Some(entity) => {
                    claim.mentioned.insert(entity);
                }
                None => claim.ignore(format!("`{identifier}`, which the environment before does not list")),
            }
        }
        for fact in expressible(domain, &world.state) {
            if claim.mentioned.contains(&subject_of(domain, fact)) {
                claim.state.set(fact, false);
            }
        }
        for (identifier, words) in entries {
            let Some(subject) = world.find(identifier) else {
                continue;
            };
            for text in words.as_slice() {
                if let Some(number) = number_of(world, Some(subject), text) {
                    claim.numbers.push(number);
                    continue;
                }
                match fact_of(world, subject, text) {
                    Some(fact) => {
                        claim.state.set(fact, true);
                    }
                    None => claim.ignore(format!("`{text}` of `{identifier}`")),
                }
            }
        }
        for text in claimed.facts.iter().flatten() {
            match statement(world, text) {
                Some(Statement::Number(fluent, number)) => claim.numbers.push((fluent, number)),
                Some(Statement::Fact(_)) => {}
                None => claim.ignore(format!("`{text}`")),
            }
        }
        claim.numbers.sort_unstable();
        claim.numbers.dedup();
        for (fluent, number) in &claim.numbers {
            claim.state.set_number(*fluent, *number);
        }
        for default in &domain.defaults {
            for entity in claim.mentioned.iter().copied() {
                let mut bindings: Bindings = vec![entity];
                let moment = Moment {
                    world,
                    state: &claim.state,
                };
                // A default only completes a claim; it does not claim a change.
                let fact = ground(&default.atom, &bindings);
                if world.state.holds(fact) && holds(moment, &default.when, &mut bindings) {
                    claim.state.set(fact, true);
                }
            }
        }
        claim
    }

    fn ignore(&mut self, what: String) {
        if !self.ignored.contains(&what) {
            self.ignored.push(what);
        }
    }

    /// Returns the claim without some of its facts.
    #[must_use]
    pub fn without(mut self, facts: &[Fact]) -> Self {
        for fact in facts {
            self.state.set(*fact, false);
        }
        self
    }

    /// Returns the claim without its numbers.
    #[must_use]
    pub fn without_numbers(mut self) -> Self {
        self.numbers.clear();
        self
    }

    /// Returns true if the claim mentions the entity.
    pub fn mentions(&self, entity: EntityId) -> bool {
        self.mentioned.contains(&entity)
    }

    /// Returns the facts in which a state differs from the claim, sorted.
    pub fn differences(&self, domain: &Domain, state: &State) -> Vec<Difference> {
        let mut all = differences(domain, state, &self.state);
        all.retain(|difference| self.mentioned.contains(&subject_of(domain, difference.fact)));
        all
    }

    /// Returns the claimed facts that did not hold initially, in order: the changes that the plan promises.
    pub fn promises(&self, world: &World) -> Vec<Fact> {
        let domain = world.domain();
        let new = differences(domain, &world.state, &self.state);
        new.into_iter().filter(|d| d.now_holds).map(|d| d.fact).collect()
    }

    /// Returns the claimed numbers that differ from the initial ones and that actions change, sorted by fluent.
    pub fn promised_numbers(&self, world: &World) -> Vec<(Fluent, Number)> {
        let promised = |(fluent, number): &&(Fluent, Number)| {
            world.domain().function(fluent.function()).changes && world.state.number(*fluent) != Some(*number)
        };
        self.numbers.iter().filter(promised).copied().collect()
    }

    /// Returns the claimed facts that held initially, in order.
    pub fn kept(&self, world: &World) -> Vec<Fact> {
        let domain = world.domain();
        let mut kept = expressible(domain, &self.state);
        kept.retain(|fact| world.state.holds(*fact) && self.mentioned.contains(&subject_of(domain, *fact)));
        kept
    }
}

/// Returns the facts of a state that an environment can express, in order.
fn expressible(domain: &Domain, state: &State) -> Vec<Fact> {
    differences(domain, &State::default(), state)
        .into_iter()
        .map(|difference| difference.fact)
        .collect()
}
