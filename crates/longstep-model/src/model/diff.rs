//! Differences between two states of a world.

use super::{Domain, Fact, PredicateId, State};

/// A fact that holds in exactly one of two states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Difference {
    /// The fact.
    pub fact: Fact,
    /// True if it holds in the second state.
    pub now_holds: bool,
}

/// Returns the facts with a state word that differ between two states, sorted.
pub fn differences(domain: &Domain, before: &State, after: &State) -> Vec<Difference> {
    let mut predicates: Vec<PredicateId> = domain.states.iter().map(|word| word.atom.predicate).collect();
    predicates.sort_unstable();
    predicates.dedup();
    let mut all: Vec<Difference> = Vec::new();
    for predicate in predicates {
        for (from, to, now_holds) in [(before, after, false), (after, before, true)] {
            let changed = from.of_predicate(predicate).iter().filter(|fact| !to.holds(**fact));
            all.extend(changed.map(|fact| Difference { fact: *fact, now_holds }));
        }
    }
    all.sort_unstable();
    all
}

/// Returns all facts that differ between two states, those without a state word included, sorted.
pub fn changed_facts(before: &State, after: &State) -> Vec<Difference> {
    let gone = before.iter().filter(|fact| !after.holds(*fact));
    let new = after.iter().filter(|fact| !before.holds(*fact));
    let of = |now_holds: bool| move |fact: Fact| Difference { fact, now_holds };
    let mut all: Vec<Difference> = gone.map(of(false)).chain(new.map(of(true))).collect();
    all.sort_unstable();
    all
}
