//! Reasons why a plan cannot be changed as a person wishes.

use crate::plan::Violation;

/// Something that stands in the way of a change of the steps. `Display` gives it in one sentence.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Obstacle {
    /// The plan has no step with this index.
    #[error("the plan has no step {}", .0 + 1)]
    NoSuchStep(usize),
    /// A violation of the plan with the change. Its step numbers are those of that plan.
    #[error("{message}")]
    Violation {
        /// The violation.
        violation: Violation,
        /// The violation in a sentence.
        message: String,
    },
    /// Changing the other steps to fit gives the plan without the change.
    #[error("with the rest of the plan changed to fit, it would be the plan as it is")]
    Unchanged,
    /// The change requires this number of other changes, too many for the same plan.
    #[error("it would take {0} other changes of the plan")]
    TooManyChanges(usize),
    /// The search for other changes reached this limit.
    #[error("there may be a way around this that was not found: {0}")]
    GaveUp(String),
}

impl Obstacle {
    /// The step that the obstacle is about, in the plan with the change.
    pub fn step(&self) -> Option<usize> {
        match self {
            Self::Violation { violation, .. } => violation.step(),
            _ => None,
        }
    }
}
