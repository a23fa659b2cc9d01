//! The log of a run: one JSON object a line, on disk before the robot moves.

use std::fs::{self, File, OpenOptions};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use jiff::Timestamp;
use longstep_core::execution::Event;
use longstep_core::secret;
use serde::{Deserialize, Serialize};

/// The JSON Schema of a line of a log.
pub const RUN_LOG_SCHEMA: &str = include_str!("run.schema.json");

/// Maximum length of a log.
const LARGEST: u64 = 256 << 20;

/// The first line of a log: what a run needs besides its events.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct RunHeader {
    /// The version of the log.
    pub longstep_run: u32,
    /// The robot as the user named it, without the passwords of addresses.
    pub robot: String,
    /// The domain as the user named it.
    pub domain: String,
    /// True for a run in which nothing moved.
    #[serde(default, skip_serializing_if = "is_false")]
    pub dry_run: bool,
}

fn is_false(value: &bool) -> bool {
    !value
}

impl RunHeader {
    /// Returns the header of a log of this version.
    pub fn new(robot: &str, domain: &str) -> Self {
        Self {
            longstep_run: 1,
            robot: secret::in_addresses(robot).into_owned(),
            domain: domain.to_owned(),
            dry_run: false,
        }
    }

    /// Marks a run in which nothing moves, or not.
    #[must_use]
    pub fn with_dry_run(self, dry_run: bool) -> Self {
        Self { dry_run, ..self }
    }
}

/// An event of a log, with the time at which it was written.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TimedEvent {
    /// The time; none in a log of a version that kept no times.
    pub at: Option<Timestamp>,
    /// The event.
    pub event: Event,
}

impl TimedEvent {
    /// Returns an event with its time.
    pub fn new(at: impl Into<Option<Timestamp>>, event: Event) -> Self {
        Self { at: at.into(), event }
    }
}

/// An event as a line of a log.
#[derive(Serialize)]
struct Line<'e> {
    #[serde(flatten)]
    event: &'e Event,
    at: Timestamp,
}

/// The time of a line.
#[derive(Deserialize)]
struct LineTime {
    at: Option<Timestamp>,
}

/// A log that cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunLogError {
    /// The file cannot be read or written.
    #[error("{}: {error}", .path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The error.
        error: std::io::Error,
    },
    /// A line is no event.
    #[error("{}:{line}: {why}", .path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The number of the line, from 1.
        line: usize,
        /// The reason.
        why: String,
    },
    /// The file has more than 256 MiB.
    #[error("{}: the file is too large for a log", .path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// Another program writes this log: it has a lock.
    #[error("{}: another program is writing this log", .path.display())]
    Locked {
        /// The file.
        path: PathBuf,
    },
}

/// A log that is being written. It is locked, so that no second program takes up the same run.
#[derive(Debug)]
pub struct RunLog {
    file: File,
    path: PathBuf,
}

impl RunLog {
    /// Creates a log; a file that exists is an error.
    ///
    /// # Errors
    ///
    /// A file that cannot be created.
    pub fn create(path: &Path, header: &RunHeader) -> Result<Self, RunLogError> {
        let file = OpenOptions::new().append(true).create_new(true).open(path);
        let file = file.map_err(|error| failed(path, error))?;
        let mut log = Self {
            file,
            path: path.to_owned(),
        };
        log.lock()?;
        let line = serde_json::to_string(header).map_err(|error| failed(path, error.into()))?;
        log.write(&(line + "\n"))?;
        log.sync()?;
        // The name of the file is on disk too.
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            let folder = File::open(folder).and_then(|folder| folder.sync_all());
            folder.map_err(|error| failed(path, error))?;
        }
        Ok(log)
    }

    /// Opens a log to continue it, and reads what it has. A last line that is not complete was never acted on: it is
    /// removed.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or that is no log.
    pub fn resume(path: &Path) -> Result<(Self, RunHeader, Vec<Event>), RunLogError> {
        let file = OpenOptions::new().read(true).append(true).open(path);
        let file = file.map_err(|error| failed(path, error))?;
        let mut log = Self {
            file,
            path: path.to_owned(),
        };
        log.lock()?;
        let text = log.text()?;
        let complete = whole(&text).len();
        let (header, events) = parsed(path, whole(&text))?;
        if complete < text.len() {
            let cut = log.file.set_len(complete as u64).and_then(|()| log.file.sync_data());
            cut.map_err(|error| failed(path, error))?;
        }
        Ok((log, header, events))
    }

    /// Reads a log.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or that is no log.
    pub fn read(path: &Path) -> Result<(RunHeader, Vec<Event>), RunLogError> {
        let file = File::open(path).map_err(|error| failed(path, error))?;
        let mut log = Self {
            file,
            path: path.to_owned(),
        };
        Self::parse(path, &log.text()?)
    }

    /// Reads a log with the times of its events.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or that is no log.
    pub fn read_timed(path: &Path) -> Result<(RunHeader, Vec<TimedEvent>), RunLogError> {
        let file = File::open(path).map_err(|error| failed(path, error))?;
        let mut log = Self {
            file,
            path: path.to_owned(),
        };
        Self::parse_timed(path, &log.text()?)
    }

    /// Reads the text of a log; `path` is its name in errors. A last line that is not complete is left out.
    ///
    /// # Errors
    ///
    /// A text that is no log.
    pub fn parse(path: &Path, text: &str) -> Result<(RunHeader, Vec<Event>), RunLogError> {
        parsed(path, whole(text))
    }

    /// Reads the text of a log with the times of its events, as [`RunLog::parse`] does.
    ///
    /// # Errors
    ///
    /// A text that is no log.
    pub fn parse_timed(path: &Path, text: &str) -> Result<(RunHeader, Vec<TimedEvent>), RunLogError> {
        let text = whole(text);
        let (header, events) = parsed(path, text)?;
        let times = text.lines().skip(1).enumerate().map(|(index, line)| {
            let time = serde_json::from_str::<LineTime>(line);
            time.map(|time| time.at).map_err(|error| RunLogError::Line {
                path: path.to_owned(),
                line: index + 2,
                why: error.to_string(),
            })
        });
        let events = times.zip(events).map(|(at, event)| Ok(TimedEvent::new(at?, event)));
        Ok((header, events.collect::<Result<_, _>>()?))
    }

    /// Returns events as lines of a log, with the time at which they are written.
    ///
    /// # Errors
    ///
    /// An event that cannot be written as JSON.
    pub fn lines(events: &[Event], at: Timestamp) -> Result<String, serde_json::Error> {
        let mut lines = String::new();
        for event in events {
            lines.push_str(&serde_json::to_string(&Line { event, at })?);
            lines.push('\n');
        }
        Ok(lines)
    }

    fn lock(&self) -> Result<(), RunLogError> {
        match self.file.try_lock() {
            Ok(()) => Ok(()),
            Err(fs::TryLockError::WouldBlock) => Err(RunLogError::Locked {
                path: self.path.clone(),
            }),
            Err(fs::TryLockError::Error(error)) => Err(failed(&self.path, error)),
        }
    }

    fn text(&mut self) -> Result<String, RunLogError> {
        let mut text = String::new();
        let read = (&self.file).take(LARGEST + 1).read_to_string(&mut text);
        read.map_err(|error| failed(&self.path, error))?;
        if text.len() as u64 > LARGEST {
            Err(RunLogError::TooLarge {
                path: self.path.clone(),
            })
        } else {
            Ok(text)
        }
    }

    /// Appends events with the time; they are on disk when this returns.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn append(&mut self, events: &[Event]) -> Result<(), RunLogError> {
        let lines = Self::lines(events, Timestamp::now()).map_err(|error| failed(&self.path, error.into()))?;
        self.write(&lines)?;
        self.sync()
    }

    fn write(&mut self, lines: &str) -> Result<(), RunLogError> {
        let written = self.file.write_all(lines.as_bytes());
        written.map_err(|error| failed(&self.path, error))
    }

    fn sync(&self) -> Result<(), RunLogError> {
        self.file.sync_data().map_err(|error| failed(&self.path, error))
    }
}

fn failed(path: &Path, error: std::io::Error) -> RunLogError {
    RunLogError::File {
        path: path.to_owned(),
        error,
    }
}

/// Returns the complete lines of a text.
fn whole(text: &str) -> &str {
    &text[..text.rfind('\n').map_or(0, |end| end + 1)]
}

fn parsed(path: &Path, text: &str) -> Result<(RunHeader, Vec<Event>), RunLogError> {
    let wrong = |line: usize, why: String| RunLogError::Line {
        path: path.to_owned(),
        line,
        why,
    };
    let mut lines = text.lines().enumerate();
    let (_, first) = lines.next().ok_or_else(|| wrong(1, "the log is empty".to_owned()))?;
    let header: RunHeader = serde_json::from_str(first).map_err(|error| wrong(1, error.to_string()))?;
    let event =
        |(index, line): (usize, &str)| serde_json::from_str(line).map_err(|error| wrong(index + 1, error.to_string()));
    Ok((header, lines.map(event).collect::<Result<_, _>>()?))
}
