//! The target of a search: the conditions of a purpose and of the rules.

use longstep_model::model::{Domain, EntityId, Wanted};
use longstep_verify::verify::{Milestone, Purpose};

/// Conditions on the final state and, in order, on the states before it.
#[derive(Debug)]
pub(super) struct Target {
    /// The conditions on the final state, those of the rules included.
    pub(super) wanted: Vec<Wanted>,
    /// The conditions to achieve in order.
    pub(super) stages: Vec<Vec<Milestone>>,
}

impl Target {
    pub(super) fn of(domain: &Domain, purpose: &Purpose) -> Self {
        Self {
            wanted: purpose.at_end(domain),
            stages: purpose.stages.clone(),
        }
    }

    /// Iterates over all conditions.
    pub(super) fn all(&self) -> impl Iterator<Item = &Wanted> {
        let stages = self.stages.iter().flatten();
        self.wanted.iter().chain(stages.map(|milestone| &milestone.wanted))
    }

    /// Iterates over the entities that the conditions are about, possibly repeated.
    pub(super) fn about(&self) -> impl Iterator<Item = EntityId> {
        self.all().flat_map(|wanted| wanted.bindings.iter().copied())
    }
}
