//! Reasons why an instruction leads to no plan, or feedback to no other one.

use std::fmt;

use crate::dialogue::{DialogueError, PromptError};
use crate::feedback::Obstacle;
use crate::report::Answer;

/// The reason why an instruction led to no plan. `Display` gives it in one sentence.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// The plan is invalid, or there is none; see the answer.
    #[error("{}", .0.sentence())]
    NoPlan(Box<Answer>),
    /// The prompt cannot be rendered, or exceeds the model's context.
    #[error(transparent)]
    Prompt(PromptError),
    /// The model's reply is unusable.
    #[error(transparent)]
    Reply(DialogueError),
    /// The model repeated the plan that the person wants changed.
    #[error("the model's plan is the same as before")]
    SamePlan,
    /// The call of the model failed; the text is the caller's.
    #[error("{0}")]
    Model(String),
}

impl Failure {
    /// The answer with the invalid plan or without a plan; none if no plan was considered.
    pub fn answer(&self) -> Option<&Answer> {
        match self {
            Self::NoPlan(answer) => Some(answer),
            _ => None,
        }
    }

    /// Returns true if a limit on tokens was reached.
    pub fn is_limit(&self) -> bool {
        matches!(self, Self::Prompt(_) | Self::Reply(DialogueError::CutOff(_)))
    }
}

/// A reason why feedback was refused. The proposed plan stays. `Display` gives it in one sentence.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Refusal {
    /// Something stands in the way of the change of the steps.
    Change(Obstacle),
    /// The feedback led to no plan.
    Failure(Failure),
    /// The feedback, read as a goal beside those of the plan, led to no plan.
    FurtherGoal(Failure),
    /// The feedback, read as a goal beside those of the plan, leaves a question open.
    OpenQuestion(String),
    /// The feedback names no goal beside those of the plan.
    NoFurtherGoal,
    /// The reason in a log of an older program.
    Recorded(String),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Change(obstacle) => obstacle.fmt(f),
            Self::Failure(failure) => failure.fmt(f),
            Self::FurtherGoal(failure) => write!(f, "as a further goal: {failure}"),
            Self::OpenQuestion(question) => write!(f, "as a further goal: {question}"),
            Self::NoFurtherGoal => f.write_str("as a further goal: the words name none"),
            Self::Recorded(why) => f.write_str(why),
        }
    }
}
