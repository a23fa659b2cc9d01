//! A plan as it was written, whichever notation it came in: the JSON tree and the script say the same.

use super::tree::{self, Node};
use crate::call::Call;

/// A plan as it was written: its steps in reading order, and the tree over them.
///
/// What stands in conditions is not among the steps: whether a call there senses something or asks what is known
/// already is only said by a domain. See [`super::resolve`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Written {
    /// The steps, without those in conditions.
    pub steps: Vec<WrittenStep>,
    /// The tree over them. All calls of a condition stand under [`super::Test::Holds`].
    pub body: Vec<WrittenNode>,
    /// What the plan says is handled, where calls do not say.
    pub objects: Vec<String>,
}

/// A part of a plan as it was written.
pub type WrittenNode = Node<WrittenStep, String>;

/// A call as it was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenStep {
    /// The call, with the arguments that it shows.
    pub call: Call,
    /// Hidden parameters that are given all the same, by name.
    pub implicit: Vec<(String, String)>,
    /// What the step does; empty if the plan does not say.
    pub explanation: String,
}

impl Written {
    /// Whether it is a list of steps, with nothing but remarks between them.
    pub fn is_sequence(&self) -> bool {
        let flat = |node: &WrittenNode| matches!(node, Node::Step(_) | Node::Remark(_));
        self.body.iter().all(flat)
    }

    /// Whether every step stands in the tree once, in reading order, and nothing stands too deep.
    pub fn is_sound(&self) -> bool {
        tree::is_sound(&self.body, self.steps.len())
    }
}

/// Words that mean something by themselves in the script, so that no action is called so.
const RESERVED: [&str; 43] = [
    "False", "None", "True", "and", "as", "assert", "async", "await", "break", "case", "class", "continue", "def",
    "del", "elif", "else", "except", "finally", "for", "from", "global", "if", "import", "in", "is", "lambda", "lane",
    "match", "nonlocal", "not", "or", "parallel", "pass", "print", "raise", "range", "return", "sync", "try", "type",
    "while", "with", "yield",
];

/// Whether the script keeps this word for itself.
pub(super) fn is_reserved(word: &str) -> bool {
    RESERVED.contains(&word)
}

/// Whether a character can stand in the name of a call or a parameter.
pub(super) fn in_name(character: char) -> bool {
    character.is_alphanumeric() || matches!(character, '_' | '-')
}

/// Whether both notations can write this as the name of a call or a parameter.
pub(super) fn is_name(text: &str) -> bool {
    text.chars().all(in_name) && text.starts_with(|first: char| first.is_alphabetic() || first == '_')
}

/// Whether both notations can write this as an argument.
pub(super) fn is_argument(text: &str) -> bool {
    let odd = |character: char| matches!(character, ',' | '(' | ')') || character.is_control();
    !text.is_empty() && text.trim() == text && !text.contains(odd)
}
