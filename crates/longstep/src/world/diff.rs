//! What differs between two states of a world.

use super::{Fact, State};
use crate::domain::Domain;

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
    let written = |fact: &Fact| domain.states.iter().any(|s| s.atom.predicate == fact.predicate());
    let mut all: Vec<Difference> = Vec::new();
    for (from, to, now_holds) in [(before, after, false), (after, before, true)] {
        let changed = from
            .sorted()
            .into_iter()
            .filter(|fact| !to.holds(*fact) && written(fact));
        all.extend(changed.map(|fact| Difference { fact, now_holds }));
    }
    all.sort_unstable();
    all
}
