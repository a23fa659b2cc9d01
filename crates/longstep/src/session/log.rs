//! The event log as text: JSON Lines, each line an event and when it happened.

use serde::{Deserialize, Serialize};

use super::{Event, VERSION};

/// A line of a log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// When, as whoever writes the log tells it; not looked at.
    pub at: String,
    /// What.
    #[serde(flatten)]
    pub event: Event,
}

impl Entry {
    /// The line, with its end.
    pub fn line(&self) -> String {
        // Every part of an event can be written as JSON: keys are strings, numbers are finite.
        let mut line = serde_json::to_string(self).unwrap_or_default();
        line.push('\n');
        line
    }
}

/// A log as it was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// The whole lines.
    pub entries: Vec<Entry>,
    /// How many bytes of the text they take; what is behind is torn.
    pub whole: usize,
    /// How many bytes were cut off at the end: a line that was being written when the program was killed.
    pub torn: usize,
}

/// Why a text is no log.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LogError {
    /// There is no whole line in it.
    #[error("the session has not begun: its log has no whole line")]
    Empty,
    /// The first line is something else.
    #[error("this is no session log: its first line does not begin a session")]
    NoBeginning,
    /// It was written by a newer program.
    #[error("the session log has version {found}, and this program reads up to {VERSION}")]
    TooNew {
        /// Its version.
        found: u32,
    },
    /// A line in the middle cannot be read.
    #[error("line {line} of the session log is damaged: {reason}")]
    Damaged {
        /// From 1.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
}

impl Log {
    /// Reads a log. A last line that is not whole is left out: its event never happened, since nobody goes on before
    /// a line is on the disk.
    ///
    /// ```
    /// use longstep::session::{Log, LogError};
    /// assert_eq!(Log::read(b"{\"at\": \"").unwrap_err(), LogError::Empty);
    /// ```
    ///
    /// # Errors
    ///
    /// When it is no log, is too new, or is damaged before its end.
    pub fn read(bytes: &[u8]) -> Result<Self, LogError> {
        let mut whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
        let mut entries: Vec<Entry> = Vec::new();
        let lines: Vec<&[u8]> = bytes[..whole].split_inclusive(|byte| *byte == b'\n').collect();
        for (index, line) in lines.iter().enumerate() {
            match serde_json::from_slice::<Entry>(line) {
                Ok(entry) => entries.push(entry),
                // A disk that lost power may keep a line's end without its middle.
                Err(_) if index + 1 == lines.len() && index > 0 => whole -= line.len(),
                Err(error) => {
                    if let Some(found) = version(line).filter(|found| *found > VERSION) {
                        return Err(LogError::TooNew { found });
                    }
                    return Err(match index {
                        0 => LogError::NoBeginning,
                        _ => LogError::Damaged {
                            line: index + 1,
                            reason: reason(&error),
                        },
                    });
                }
            }
        }
        match entries.first().map(|entry| &entry.event) {
            None => return Err(LogError::Empty),
            Some(Event::Begin { version, .. }) if *version > VERSION => {
                return Err(LogError::TooNew { found: *version });
            }
            Some(Event::Begin { .. }) => {}
            Some(_) => return Err(LogError::NoBeginning),
        }
        Ok(Self {
            entries,
            whole,
            torn: bytes.len() - whole,
        })
    }

    /// What happened, in order.
    pub fn events(&self) -> impl Iterator<Item = &Event> {
        self.entries.iter().map(|entry| &entry.event)
    }
}

/// What is wrong with a line; where in the line, since the line's own number is told beside it.
fn reason(error: &serde_json::Error) -> String {
    let text = error.to_string();
    let (what, _) = text.rsplit_once(" at line ").unwrap_or((&text, ""));
    match error.column() {
        0 => what.to_owned(),
        column => format!("{what} at column {column}"),
    }
}

/// The version that a line gives, whatever else stands in it.
fn version(line: &[u8]) -> Option<u32> {
    #[derive(Deserialize)]
    struct Versioned {
        version: u32,
    }
    serde_json::from_slice::<Versioned>(line).ok().map(|line| line.version)
}
