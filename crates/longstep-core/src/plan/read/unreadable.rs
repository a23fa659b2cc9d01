//! Errors for replies that contain no readable plan.

use crate::diagnostic::Position;
use crate::json::Path;
use crate::plan::{ScriptError, TreeError};

/// Maximum length of a reply in bytes. The longest recorded reply has fewer than 4,000.
pub(super) const LARGEST: usize = 1 << 20;

/// Reasons why a reply contains no readable plan. The reader never completes a plan and never chooses between plans.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unreadable {
    /// The reply is empty.
    #[error("the reply is empty")]
    Empty,
    /// The reply is too long.
    #[error("the reply has {bytes} bytes; at most {limit} are read")]
    TooLarge {
        /// Length of the reply.
        bytes: usize,
        /// Maximum length.
        limit: usize,
    },
    /// Brackets are nested too deep.
    #[error("{}: brackets are nested more than {limit} deep", at(.position))]
    TooDeep {
        /// Position of the first bracket beyond the limit.
        position: Position,
        /// Maximum depth.
        limit: usize,
    },
    /// The reply is only prose: a refusal, a question, or conversation.
    #[error("the reply is prose, with no plan in it: \"{text}\"")]
    Refusal {
        /// Beginning of the reply.
        text: String,
    },
    /// The reply contains objects, but none is a plan.
    #[error("{}: the reply holds an object but no plan", at(.first))]
    NoPlan {
        /// Position of the first object.
        first: Position,
    },
    /// The reply is truncated.
    #[error("{}: the reply breaks off; the object that begins at {} does not end", at(.position), at(.opened))]
    CutOff {
        /// Position where the object breaks off.
        position: Position,
        /// Position where the object begins.
        opened: Position,
    },
    /// The reply contains plans that differ.
    #[error("the reply holds {count} plans that are not the same, at {} and {}", at(.first), at(.other))]
    SeveralPlans {
        /// Number of plans, including repeated ones.
        count: usize,
        /// Position of the first plan.
        first: Position,
        /// Position of the first plan that differs from it.
        other: Position,
    },
    /// The plan is neither JSON nor a Python literal.
    #[error("{}: {message}", at(.position))]
    Malformed {
        /// Position of the error.
        position: Position,
        /// Description of the error.
        message: String,
    },
    /// A value has the wrong type.
    #[error("{}: `{path}` should be {expected}, but is {found}", at(.position))]
    WrongShape {
        /// Path of the value.
        path: Path,
        /// Position of the value, or of the object where the value is missing.
        position: Position,
        /// Expected type.
        expected: &'static str,
        /// Actual type.
        found: &'static str,
    },
    /// A `task_tree` is invalid.
    #[error("{}: {error}", at(.position))]
    Tree {
        /// Position of the tree.
        position: Position,
        /// The error in the tree.
        error: TreeError,
    },
    /// A script contains something that plans do not allow.
    #[error("{}{error}", within(.inside))]
    Script {
        /// Position of the JSON string that contains the script; none if the script is not inside JSON.
        inside: Option<Position>,
        /// The error, with its position in the script, or in the reply if the script is not inside JSON.
        error: ScriptError,
    },
    /// A key occurs twice with different values.
    #[error("{}: `{path}` is given again with another value than at {}", at(.position), at(.first))]
    Contradiction {
        /// Path of the key.
        path: Path,
        /// Position of the first occurrence.
        first: Position,
        /// Position of the second occurrence.
        position: Position,
    },
}

impl Unreadable {
    /// Suggests a remedy in one sentence.
    pub fn hint(&self) -> &str {
        match self {
            Self::Empty => "ask again; if it stays empty, look at the model's token limit and content filter",
            Self::TooLarge { .. } | Self::TooDeep { .. } => "ask again for the plan alone",
            Self::Refusal { .. } => "show what it says to the person, or ask again for the plan as one JSON object",
            Self::NoPlan { .. } => "ask again for an object with `task_cohesion` and its `task_sequence`",
            Self::CutOff { .. } => "raise the limit on the length of the answer, or ask for fewer steps at a time",
            Self::SeveralPlans { .. } => "ask which of the plans is meant, or ask again for one object",
            Self::Malformed { .. } => "ask again for strict JSON, and say what is wrong",
            Self::WrongShape { .. } => "ask again, and say what the value should be",
            Self::Tree { .. } => "ask again for a tree as docs/schema/plan.schema.json has it, and say what is wrong",
            Self::Script { error, .. } => &error.hint,
            Self::Contradiction { .. } => "ask again, and say that every key may stand there once",
        }
    }
}

fn within(inside: &Option<Position>) -> String {
    inside.map_or_else(String::new, |position| {
        format!("{}: in `python_script`, ", at(&position))
    })
}

fn at(position: &Position) -> String {
    format!("line {}, column {}", position.line, position.column)
}
