//! Diagnostics for a text that a user wrote: the problem, its position, and a hint.

use std::fmt;

use crate::secret;

/// A position in a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Position {
    /// The line, from 1.
    pub line: u32,
    /// The column in characters, from 1.
    pub column: u32,
}

impl Position {
    /// Converts a byte offset in `text` to a position; an offset past the end gives the end of the text.
    ///
    /// ```
    /// use longstep_model::diagnostic::Position;
    /// assert_eq!(Position::of("ab\ncd", 4), Position { line: 2, column: 2 });
    /// ```
    pub fn of(text: &str, offset: usize) -> Self {
        let mut offset = offset.min(text.len());
        while !text.is_char_boundary(offset) {
            offset -= 1;
        }
        let before = &text[..offset];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        Self {
            line: 1 + before.matches('\n').count() as u32,
            column: 1 + before[line_start..].chars().count() as u32,
        }
    }
}

/// One problem with its position. The constructors remove passwords from what they quote.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub struct Diagnostic {
    /// The file, as the user named it or relative to the domain's folder.
    pub file: String,
    /// The position in the file, if the problem has a single one.
    pub position: Option<Position>,
    /// The problem.
    pub message: String,
    /// The advice on how to solve it.
    pub hint: Option<String>,
}

impl Diagnostic {
    /// Creates a diagnostic for a position in a file.
    pub fn at(file: &str, position: Position, message: impl Into<String>) -> Self {
        Self {
            file: file.to_owned(),
            position: Some(position),
            message: shown(message),
            hint: None,
        }
    }

    /// Creates a diagnostic for a file as a whole.
    pub fn whole(file: &str, message: impl Into<String>) -> Self {
        Self {
            file: file.to_owned(),
            position: None,
            message: shown(message),
            hint: None,
        }
    }

    /// Sets the position in the file, if it is known.
    #[must_use]
    pub fn with_position(self, position: Option<Position>) -> Self {
        Self { position, ..self }
    }

    /// Adds advice to the diagnostic.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(shown(hint));
        self
    }
}

fn shown(text: impl Into<String>) -> String {
    secret::redacted(&text.into()).into_owned()
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(Position { line, column }) = self.position {
            write!(f, ":{line}:{column}")?;
        }
        write!(f, ": {}", self.message)?;
        if let Some(hint) = &self.hint {
            write!(f, "\n  hint: {hint}")?;
        }
        Ok(())
    }
}

/// All problems of an input, sorted by file and position.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl Diagnostics {
    /// Sorts the diagnostics by file and position, and removes duplicates.
    pub fn sorted(mut findings: Vec<Diagnostic>) -> Self {
        findings.sort();
        findings.dedup();
        Self(findings)
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, finding) in self.0.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{finding}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostics {}

/// The number of characters above which [`nearest`] does not compare a word.
const LONGEST_COMPARED: usize = 100;

/// Returns the candidate with the smallest edit distance to `word`, if that is at most a third of the length of `word`.
///
/// Upper and lower case are equal; the limit is at least one edit.
///
/// ```
/// use longstep_model::diagnostic::nearest;
/// assert_eq!(nearest("houshold", ["household", "virtualhome"]), Some("household"));
/// assert_eq!(nearest("garage", ["household", "virtualhome"]), None);
/// ```
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    let length = lower.chars().count();
    // The edit distance takes time proportional to the product of the lengths.
    if length > LONGEST_COMPARED {
        return None;
    }
    let limit = (length / 3).max(1);
    candidates
        .into_iter()
        .filter(|candidate| candidate.chars().take(length + limit + 1).count().abs_diff(length) <= limit)
        .map(|candidate| {
            (
                strsim::damerau_levenshtein(&lower, &candidate.to_lowercase()),
                candidate,
            )
        })
        .filter(|(distance, _)| *distance <= limit)
        .min()
        .map(|(_, candidate)| candidate)
}
