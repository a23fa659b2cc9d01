//! The successor world: the world after a plan, in which the next instruction is given.

use std::sync::Arc;

use super::statement::is_stated;
use super::write;
use crate::model::{Ending, Fact, State, World, changed_facts, state_word};

impl World {
    /// Returns the world after a plan with this ending.
    ///
    /// Facts that an environment can express, and numbers, are those of the ending. All others are those of the initial state: static
    /// knowledge remains (an emptied crate is still a container), and facts that matter only during a plan (the
    /// position of the hand, events) are reset. The result is the world read from the written environment, plus the
    /// knowledge from the first one. Prohibitions of the instruction end with it; standing ones stay in force.
    #[must_use]
    pub fn after(&self, ending: &Ending) -> Self {
        self.successor(&ending.after, ending.trace.changes().iter().map(|change| change.fact))
    }

    /// Returns the world in which the next instruction is given if the world is in this state now, after the steps of a
    /// robot or an observation. Facts stay or are reset as by [`World::after`].
    #[must_use]
    pub fn after_state(&self, state: &State) -> Self {
        let changed = changed_facts(&self.state, state);
        self.successor(state, changed.into_iter().map(|own| own.fact))
    }

    fn successor(&self, after: &State, changed: impl Iterator<Item = Fact>) -> Self {
        let domain = self.domain();
        let states_facts = self.environment().facts.is_some();
        let is_expressible =
            |predicate| state_word(domain, predicate).is_some() || states_facts && is_stated(domain, predicate);
        let mut next = self.clone();
        next.environment = Arc::new(write(self, after));
        let before = self.state.iter().filter(|fact| is_expressible(fact.predicate()));
        for fact in before.filter(|fact| !after.holds(*fact)) {
            next.state.set(fact, false);
        }
        for fact in after.iter().filter(|fact| is_expressible(fact.predicate())) {
            next.state.set(fact, true);
        }
        // A fact that has changed is no longer assumed.
        for (fluent, number) in after.numbers() {
            next.state.set_number(*fluent, *number);
        }
        for fact in changed {
            Arc::make_mut(&mut next.assumed).remove(&fact);
        }
        next.with_standing_prohibitions()
    }
}
