//! The event log in JSON Lines format. Each line is an event with its time.

use serde::{Deserialize, Serialize};

use super::{Event, VERSION};

/// A line of a log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Entry {
    /// Time of the event, as the writer gives it; never parsed.
    pub at: String,
    /// The event.
    #[serde(flatten)]
    pub event: Event,
}

impl Entry {
    /// Creates the entry of an event at this time, in any notation.
    pub fn new(at: impl Into<String>, event: Event) -> Self {
        Self { at: at.into(), event }
    }

    /// Returns the JSON line with its line break.
    pub fn line(&self) -> String {
        // Serialization cannot fail: keys are strings and numbers are finite.
        let mut line = serde_json::to_string(self).unwrap_or_default();
        line.push('\n');
        line
    }
}

/// A parsed log.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Log {
    /// The complete lines.
    pub entries: Vec<Entry>,
    /// Length of the complete lines in bytes; the rest is a torn line.
    pub whole: usize,
    /// Length of the torn line at the end in bytes, left by a program that was interrupted while writing.
    pub torn: usize,
}

/// Reason why a text is not a valid log.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The text has no complete line.
    #[error("the session has not begun: its log has no whole line")]
    Empty,
    /// The first line does not start a session.
    #[error("this is no session log: its first line does not begin a session")]
    NoBeginning,
    /// A newer program wrote the log.
    #[error("the session log has version {found}, and this program reads up to {VERSION}")]
    TooNew {
        /// Version of the log.
        found: u32,
    },
    /// A line before the end is invalid.
    #[error("line {line} of the session log is damaged: {reason}")]
    Damaged {
        /// Line number, from 1.
        line: usize,
        /// The reason.
        reason: String,
    },
}

impl Log {
    /// Parses a log. An incomplete last line is ignored: its event did not take effect, since a session continues only
    /// after a line is on disk.
    ///
    /// ```
    /// use longstep::session::{Log, LogError};
    /// assert_eq!(Log::read(b"{\"at\": \"").unwrap_err(), LogError::Empty);
    /// ```
    ///
    /// # Errors
    ///
    /// The text is no log, its version is too new, or it is damaged before its end.
    pub fn read(bytes: &[u8]) -> Result<Self, LogError> {
        let mut whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
        let mut entries: Vec<Entry> = Vec::new();
        let lines: Vec<&[u8]> = bytes[..whole].split_inclusive(|byte| *byte == b'\n').collect();
        for (index, line) in lines.iter().enumerate() {
            match serde_json::from_slice::<Entry>(line) {
                Ok(entry) => entries.push(entry),
                // A power failure can leave the end of a line on disk without its middle.
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

    /// Returns the events, in order.
    pub fn events(&self) -> impl Iterator<Item = &Event> {
        self.entries.iter().map(|entry| &entry.event)
    }
}

/// Returns the reason why a line is invalid, with its column. The line number of the error is dropped, since the caller
/// reports the number in the log.
fn reason(error: &serde_json::Error) -> String {
    let text = error.to_string();
    let (what, _) = text.rsplit_once(" at line ").unwrap_or((&text, ""));
    match error.column() {
        0 => what.to_owned(),
        column => format!("{what} at column {column}"),
    }
}

/// Returns the `version` of a line, ignoring all other fields.
fn version(line: &[u8]) -> Option<u32> {
    #[derive(Deserialize)]
    struct Versioned {
        version: u32,
    }
    serde_json::from_slice::<Versioned>(line).ok().map(|line| line.version)
}
