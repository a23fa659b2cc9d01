//! The paper's Python notation for plans: calls, `if`, `while`, `for`, and comments that explain each step.
//!
//! Scripts are parsed and never executed. The parser accepts only the statements that a plan can have. It rejects all
//! other Python with the position and an alternative.
//!
//! ```
//! use longstep_verify::plan::{Node, script};
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
use longstep_model::diagnostic::Position;

/// Maximum length in bytes, the same as for replies.
const LARGEST: usize = 1 << 20;

/// An error in a script.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {}, column {}: {message}", .position.line, .position.column)]
#[non_exhaustive]
pub struct ScriptError {
    /// Position of the error.
    pub position: Position,
    /// The unexpected content.
    pub message: String,
    /// An alternative that is allowed.
    pub hint: String,
}

/// An error with its byte offset; line and column are computed only for the report.
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

/// Parses a script: the whole text, or the single code block that it consists of. The whole script may be indented.
///
/// # Errors
///
/// At the first construct that a plan cannot have.
pub fn read(text: &str) -> Result<Written, ScriptError> {
    let inside = fenced(text).unwrap_or(0..text.len());
    read_part(text, inside)
}

/// Parses the script in a part of a text; positions refer to the whole text.
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

/// Returns the content of a text that is a single code block.
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
