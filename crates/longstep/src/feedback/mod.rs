//! What a person says about a plan, and what becomes of the plan then.
//!
//! The words may be about what is wanted ("not that plate, the blue one") or about the steps ("insert another
//! move_object()", "you can omit step 5"). A [`FeedbackDialogue`] has a model tell which, and write a wish about the
//! steps as [`StepWish`]es under a grammar. [`amend`] applies them and verifies what comes out. Where the rest of the
//! plan has to change for it, repair sees to that, around what was asked for; what cannot be had is refused with the
//! facts that stand in the way.

mod amend;
mod apply;
mod dialogue;
mod difference;
mod example;
mod grammar;
mod heard;
mod language;
mod offer;
#[cfg(test)]
mod tests;

pub use crate::model::FeedbackExample;
pub use amend::{Amended, Amendment, amend};
pub use dialogue::{FeedbackDialogue, Wish};
pub use difference::pins;
pub(crate) use example::check_feedback_example;
pub use language::{WishError, parse, written};

use crate::environment::EntityId;
use crate::model::ActionId;

/// One thing that a person wants changed about the steps of a plan. All numbers are those of the plan that the person
/// saw, from 0, whatever else is wished for beside it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StepWish {
    /// A step more.
    Insert {
        /// The step before which it is to stand; the number of steps for the end.
        before: usize,
        /// What it does.
        action: ActionId,
        /// To what, as far as it is known: one entry for each parameter.
        arguments: Vec<Option<EntityId>>,
        /// What it is for, in the person's words; empty for the domain's own sentence.
        explanation: String,
    },
    /// A step less.
    Drop {
        /// Which.
        step: usize,
    },
    /// Another step in its place.
    Replace {
        /// Which.
        step: usize,
        /// What is done instead.
        action: ActionId,
        /// To what, as far as it is known: one entry for each parameter.
        arguments: Vec<Option<EntityId>>,
        /// What it is for, in the person's words; empty for the domain's own sentence.
        explanation: String,
    },
    /// A step at another place.
    Move {
        /// Which.
        step: usize,
        /// The step before which it is to stand; the number of steps for the end.
        before: usize,
    },
}

impl StepWish {
    /// The step of the plan that it takes away from its place, if it does.
    pub fn step(&self) -> Option<usize> {
        match self {
            Self::Insert { .. } => None,
            Self::Drop { step } | Self::Replace { step, .. } | Self::Move { step, .. } => Some(*step),
        }
    }

    /// The step before which it puts something, if it does.
    pub fn before(&self) -> Option<usize> {
        match self {
            Self::Insert { before, .. } | Self::Move { before, .. } => Some(*before),
            Self::Drop { .. } | Self::Replace { .. } => None,
        }
    }
}
