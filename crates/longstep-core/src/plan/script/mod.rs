//! Plans in the paper's Python form: calls, `if`, `while`, `for`, and comments that say what each step does.
//!
//! A script is read by a parser of our own and never executed. It knows the few forms that a plan can have; whatever
//! else Python has is refused, with its place and what can be written instead.
//!
//! ```
//! use longstep_core::plan::{Node, script};
//! let text = "grasp_object()  # take the milk\nif not check_date():\n    throw_away()\n";
//! let written = script::read(text).unwrap();
//! assert_eq!(written.steps[0].explanation, "take the milk");
//! assert!(matches!(written.body[..], [Node::Step(_), Node::If { .. }]));
//! assert_eq!(script::write(&written), text);
//!
//! let error = script::read("milk = grasp_object()").unwrap_err();
//! assert_eq!(error.to_string(), "line 1, column 6: this is an assignment, which no plan has");
//! ```

mod parse;
#[cfg(test)]
mod tests;
mod token;
mod write;

use std::ops::Range;

pub use write::write;

use super::Written;
use crate::diagnostic::Position;

/// Longer texts are no plans: as for replies.
const LARGEST: usize = 1 << 20;

/// Why a script is no plan.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {}, column {}: {message}", .position.line, .position.column)]
pub struct ScriptError {
    /// Where.
    pub position: Position,
    /// What stands there.
    pub message: String,
    /// What can be written instead.
    pub hint: String,
}

/// What is wrong at a byte of the text; its line and column are counted once it is told.
#[derive(Debug)]
struct Fault {
    at: usize,
    message: String,
    hint: String,
}

fn fault<T>(at: usize, message: impl Into<String>, hint: impl Into<String>) -> Result<T, Fault> {
    Err(Fault {
        at,
        message: message.into(),
        hint: hint.into(),
    })
}

/// Reads a script: all of the text, or the one code block that it consists of. All of it may be indented.
///
/// # Errors
///
/// At the first thing that a plan cannot have.
pub fn read(text: &str) -> Result<Written, ScriptError> {
    let inside = fenced(text).unwrap_or(0..text.len());
    read_part(text, inside)
}

/// Reads the script in a part of a text; places are those in the whole text.
pub(super) fn read_part(text: &str, part: Range<usize>) -> Result<Written, ScriptError> {
    let read = match part.len() {
        0..=LARGEST => token::tokens(text, part).and_then(parse::plan),
        length => fault(
            part.start,
            format!("this is {length} bytes long, and at most {LARGEST} are read"),
            "split the plan",
        ),
    };
    read.map_err(|Fault { at, message, hint }| ScriptError {
        position: Position::of(text, at),
        message,
        hint,
    })
}

/// What stands between the fences of a text that is one code block.
fn fenced(text: &str) -> Option<Range<usize>> {
    const FENCE: &str = "```";
    let opened = text.len() - text.trim_start().len();
    if !text[opened..].starts_with(FENCE) {
        return None;
    }
    let start = opened + text[opened..].find('\n')? + 1;
    let end = start + text[start..].rfind(FENCE)?;
    text[end + FENCE.len()..].trim().is_empty().then_some(start..end)
}
