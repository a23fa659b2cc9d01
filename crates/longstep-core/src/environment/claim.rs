//! What a plan claims the world to be afterwards.

use rustc_hash::FxHashSet;

use super::write::fact_of;
use super::{Bindings, Difference, EntityId, Environment, Fact, Moment, State, World, differences, holds};
use crate::model::{Domain, ground, subject_of};

/// A claimed environment, read as facts about the world's own entities.
///
/// A claim is evidence, not input: what cannot be read in it is left out and listed, and of entities that it does not
/// mention it says nothing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Claim {
    /// What is claimed to hold; for what the claim does not mention, what held before.
    pub state: State,
    /// What the claim says that means nothing here, as sentences.
    pub ignored: Vec<String>,
    spoken_of: FxHashSet<EntityId>,
}

impl Claim {
    /// Reads a claimed environment.
    pub fn read(domain: &Domain, world: &World, claimed: &Environment) -> Self {
        let mut claim = Self {
            state: world.state.clone(),
            ignored: Vec::new(),
            spoken_of: FxHashSet::default(),
        };
        let listed = claimed.assets.iter().chain(&claimed.objects);
        let entries = claimed.asset_states.iter().chain(&claimed.object_states);
        for identifier in listed.chain(entries.clone().map(|(identifier, _)| identifier)) {
            match world.find(identifier) {
                Some(entity) => {
                    claim.spoken_of.insert(entity);
                }
                None => claim.ignore(format!("`{identifier}`, which the environment before does not list")),
            }
        }
        for fact in said(domain, &world.state) {
            if claim.spoken_of.contains(&subject_of(domain, fact)) {
                claim.state.set(fact, false);
            }
        }
        for (identifier, words) in entries {
            let Some(subject) = world.find(identifier) else {
                continue;
            };
            for text in words.as_slice() {
                match fact_of(domain, world, subject, text) {
                    Some(fact) => {
                        claim.state.set(fact, true);
                    }
                    None => claim.ignore(format!("`{text}` of `{identifier}`")),
                }
            }
        }
        for default in &domain.defaults {
            for entity in claim.spoken_of.iter().copied() {
                let mut bindings: Bindings = vec![entity];
                let moment = Moment {
                    world,
                    state: &claim.state,
                };
                // A default fills in what nobody says; it promises no change.
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

    /// The claim without some of its facts.
    #[must_use]
    pub fn without(mut self, facts: &[Fact]) -> Self {
        for fact in facts {
            self.state.set(*fact, false);
        }
        self
    }

    /// Whether the claim says anything of the entity.
    pub fn speaks_of(&self, entity: EntityId) -> bool {
        self.spoken_of.contains(&entity)
    }

    /// Where a state differs from what is claimed, sorted.
    pub fn differences(&self, domain: &Domain, state: &State) -> Vec<Difference> {
        let mut all = differences(domain, state, &self.state);
        all.retain(|difference| self.spoken_of.contains(&subject_of(domain, difference.fact)));
        all
    }

    /// What is claimed to hold that did not hold before, in order: what the plan promises.
    pub fn promises(&self, domain: &Domain, world: &World) -> Vec<Fact> {
        let new = differences(domain, &world.state, &self.state);
        new.into_iter().filter(|d| d.now_holds).map(|d| d.fact).collect()
    }

    /// What is claimed to hold as before, in order.
    pub fn kept(&self, domain: &Domain, world: &World) -> Vec<Fact> {
        let mut kept = said(domain, &self.state);
        kept.retain(|fact| world.state.holds(*fact) && self.spoken_of.contains(&subject_of(domain, *fact)));
        kept
    }
}

/// The facts of a state that an environment can say, in order.
fn said(domain: &Domain, state: &State) -> Vec<Fact> {
    differences(domain, &State::default(), state)
        .into_iter()
        .map(|difference| difference.fact)
        .collect()
}
