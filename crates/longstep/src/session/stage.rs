//! The states of a session and the inputs that they need.

use std::fmt;

use super::ended::Left;
use super::pending::Asking;
use super::{Ended, Failure, Refusal};
use crate::dialogue::{Reading, Round, Usage};
use crate::goal::Goal;
use crate::report::Answer;
use crate::verify::{Purpose, VerifiedPlan};

/// The state of a session as the person finds it when no model is to be called.
#[derive(Debug)]
#[non_exhaustive]
pub enum Response<'a> {
    /// No instruction is under way.
    Ready,
    /// A model's reply is awaited; see [`next_request`](super::Session::next_request).
    Waiting,
    /// A verified plan, which waits for acceptance or feedback.
    Plan(&'a Proposal),
    /// A verified plan with a question ([`Proposal::question`]): the plan leaves out a part of the instruction, or it is
    /// empty because the instruction only forbids something. [`accept`](super::Session::accept) answers yes.
    Consent(&'a Proposal),
    /// A question, which waits for an answer.
    Question(&'a str),
    /// There is no plan; another instruction or feedback may follow.
    NoPlan(&'a Failure),
    /// The last accepted plan can end in these ways; [`ended`](super::Session::ended) takes the index of one.
    Endings(Vec<Ended>),
}

impl fmt::Display for Response<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ready => f.write_str("ready for an instruction"),
            Self::Waiting => f.write_str("waiting for the model"),
            Self::Plan(proposal) => write!(f, "a verified plan of {} steps", proposal.plan.steps().len()),
            Self::Consent(proposal) => f.write_str(proposal.question.as_deref().unwrap_or_default()),
            Self::Question(question) => f.write_str(question),
            Self::NoPlan(failure) => failure.fmt(f),
            Self::Endings(endings) => write!(f, "the last plan can have ended in {} ways", endings.len()),
        }
    }
}

/// A verified plan that waits for the person's decision.
#[derive(Debug, Clone)]
#[non_exhaustive]
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
    pub refused: Vec<Refusal>,
    /// The question to answer before the plan counts as what was asked for; see [`Response::Consent`].
    pub question: Option<String>,
}

impl Proposal {
    /// Returns true if the plan does nothing and its constraints are offered as standing rules.
    pub fn offers_rule(&self) -> bool {
        let forbids = |goal: &Goal| goal.facts.is_empty() && !goal.constraints.is_empty();
        self.question.is_some() && self.goal.as_ref().is_some_and(forbids)
    }
}

/// One instruction until its plan is accepted.
#[derive(Debug, Clone)]
pub(super) struct Turn {
    pub(super) instruction: String,
    /// The model's replies and the feedback on them.
    pub(super) rounds: Vec<Round>,
    /// Number of corrections sent to the model.
    pub(super) corrections: u32,
    /// The failure that the pending correction is about.
    pub(super) uncorrected: Option<Box<Failure>>,
    pub(super) usage: Usage,
    pub(super) model_milliseconds: f64,
    /// The plan that feedback refers to.
    pub(super) proposal: Option<Box<Proposal>>,
    /// While feedback is read as a further goal: what stands in the way of it as a change of the steps.
    pub(super) rereading: Option<Vec<Refusal>>,
    /// How the last words of the person were understood.
    pub(super) readings: Vec<Reading>,
}

impl Turn {
    /// Returns true if the person has said nothing but the instruction, and nothing is proposed.
    pub(super) fn is_unanswered(&self) -> bool {
        self.rounds.is_empty() && self.proposal.is_none() && self.rereading.is_none()
    }
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
    Stuck(Turn, Failure),
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
