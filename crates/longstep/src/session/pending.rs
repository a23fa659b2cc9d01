//! A request that a model has not answered yet.

use super::Turn;
use crate::feedback::FeedbackDialogue;
use crate::understanding::FittedUnderstanding;

/// A pending model request.
#[derive(Debug, Clone)]
pub(super) struct Asking {
    pub(super) what: What,
    /// True if the log contains the request.
    pub(super) logged: bool,
}

#[derive(Debug, Clone)]
pub(super) enum What {
    /// The meaning of what was said. The request starts when the token budget is known.
    Meaning(Option<Box<FittedUnderstanding>>),
    /// A whole plan.
    Plan,
    /// The interpretation of feedback on a plan.
    Wish(Box<FeedbackDialogue>, String),
}

impl Asking {
    pub(super) fn new(what: What) -> Self {
        Self { what, logged: false }
    }

    /// Returns true for the first request of an instruction, as long as no model has it.
    pub(super) fn is_first_of(&self, turn: &Turn) -> bool {
        let begins = matches!(self.what, What::Meaning(None) | What::Plan);
        begins && !self.logged && turn.is_unanswered()
    }
}
