//! Errors for replies that contain no readable plan.

use crate::plan::{ScriptError, TreeError};
use longstep_model::diagnostic::Position;
use longstep_model::json::Path;

/// Maximum length of a reply in bytes. The longest recorded reply has fewer than 4,000.
pub(super) const LARGEST: usize = 1 << 20;

/// The notations in which plans are read, as a hint for a text in none of them.
const NOTATIONS_READ: &str = "a plan is JSON or a Python literal with `task_cohesion`, a list of calls or of objects with `action` under \
    `plan` or `steps`, tool calls, YAML, a script, a list or table of calls such as `Open(<fridge>)`, a VirtualHome script, or what a planner \
    prints (docs/reference/verification.md)";

/// The hint for prose, which may be a refusal.
const PROSE: &str = "show what it says to the person, or ask again: a plan is JSON, YAML, a script, or a list of calls such as \
    `Open(<fridge>)` (docs/reference/verification.md)";

/// Reasons why a reply contains no readable plan. The reader never completes a plan and never chooses between plans.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unreadable {
    /// The reply is empty.
    #[error("the text is empty")]
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
    /// The reply can be read in two notations, with different plans.
    #[error("the reply can be read in two ways that are not the same: as {} at {}, and as {} at {}", .first, at(.position), .other, at(.other_position))]
    SeveralReadings {
        /// The first notation.
        first: &'static str,
        /// Position of the plan in the first notation.
        position: Position,
        /// The other notation.
        other: &'static str,
        /// Position of the plan in the other notation.
        other_position: Position,
    },
    /// An entry of a list of steps is no step.
    #[error("{}: this is no step, unlike what is listed beside it: \"{text}\"", at(.position))]
    NoStep {
        /// Position of the entry.
        position: Position,
        /// Beginning of the entry.
        text: String,
    },
    /// The words around steps have a call that is none of them.
    #[error("{}: `{call}` stands outside of the steps of the plan and is none of them", at(.position))]
    StrayCall {
        /// Position of the call.
        position: Position,
        /// The call, or its beginning.
        call: String,
    },
    /// A server says that the answer was cut off.
    #[error("{}: the server says that this answer is not whole: `{key}` is `{reason}`", at(.position))]
    NotWhole {
        /// Position of the value.
        position: Position,
        /// The key of the reason.
        key: String,
        /// The reason.
        reason: String,
    },
    /// A text inside of the reply has a plan that cannot be read.
    #[error("{}: in {}, {error}", at(.position), text_at(.path))]
    Inside {
        /// Position of the text.
        position: Position,
        /// Path of the text.
        path: Path,
        /// The error, with its position in the text.
        error: Box<Unreadable>,
    },
    /// The reply ends before its thoughts do, or has nothing else.
    #[error("the reply has thoughts only, and no answer behind them")]
    OnlyThoughts,
    /// The text is in a notation that has plans and is not read.
    #[error("this is {what}, which is not read as a plan")]
    Foreign {
        /// The notation.
        what: &'static str,
    },
    /// The plan is neither JSON nor a Python literal.
    #[error("{}: {message}", at(.position))]
    Malformed {
        /// Position of the error.
        position: Position,
        /// Description of the error.
        message: String,
    },
    /// A behavior tree has what no plan has.
    #[error("{}: {message}", at(.position))]
    BehaviorTree {
        /// Position of the node.
        position: Position,
        /// Description of the error.
        message: String,
        /// The alternative that a plan can have.
        hint: String,
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
    /// Returns true if the reply has steps, and what is wrong is which of them are the plan.
    pub fn has_steps(&self) -> bool {
        match self {
            Self::CutOff { .. }
            | Self::SeveralPlans { .. }
            | Self::SeveralReadings { .. }
            | Self::NoStep { .. }
            | Self::StrayCall { .. }
            | Self::NotWhole { .. } => true,
            Self::Inside { error, .. } => error.has_steps(),
            _ => false,
        }
    }

    /// Suggests a remedy in one sentence.
    pub fn hint(&self) -> &str {
        match self {
            Self::Empty => "if a model wrote it, ask again, and look at its token limit and content filter",
            Self::TooLarge { .. } | Self::TooDeep { .. } => "ask again for the plan alone",
            Self::Refusal { .. } => PROSE,
            Self::NoPlan { .. } | Self::Foreign { .. } => NOTATIONS_READ,
            Self::OnlyThoughts => "raise the limit on the length of the answer, or turn the model's thinking off",
            Self::SeveralReadings { .. } => "keep the plan that is meant, and take the other out",
            Self::NoStep { .. } => "write a call of an action there, as in `Open(<fridge>)`, or take the entry out",
            Self::StrayCall { .. } => "write it as a step on a line of its own, or take it out",
            Self::Inside { error, .. } => error.hint(),
            Self::CutOff { .. } | Self::NotWhole { .. } => {
                "raise the limit on the length of the answer, or ask for fewer steps at a time"
            }
            Self::SeveralPlans { .. } => "ask which of the plans is meant, or put all steps into one list",
            Self::Malformed { .. } => "ask again for strict JSON, and say what is wrong",
            Self::WrongShape { .. } => "ask again, and say what the value should be",
            Self::Tree { .. } => "ask again for a tree as schemas/plan.schema.json has it, and say what is wrong",
            Self::Script { error, .. } => &error.hint,
            Self::BehaviorTree { hint, .. } => hint,
            Self::Contradiction { .. } => "ask again, and say that every key may stand there once",
        }
    }
}

fn text_at(path: &Path) -> String {
    match path.to_string().as_str() {
        "" => "the text in quotes".to_owned(),
        path => format!("`{path}`"),
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
