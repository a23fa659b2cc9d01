//! The paper's notation for steps and states: `PutIn(<pie>, <microwave>)`, `closed()`.

use std::fmt;

/// Signs that separate the parts of steps, states and goals. No identifier has one: what is written with it could not be read
/// again.
pub const NOTATION: [char; 5] = ['(', ')', ',', '&', '"'];

/// Words of the goal language. No goal, state or number of a domain may have one as its word.
const GOAL_KEYWORDS: [&str; 15] = [
    "all",
    "always",
    "and",
    "any",
    "each",
    "else",
    "exactly",
    "except",
    "if",
    "never",
    "not",
    "of",
    "then",
    "untouched",
    "where",
];

/// Reserved words of the script notation. No call of an action may have one as its name.
const SCRIPT_KEYWORDS: [&str; 43] = [
    "False", "None", "True", "and", "as", "assert", "async", "await", "break", "case", "class", "continue", "def",
    "del", "elif", "else", "except", "finally", "for", "from", "global", "if", "import", "in", "is", "lambda", "lane",
    "match", "nonlocal", "not", "or", "parallel", "pass", "print", "raise", "range", "return", "sync", "try", "type",
    "while", "with", "yield",
];

/// Returns true for a word of the goal language.
///
/// ```
/// use longstep_model::call::{is_goal_keyword, is_script_keyword};
/// assert!(is_goal_keyword("untouched") && !is_goal_keyword("put"));
/// assert!(is_script_keyword("for") && !is_script_keyword("fore"));
/// ```
pub fn is_goal_keyword(word: &str) -> bool {
    GOAL_KEYWORDS.contains(&word)
}

/// Returns true for a reserved word of the script notation.
pub fn is_script_keyword(word: &str) -> bool {
    SCRIPT_KEYWORDS.contains(&word)
}

/// A word with arguments in parentheses.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Call {
    /// The word before the parenthesis.
    pub name: String,
    /// The arguments in the parentheses, split at commas and trimmed.
    pub arguments: Vec<String>,
}

/// The error for a text that is not a call.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is not written as `word(argument, ...)`")]
pub struct NotACall {
    text: String,
}

impl Call {
    /// Parses a call; a call without arguments may omit the parentheses. Text in double quotes is one argument, whatever
    /// it contains.
    ///
    /// # Errors
    ///
    /// A text of any other form.
    ///
    /// ```
    /// use longstep_model::call::Call;
    /// let call = Call::parse("PutIn( <pie>, <oven> )").unwrap();
    /// assert_eq!(call.to_string(), "PutIn(<pie>, <oven>)");
    /// assert_eq!(Call::parse("CLOSED").unwrap().to_string(), "CLOSED()");
    /// assert!(Call::parse("Open(<a>").is_err());
    /// ```
    pub fn parse(text: &str) -> Result<Self, NotACall> {
        let trimmed = text.trim();
        let error = || NotACall {
            // Long hostile input must not fill the error message.
            text: trimmed.chars().take(80).collect(),
        };
        let (name, inner) = match trimmed.split_once('(') {
            Some((name, rest)) => (name.trim(), rest.strip_suffix(')').ok_or_else(error)?),
            None => (trimmed, ""),
        };
        let word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-');
        if name.is_empty() || !name.chars().all(word) || unquoted(inner).any(|(_, c)| matches!(c, '(' | ')')) {
            return Err(error());
        }
        let arguments: Vec<String> = if inner.trim().is_empty() {
            Vec::new()
        } else {
            split_unquoted(inner, ',')
                .into_iter()
                .map(|argument| argument.trim().to_owned())
                .collect()
        };
        if arguments.iter().any(String::is_empty) {
            return Err(error());
        }
        Ok(Self {
            name: name.to_owned(),
            arguments,
        })
    }
}

/// Iterates over the characters of a text outside double quotes, with their places.
pub fn unquoted(text: &str) -> impl Iterator<Item = (usize, char)> {
    let mut quoted = false;
    text.char_indices().filter(move |(_, letter)| {
        let mark = *letter == '"';
        quoted ^= mark;
        !quoted && !mark
    })
}

/// Splits a text at every separator outside double quotes.
pub(crate) fn split_unquoted(text: &str, separator: char) -> Vec<&str> {
    let mut parts = Vec::new();
    let mut start = 0;
    for (at, letter) in unquoted(text) {
        if letter == separator {
            parts.push(&text[start..at]);
            start = at + letter.len_utf8();
        }
    }
    parts.push(&text[start..]);
    parts
}

/// Returns the first place of a pattern outside double quotes.
pub fn find_unquoted(text: &str, pattern: &str) -> Option<usize> {
    unquoted(text)
        .map(|(at, _)| at)
        .find(|at| text[*at..].starts_with(pattern))
}

impl fmt::Display for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}({})", self.name, self.arguments.join(", "))
    }
}
