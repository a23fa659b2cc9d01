//! Result of a search.

use crate::model::Fact;
use crate::plan::Plan;

/// Result of a search.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// A plan.
    Solved {
        /// Steps and branches; a plain list where nothing has to be sensed.
        plan: Plan,
        /// Steps in the worst case, loops gone through once.
        worst: u32,
        /// True if it is proven that no plan has a better worst case.
        shortest: bool,
        /// States expanded.
        expanded: usize,
    },
    /// There is no plan that does whatever sensing tells.
    ProvenUnsolvable {
        /// Outcome of sensing with which there is no plan, if one is to blame; none if there is no plan whatever the
        /// outcomes.
        when: Option<Fact>,
        /// States expanded.
        expanded: usize,
    },
    /// There may be a plan, and it was not found.
    GaveUp {
        /// Why.
        why: String,
        /// States expanded.
        expanded: usize,
    },
}

impl Outcome {
    /// Returns how many states were expanded.
    pub fn expanded(&self) -> usize {
        match self {
            Self::Solved { expanded, .. } | Self::ProvenUnsolvable { expanded, .. } | Self::GaveUp { expanded, .. } => {
                *expanded
            }
        }
    }
}
