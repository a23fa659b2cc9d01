//! Why a reply holds no plan.

use crate::diagnostic::Position;
use crate::json::Path;
use crate::plan::{ScriptError, TreeError};

/// The most bytes that a reply may have. The longest recorded one has under four thousand.
pub(super) const LARGEST: usize = 1 << 20;

/// The deepest that brackets may be nested. A plain plan needs four, a tree two for each level.
pub(super) const DEEPEST: usize = 120;

/// A reply that no plan can be read from. Nothing is ever completed or chosen by guesswork.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Unreadable {
    /// There is nothing in it.
    #[error("the reply is empty")]
    Empty,
    /// It is longer than any plan.
    #[error("the reply has {bytes} bytes; at most {limit} are read")]
    TooLarge {
        /// Its length.
        bytes: usize,
        /// The most that is read.
        limit: usize,
    },
    /// Its brackets are nested deeper than any plan's.
    #[error("{}: brackets are nested more than {limit} deep", at(.position))]
    TooDeep {
        /// The first bracket that is too deep.
        position: Position,
        /// The deepest that is read.
        limit: usize,
    },
    /// It is prose and nothing else: the model refuses, asks, or chats.
    #[error("the reply is prose, with no plan in it: \"{text}\"")]
    Refusal {
        /// How it begins.
        text: String,
    },
    /// There are objects in it, but none is a plan.
    #[error("{}: the reply holds an object but no plan", at(.first))]
    NoPlan {
        /// The first object.
        first: Position,
    },
    /// It stops in the middle.
    #[error("{}: the reply breaks off; the object that begins at {} does not end", at(.position), at(.opened))]
    CutOff {
        /// Where the object stops.
        position: Position,
        /// Where the object begins.
        opened: Position,
    },
    /// It holds plans that differ.
    #[error("the reply holds {count} plans that are not the same, at {} and {}", at(.first), at(.other))]
    SeveralPlans {
        /// How many plans there are, those that are the same included.
        count: usize,
        /// Where the first one begins.
        first: Position,
        /// Where the first one begins that differs from it.
        other: Position,
    },
    /// It is written neither as JSON nor as a Python literal.
    #[error("{}: {message}", at(.position))]
    Malformed {
        /// Where.
        position: Position,
        /// What is wrong.
        message: String,
    },
    /// A value has another type than it must have.
    #[error("{}: `{path}` should be {expected}, but is {found}", at(.position))]
    WrongShape {
        /// The value.
        path: Path,
        /// Where it is, or where the object is that lacks it.
        position: Position,
        /// What it should be.
        expected: &'static str,
        /// What it is.
        found: &'static str,
    },
    /// A tree of steps is not written as one.
    #[error("{}: {error}", at(.position))]
    Tree {
        /// The tree.
        position: Position,
        /// What is wrong in it.
        error: TreeError,
    },
    /// A script has what no plan has.
    #[error("{}{error}", within(.inside))]
    Script {
        /// Where the text of JSON begins that holds the script; none if the reply holds it as it is.
        inside: Option<Position>,
        /// What is wrong, with its place in the script, or in the reply that holds it as it is.
        error: ScriptError,
    },
    /// A key stands there twice and the values differ.
    #[error("{}: `{path}` is given again with another value than at {}", at(.position), at(.first))]
    Contradiction {
        /// The key.
        path: Path,
        /// Where it stands first.
        first: Position,
        /// Where it stands again.
        position: Position,
    },
}

impl Unreadable {
    /// What to do about it, in one sentence.
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
