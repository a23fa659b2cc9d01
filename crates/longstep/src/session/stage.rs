//! The states of a session and the inputs that they need.

use super::Ended;
use super::asking::Asking;
use super::ended::Left;
use crate::dialogue::{Prepared, Round, Usage};
use crate::goal::Goal;
use crate::report::Answer;
use crate::verify::{Purpose, VerifiedPlan};

/// The next input that a session needs.
#[derive(Debug, Clone, PartialEq)]
pub enum Need {
    /// An instruction.
    Instruction,
    /// A model's reply to this request.
    Model(Box<Prepared>),
    /// The person's answer to this question.
    Answer(String),
    /// A decision on [`proposal`](super::Session::proposal): acceptance or feedback.
    Decision,
    /// The ending of the last accepted plan, one of these; [`ended`](super::Session::ended) takes its index.
    Ending(Vec<Ended>),
    /// Another instruction or feedback; [`stuck`](super::Session::stuck) returns the reason.
    Help,
}

/// A verified plan that waits for the person's decision.
#[derive(Debug, Clone)]
pub struct Proposal {
    /// The plan.
    pub plan: VerifiedPlan,
    /// Its purpose.
    pub purpose: Purpose,
    /// Its goal, if it has one.
    pub goal: Option<Goal>,
    /// The answer for people and programs.
    pub answer: Answer,
    /// Reasons why the last feedback was refused; empty if it was fulfilled.
    pub refused: Vec<String>,
}

/// Reason why an instruction led to no plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Stuck {
    /// The reason, in one sentence.
    pub why: String,
    /// The answer with the invalid plan or without a plan; none if the reply could not be parsed.
    pub answer: Option<Box<Answer>>,
    /// The category of the reason.
    pub trouble: Trouble,
}

/// A category of failure, which decides the exit code of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trouble {
    /// No valid plan; see the answer.
    Plan,
    /// A limit on tokens or rounds.
    Limit,
    /// The model call failed, or its reply is unusable.
    Model,
}

/// One instruction until its plan is accepted.
#[derive(Debug, Clone)]
pub(super) struct Turn {
    pub(super) instruction: String,
    /// The model's replies and the feedback on them.
    pub(super) rounds: Vec<Round>,
    /// Number of corrections sent to the model.
    pub(super) corrections: u32,
    pub(super) usage: Usage,
    pub(super) model_milliseconds: f64,
    /// The plan that feedback refers to.
    pub(super) proposal: Option<Box<Proposal>>,
    /// While feedback is read as a further goal: what stands in the way of it as a change of the steps.
    pub(super) rereading: Option<Vec<String>>,
}

/// The state of a session.
#[derive(Debug, Clone)]
pub(super) enum Stage {
    Idle,
    Asking(Turn, Asking),
    /// The model's reply, and its question.
    Question(Turn, String, String),
    /// The turn has a proposed plan.
    Proposed(Turn),
    Stuck(Turn, Stuck),
    /// The accepted plan has several endings.
    Ending(Vec<Left>),
}

/// An input that the session cannot accept in its current state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{what} does not fit here: the session {state}")]
pub struct OutOfTurn {
    pub(super) what: &'static str,
    pub(super) state: &'static str,
}
