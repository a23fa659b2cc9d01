//! What a model, or a person, wrote.

use super::request::asks;
use crate::diagnostic::Position;
use crate::dialogue::in_schema;
use crate::plan::{self, Unreadable, Written, script, write_tree};
use serde_json::json;

/// What was said.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Said {
    /// A composition; its calls are not resolved yet.
    Composition(Written),
    /// The person must say more first.
    Question(String),
}

/// Reads a composition: a script, or the same as a JSON tree, alone or as a model puts it.
///
/// ```
/// use longstep::compose::{Said, read};
/// let said = read("fetch_pear()\nif rotten(\"pear\"):\n    compost_pear()\n").unwrap();
/// let Said::Composition(written) = said else { panic!("{said:?}") };
/// assert_eq!(written.steps.len(), 2);
/// assert_eq!(read("question: Which pear?").unwrap(), Said::Question("Which pear?".to_owned()));
/// ```
///
/// # Errors
///
/// When there is no plan in the text, or one that cannot be read.
pub fn read(text: &str) -> Result<Said, Unreadable> {
    if let Some(question) = asks(text) {
        return Ok(Said::Question(question.to_owned()));
    }
    let file = plan::read(text)?.file;
    Ok(match file.question.trim() {
        "" => Said::Composition(file.task_cohesion.written().map_err(|error| Unreadable::Malformed {
            position: Position { line: 1, column: 1 },
            message: error.to_string(),
        })?),
        question => Said::Question(question.to_owned()),
    })
}

/// A script as a server writes it.
pub(super) fn in_json(answer: &str) -> String {
    let (tree, question) = match (asks(answer), script::read(answer)) {
        (Some(question), _) => (json!([]), question),
        (None, Ok(written)) => (in_schema(&write_tree(&written), false), ""),
        // The examples are scripts: a test reads them all.
        (None, Err(_)) => (json!([]), ""),
    };
    json!({"task_tree": tree, "question": question}).to_string()
}
