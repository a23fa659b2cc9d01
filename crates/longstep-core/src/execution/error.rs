//! The errors of executions.

use crate::autonomy::Refusal;
use longstep_model::environment::ObservationError;
use longstep_search::goal::GoalError;
use longstep_verify::cursor::CursorError;
use longstep_verify::plan::StepId;
use longstep_verify::skill::MissingSkill;

/// A plan that cannot be carried out. Nothing has moved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BeginError {
    /// The goal cannot be read.
    #[error(transparent)]
    Goal(#[from] GoalError),
    /// The plan does not achieve the purpose, or breaks a constraint of it: the violations as sentences.
    #[error("the plan does not achieve its purpose: {}", .0.join("; "))]
    Purpose(Vec<String>),
    /// Steps that a person has to teach first, in order; at least one.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Untaught(Vec<MissingSkill>),
    /// Steps of the plan, and values of the goal, that the levels and limits of the robot refuse; at least one.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Refused(Vec<RefusedPart>),
    /// Forbidden places that the world does not have, by the names in the limits; at least one.
    #[error("the limits forbid places that the environment does not list: {}", .0.join(", "))]
    UnknownPlaces(Vec<String>),
}

/// A step or a goal that the levels and limits of the robot refuse.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct RefusedPart {
    /// The step with its action and arguments; none for the goal.
    pub step: Option<(StepId, String)>,
    /// The reason.
    pub refusal: Refusal,
}

impl std::fmt::Display for RefusedPart {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.step {
            Some((step, call)) => write!(formatter, "step {} `{call}`: {}", step.index() + 1, self.refusal),
            None => write!(formatter, "the goal: {}", self.refusal),
        }
    }
}

/// An input that does not fit the state of the execution, which is unchanged.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ExecutionError {
    /// No order with this number is under way.
    #[error("no order {0} is under way")]
    UnknownOrder(u64),
    /// The outcome of a sensing step is missing, or is none of its outcomes.
    #[error(transparent)]
    Outcome(#[from] CursorError),
    /// An observation that cannot be read.
    #[error(transparent)]
    Observation(#[from] ObservationError),
    /// The decision is about a proposal that no longer waits for one.
    #[error("the decision is about another proposal than the one that waits for it")]
    AnotherProposal,
    /// Nothing waits for a decision.
    #[error("nothing waits for a decision")]
    NothingProposed,
    /// The execution has ended.
    #[error("the execution has ended")]
    Ended,
}
