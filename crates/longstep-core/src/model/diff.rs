//! What differs between two states of a world.

use super::{Domain, Fact, PredicateId, State};

/// A fact that holds in one state and not in the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Difference {
    /// The fact.
    pub fact: Fact,
    /// Whether it holds in the second state.
    pub now_holds: bool,
}

/// What an environment would show as changed between two states, sorted: facts that have a state word.
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
