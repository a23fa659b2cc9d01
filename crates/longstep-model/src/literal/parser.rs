//! The place in a reply up to which it has been parsed, with what was accepted on the way.

use super::leniency::{LeniencyKind as Kind, Notes};

/// The marker of a code block.
pub const FENCE: &str = "```";

/// Why an object cannot be parsed.
#[derive(Debug)]
pub enum FaultReason {
    /// The text or its code block ends before the object does.
    CutOff,
    /// Brackets are nested deeper than [`DEEPEST`](super::DEEPEST).
    TooDeep,
    /// Any other mistake, as a sentence.
    Malformed(String),
}

/// The text of a reply, and how much of it has been read.
pub(crate) struct Parser<'t> {
    pub(crate) text: &'t str,
    pub(crate) at: usize,
    pub(crate) depth: usize,
    /// True if a key was read that only plans have.
    pub(crate) of_plan: bool,
    pub(crate) notes: Notes,
}

pub(crate) type Parsed<T> = Result<T, FaultReason>;

pub(crate) fn malformed<T>(message: impl Into<String>) -> Parsed<T> {
    Err(FaultReason::Malformed(message.into()))
}

impl<'t> Parser<'t> {
    pub(crate) fn new(text: &'t str, at: usize) -> Self {
        Self {
            text,
            at,
            depth: 0,
            of_plan: false,
            notes: Notes::default(),
        }
    }

    pub(crate) fn rest(&self) -> &'t str {
        &self.text[self.at..]
    }

    pub(crate) fn note(&mut self, kind: Kind) {
        self.notes.add(kind, self.at);
    }

    /// Skips whitespace and comments, and returns the next character. The end of the text or of the code block is an
    /// error, since both would be inside an object.
    pub(crate) fn peek(&mut self) -> Parsed<char> {
        loop {
            let rest = self.rest();
            let Some(next) = rest.chars().next() else {
                return Err(FaultReason::CutOff);
            };
            if matches!(next, ' ' | '\t' | '\n' | '\r') {
                self.at += 1;
            } else if next.is_whitespace() || next == '\u{feff}' {
                self.note(Kind::OddSpace);
                self.at += next.len_utf8();
            } else if next == '#' || rest.starts_with("//") {
                self.note(Kind::Comment);
                self.at += rest.find('\n').unwrap_or(rest.len());
            } else if let Some(comment) = rest.strip_prefix("/*") {
                self.note(Kind::Comment);
                let Some(end) = comment.find("*/") else {
                    self.at = self.text.len();
                    return Err(FaultReason::CutOff);
                };
                self.at += 2 + end + 2;
            } else if rest.starts_with(FENCE) {
                return Err(FaultReason::CutOff);
            } else {
                return Ok(next);
            }
        }
    }
}
