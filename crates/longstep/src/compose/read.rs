//! What a model, or a person, wrote.

use super::request::asks;
use crate::plan::{ScriptError, Written, script};

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
pub fn read(text: &str) -> Result<Said, ScriptError> {
    if let Some(question) = asks(text) {
        return Ok(Said::Question(question.to_owned()));
    }
    script::read(text).map(Said::Composition)
}
