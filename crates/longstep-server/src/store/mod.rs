//! The data that outlives a server: logs, records that are written once, and the right to continue a log.

mod files;
#[cfg(feature = "postgres")]
mod postgres;

pub use files::FileStore;
#[cfg(feature = "postgres")]
pub use postgres::{PostgresOptions, PostgresStore};

use std::fmt;
use std::path::PathBuf;

use jiff::Timestamp;

use crate::id::{ApprovalId, CampaignId, RunId, SessionId};

/// The most lines that are read from the end of a log at once.
pub const LONGEST_TAIL: usize = 100_000;

/// The name of a log.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LogName {
    /// The events of a session, as [`longstep::session::Log`] reads them.
    Session(SessionId),
    /// The header and the events of a run, as [`longstep_robot::RunLog`] reads them.
    Run(RunId),
    /// A robot, by the key of its queue. Nothing is added: owning it is the right to move the robot.
    Robot(String),
    /// A unit of a campaign. Nothing is added: owning it is the right to run the unit.
    Unit(UnitKey),
    /// Who approved, started and stopped what. Servers that share a store share it: it has no owner there.
    Audit,
}

impl LogName {
    /// Returns the name for a person.
    pub(crate) fn words(&self) -> String {
        match self {
            Self::Session(id) => format!("session `{id}`"),
            Self::Run(id) => format!("run `{id}`"),
            Self::Robot(key) => format!("robot `{key}`"),
            Self::Unit(key) => format!("unit `{key}`"),
            Self::Audit => "the audit log".to_owned(),
        }
    }
}

/// The key of a unit of a campaign that several programs run.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct UnitKey {
    /// The campaign.
    pub campaign: CampaignId,
    /// The place of the unit in the campaign, from 0.
    pub number: usize,
}

impl fmt::Display for UnitKey {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}.{}", self.campaign, self.number)
    }
}

/// When an addition to a log is on the disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Durability {
    /// Before the addition returns.
    Now,
    /// At the latest with the next addition that is on the disk before it returns. A crash of the machine may lose it, one
    /// of the server may not.
    Later,
}

/// Logs and records that outlive a server.
///
/// A log only grows, by whole lines. One server at a time owns a log; so a session, a run and a robot have one owner. A
/// record is written once, whoever comes first: that is how an approval is used once.
///
/// [`FileStore`] has them in files, for one server. `PostgresStore` has them in a database that several servers share.
pub trait Store: Send + Sync {
    /// Returns true if other servers may use the store at the same time. A server then owns a log only while it needs it.
    fn is_shared(&self) -> bool;

    /// Takes the right to add to a log, and makes the log if there is none. The right is given back when the result is
    /// dropped.
    ///
    /// # Errors
    ///
    /// [`StoreError::Open`] or [`StoreError::Taken`] when somebody owns it, this server included.
    fn own(&self, log: &LogName) -> Result<Box<dyn OwnedLog>, StoreError>;

    /// Returns the state of a log without reading it; none if there is no such log.
    ///
    /// # Errors
    ///
    /// When it cannot be read.
    fn state(&self, log: &LogName) -> Result<Option<LogState>, StoreError>;

    /// Reads a log; none if there is no such log.
    ///
    /// # Errors
    ///
    /// When it cannot be read, or is larger than the limit of logs.
    fn read(&self, log: &LogName) -> Result<Option<Vec<u8>>, StoreError>;

    /// Reads the last whole lines of a log without the others, in their order: at most `limit`, and at most
    /// [`LONGEST_TAIL`]. Empty if there is no such log.
    ///
    /// # Errors
    ///
    /// When it cannot be read.
    fn tail(&self, log: &LogName, limit: usize) -> Result<Vec<String>, StoreError>;

    /// Lists the sessions, in the order of their names.
    ///
    /// # Errors
    ///
    /// When they cannot be listed.
    fn sessions(&self) -> Result<Vec<SessionId>, StoreError>;

    /// Lists at most `limit` runs that have a record: first those with an owner, then those whose logs were last added to.
    ///
    /// # Errors
    ///
    /// When they cannot be listed.
    fn runs(&self, limit: usize) -> Result<Vec<StoredRun>, StoreError>;

    /// Returns the time of the last addition to a log; none if there is no such log.
    ///
    /// # Errors
    ///
    /// When it cannot be read.
    fn changed_at(&self, log: &LogName) -> Result<Option<Timestamp>, StoreError> {
        Ok(self.state(log)?.and_then(|state| state.changed_at))
    }

    /// Writes a record unless there is one with this key; returns whether it was written. It is on the disk then.
    ///
    /// # Errors
    ///
    /// When it cannot be written.
    fn insert(&self, key: &RecordKey, value: &str) -> Result<bool, StoreError>;

    /// Reads a record; none if there is none.
    ///
    /// # Errors
    ///
    /// When it cannot be read.
    fn record(&self, key: &RecordKey) -> Result<Option<String>, StoreError>;
}

/// The right to add to a log. Dropping it gives the right back.
pub trait OwnedLog: Send + Sync {
    /// Returns the length of the log in bytes.
    fn length(&self) -> u64;

    /// Returns the number of times that the log has been owned, with this one: the fencing token of each addition.
    fn epoch(&self) -> u64;

    /// Adds whole lines of text, without the character zero.
    ///
    /// # Errors
    ///
    /// [`StoreError::Lost`] when the right has ended; nothing is written then. Other errors when the lines cannot be
    /// written: a file is then as it was, and a database may have got them.
    fn append(&self, lines: &str, durability: Durability) -> Result<(), StoreError>;

    /// Returns true if the right has ended. Never waits. A right with a time limit ends here before it ends for others.
    fn is_lost(&self) -> bool;
}

/// The state of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct LogState {
    /// Its length in bytes.
    pub length: u64,
    /// The time of the last addition; none for a time outside of the calendar.
    pub changed_at: Option<Timestamp>,
    /// The number of times that it has been owned. Files count from the start of the program.
    pub epoch: u64,
    /// True if somebody owns it now. Files know only of this program.
    pub is_owned: bool,
}

/// A run in a store.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct StoredRun {
    /// Its record.
    pub record: String,
    /// The last line of its log; none if there is none.
    pub last: Option<String>,
    /// The state of its log.
    pub state: LogState,
}

/// The key of a record.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum RecordKey {
    /// An approval.
    Approval(ApprovalId),
    /// The use of an approval, by the run that it began.
    Use(ApprovalId),
    /// The data of a run besides its log.
    Run(RunId),
    /// The run of an attempt, from 0, to carry out a plan of a session: the index from plans to runs.
    Attempt {
        /// The session.
        session: SessionId,
        /// The number of the plan.
        number: usize,
        /// The number of the attempt.
        attempt: usize,
    },
    /// A stop for the server that owns a run.
    Stop {
        /// The run.
        run: RunId,
        /// The epoch of the log that is to be stopped: a run that is resumed later goes on.
        epoch: u64,
    },
    /// The results of a unit of a campaign.
    Unit(UnitKey),
}

impl RecordKey {
    /// Returns the kind of the record, and its name among those of the kind.
    fn parts(&self) -> (&'static str, String) {
        match self {
            Self::Approval(id) => ("approval", id.to_string()),
            Self::Use(id) => ("use", id.to_string()),
            Self::Run(id) => ("run", id.to_string()),
            Self::Attempt {
                session,
                number,
                attempt,
            } => ("attempt", format!("{session}.{number}.{attempt}")),
            Self::Stop { run, epoch } => ("stop", format!("{run}.{epoch}")),
            Self::Unit(key) => ("unit", key.to_string()),
        }
    }
}

/// An error of a store.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// A file or folder cannot be read or written.
    #[error("{action} {}: {reason}", path.display())]
    File {
        /// The action that failed.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        reason: std::io::Error,
    },
    /// Another program has the file of the log open.
    #[error("{0} is open in another program")]
    Open(String),
    /// Another server owns the log.
    #[error("another server works on {0}")]
    Taken(String),
    /// The right to add to the log has ended.
    #[error("this server no longer works on {0}")]
    Lost(String),
    /// The log is larger than the limit.
    #[error("the log of {0} is too large")]
    TooLarge(String),
    /// The database cannot be used. The text has no password.
    #[error("the database {database}: {reason}")]
    Database {
        /// The address without its user and password.
        database: String,
        /// The reason.
        reason: String,
    },
}
