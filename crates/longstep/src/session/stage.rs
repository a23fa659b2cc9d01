//! Where a session is, and what it needs there.

use super::Ended;
use super::asking::Asking;
use super::ended::Left;
use crate::dialogue::{Prepared, Round, Usage};
use crate::goal::Goal;
use crate::report::{Answer, Status};
use crate::verify::{Purpose, VerifiedPlan};

/// What a session needs now.
#[derive(Debug, Clone, PartialEq)]
pub enum Need {
    /// A person's instruction.
    Instruction,
    /// A model's reply to this request.
    Model(Box<Prepared>),
    /// A person's answer to this question.
    Answer(String),
    /// A look at [`proposal`](super::Session::proposal): accept it, or say what is to be different.
    Decision,
    /// Which of these ways the plan that was accepted last ended in: [`ended`](super::Session::ended) takes its number.
    Ending(Vec<Ended>),
    /// Other words: [`stuck`](super::Session::stuck) tells why nothing came of the instruction.
    Help,
}

/// A verified plan that waits for a person's word.
#[derive(Debug, Clone)]
pub struct Proposal {
    /// The plan.
    pub plan: VerifiedPlan,
    /// What it is for.
    pub purpose: Purpose,
    /// The goal that it was made for, if it was made for one.
    pub goal: Option<Goal>,
    /// The same as everybody is answered.
    pub answer: Answer,
    /// What the person asked for last and cannot have, and why; empty if they have it.
    pub refused: Vec<String>,
}

/// Why nothing came of an instruction.
#[derive(Debug, Clone, PartialEq)]
pub struct Stuck {
    /// In one sentence.
    pub why: String,
    /// The plan that is not valid, or that there is none; missing where a reply could not be read at all.
    pub answer: Option<Box<Answer>>,
    /// What kind of trouble it is.
    pub trouble: Trouble,
}

/// A kind of trouble, which decides the exit code of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trouble {
    /// No plan, or none that is valid: the answer tells.
    Plan,
    /// A limit of tokens or rounds.
    Limit,
    /// The model did not answer, or its reply cannot be used.
    Model,
}

/// One instruction, from its words to an accepted plan.
#[derive(Debug, Clone)]
pub(super) struct Turn {
    pub(super) instruction: String,
    /// What the model replied and what was said to it then.
    pub(super) rounds: Vec<Round>,
    /// How often it was told what is wrong.
    pub(super) corrections: u32,
    pub(super) usage: Usage,
    pub(super) model_milliseconds: f64,
    /// The plan that the person has words about.
    pub(super) proposal: Option<Box<Proposal>>,
}

/// Where a session is.
#[derive(Debug, Clone)]
pub(super) enum Stage {
    Idle,
    Asking(Turn, Asking),
    /// The reply that asked, and the question in it.
    Question(Turn, String, String),
    /// A plan: the one of the turn.
    Proposed(Turn),
    Stuck(Turn, Stuck),
    /// A plan was accepted that can end in several worlds.
    Ending(Vec<Left>),
}

/// Something that does not fit where the session is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{what} does not fit here: the session {state}")]
pub struct OutOfTurn {
    pub(super) what: &'static str,
    pub(super) state: &'static str,
}

/// Why an answer is not a verified plan, in one sentence.
pub(super) fn sentence(status: Status) -> &'static str {
    match status {
        Status::Verified => "there is a plan",
        Status::Invalid => "the plan is not valid",
        Status::Unsolvable => "no plan can do this",
        Status::GaveUp => "no plan was found within the limits",
        Status::Question => "there is a question",
    }
}
