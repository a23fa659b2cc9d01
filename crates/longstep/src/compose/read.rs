//! Parsing of compositions.

use crate::diagnostic::Position;
use crate::dialogue::answer_grammar::question_in;
use crate::dialogue::in_schema;
use crate::plan::{self, Unreadable, Written, script, write_tree};
use serde_json::json;

/// A parsed reply.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CompositionAnswer {
    /// A composition whose calls are not resolved yet.
    Composition(Written),
    /// A question to the person.
    Question(String),
}

/// Parses a composition, as a script or as a JSON tree, with or without text around it.
///
/// ```
/// use longstep::compose::{CompositionAnswer, read};
/// let said = read("fetch_pear()\nif rotten(\"pear\"):\n    compost_pear()\n").unwrap();
/// let CompositionAnswer::Composition(written) = said else { panic!("{said:?}") };
/// assert_eq!(written.steps.len(), 2);
/// assert_eq!(read("question: Which pear?").unwrap(), CompositionAnswer::Question("Which pear?".to_owned()));
/// ```
///
/// # Errors
///
/// The text contains no plan, or its plan cannot be parsed.
pub fn read(text: &str) -> Result<CompositionAnswer, Unreadable> {
    if let Some(question) = question_in(text) {
        return Ok(CompositionAnswer::Question(question.to_owned()));
    }
    let file = plan::read(text)?.file;
    Ok(match file.question.trim() {
        "" => CompositionAnswer::Composition(file.task_cohesion.written().map_err(|error| Unreadable::Malformed {
            position: Position { line: 1, column: 1 },
            message: error.to_string(),
        })?),
        question => CompositionAnswer::Question(question.to_owned()),
    })
}

/// Converts the answer of an example to the JSON that the schema describes.
pub(super) fn in_json(answer: &str) -> String {
    let (tree, question) = match (question_in(answer), script::read(answer)) {
        (Some(question), _) => (json!([]), question),
        (None, Ok(written)) => (in_schema(&write_tree(&written), false), ""),
        // Unreachable for the examples: a test parses all of them.
        (None, Err(_)) => (json!([]), ""),
    };
    json!({"task_tree": tree, "question": question}).to_string()
}
