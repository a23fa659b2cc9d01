//! Result of a search.

use longstep_model::model::{Fact, Number};
use longstep_verify::plan::Plan;

/// Result of a search.
///
/// Exhaustive on purpose: code that does not know a new outcome would be wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// A plan was found.
    Solved {
        /// The plan; sequential if nothing has to be sensed.
        plan: Plan,
        /// Number of steps in the worst case, with one iteration of each loop.
        worst: u32,
        /// Cost of the steps in the worst case, with one iteration of each loop; none in a domain without costs.
        cost: Option<Number>,
        /// True if it is proven that no plan has a better worst case: in a domain with costs a lower cost, in others fewer
        /// steps.
        shortest: bool,
        /// Proven lower bound on the worst case of all plans; 0 if none is known.
        at_least: u32,
        /// States expanded.
        expanded: usize,
    },
    /// No plan works for all sensing outcomes.
    ProvenUnsolvable {
        /// The sensing outcome after which there is no plan; none if there is no plan for any outcomes.
        when: Option<Fact>,
        /// States expanded.
        expanded: usize,
    },
    /// No plan was found; one may exist.
    GaveUp {
        /// The limit that was reached.
        why: String,
        /// States expanded.
        expanded: usize,
    },
}

impl Outcome {
    /// Returns the number of expanded states.
    pub fn expanded(&self) -> usize {
        match self {
            Self::Solved { expanded, .. } | Self::ProvenUnsolvable { expanded, .. } | Self::GaveUp { expanded, .. } => {
                *expanded
            }
        }
    }
}
