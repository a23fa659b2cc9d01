//! The errors of executions.

use longstep_model::environment::ObservationError;
use longstep_search::goal::GoalError;
use longstep_verify::cursor::CursorError;
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
