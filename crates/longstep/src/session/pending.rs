//! A request that a model has not answered yet.

use super::Turn;
use crate::coverage::Mark;
use crate::dialogue::{
    FittedDialogue, GoalDialogue, MessageDialogue, RetellingDialogue, ScreeningDialogue, SplittingDialogue, Weighing,
};
use crate::feedback::FeedbackDialogue;

/// A pending model request.
#[derive(Debug, Clone)]
pub(super) struct Asking {
    pub(super) what: What,
    /// True if the log contains the request.
    pub(super) logged: bool,
}

#[derive(Debug, Clone)]
pub(super) enum What {
    /// The marks of the instruction, before the goal.
    Screening(Box<ScreeningDialogue>),
    /// The question whether somebody is to be told something, after a screening with these marks.
    Message(Box<MessageDialogue>, Vec<Mark>),
    /// The instruction in plain English, after its own words led to a question.
    Retelling(Box<RetellingDialogue>),
    /// The parts of an instruction that forbids something.
    Splitting(Box<SplittingDialogue>),
    /// A goal. The dialogue starts when the token budget is known.
    Goal(Option<Box<FittedDialogue>>),
    /// The likelihoods of answers, after a retelling.
    Weighing(Box<Weighed>),
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
        let begins = matches!(self.what, What::Screening(_) | What::Goal(None) | What::Plan);
        begins && !self.logged && turn.is_unanswered() && turn.retold.is_none() && turn.parted.is_none()
    }
}

/// Answers that are being weighed.
#[derive(Debug, Clone)]
pub(super) struct Weighed {
    pub(super) weighing: Weighing,
    /// The wording of the last request, with its dialogue.
    pub(super) dialogue: Option<(String, Box<GoalDialogue>)>,
}
