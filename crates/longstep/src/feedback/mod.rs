//! Feedback: utterances about a plan, and the plan's amendment.
//!
//! An utterance concerns the goal ("not that plate, the blue one") or the steps ("insert another move_object()", "you
//! can omit step 5"). A [`FeedbackDialogue`] lets a model decide which, and write changes of the steps as
//! [`StepWish`]es under a grammar. [`amend`] applies the wishes and verifies the result. If other steps must change
//! too, repair changes them and keeps the wishes. An impossible wish is refused with the violations that prevent it.

mod amend;
mod apply;
mod dialogue;
mod difference;
mod example;
mod grammar;
mod language;
mod obstacle;
mod offer;
mod order;
mod reference;
#[cfg(test)]
mod tests;

pub use crate::model::FeedbackExample;
pub use amend::{Amended, Amendment, amend};
pub use dialogue::{FeedbackDialogue, FeedbackInput, Wish};
pub use difference::pins;
pub(crate) use example::check_feedback_example;
pub use language::{WishError, parse, written};
pub use obstacle::Obstacle;
pub(crate) use order::reordered;

use crate::environment::EntityId;
use crate::model::ActionId;

/// A requested change of one step. All indices count from 0 and refer to the original plan, independent of other
/// wishes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StepWish {
    /// Insert a step.
    Insert {
        /// Index of the step to insert before; the number of steps for the end.
        before: usize,
        /// The action.
        action: ActionId,
        /// One argument for each parameter, if known.
        arguments: Vec<Option<EntityId>>,
        /// The explanation; empty for the domain's own sentence.
        explanation: String,
    },
    /// Remove a step.
    Drop {
        /// Index of the step.
        step: usize,
    },
    /// Replace a step.
    Replace {
        /// Index of the step.
        step: usize,
        /// The new action.
        action: ActionId,
        /// One argument for each parameter, if known.
        arguments: Vec<Option<EntityId>>,
        /// The explanation; empty for the domain's own sentence.
        explanation: String,
    },
    /// Move a step.
    Move {
        /// Index of the step.
        step: usize,
        /// Index of the step to move before; the number of steps for the end.
        before: usize,
    },
}

impl StepWish {
    /// Returns the index of the step that the wish removes from its position, if any.
    pub fn step(&self) -> Option<usize> {
        match self {
            Self::Insert { .. } => None,
            Self::Drop { step } | Self::Replace { step, .. } | Self::Move { step, .. } => Some(*step),
        }
    }

    /// Returns the index of the step before which the wish places a step, if any.
    pub fn before(&self) -> Option<usize> {
        match self {
            Self::Insert { before, .. } | Self::Move { before, .. } => Some(*before),
            Self::Drop { .. } | Self::Replace { .. } => None,
        }
    }
}
