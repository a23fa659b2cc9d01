//! What outlives a server: logs, records that are written once, and the right to continue a log.

mod files;

pub use files::FileStore;

use std::path::PathBuf;

use crate::id::{RunId, SessionId};

/// The name of a log.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LogName {
    /// The events of a session, as [`longstep::session::Log`] reads them.
    Session(SessionId),
    /// The header and the events of a run, as [`longstep_robot::RunLog`] reads them.
    Run(RunId),
    /// Who approved, started and stopped what.
    Audit,
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
/// A log only grows, by whole lines. One server at a time owns a log; so a session and a run have one owner. A record is
/// written once, whoever comes first: that is how an approval is used once.
///
/// A second implementation is a database that several servers share.
pub trait Store: Send + Sync {
    /// Takes the right to add to a log, which need not exist. Taking it twice is no error.
    ///
    /// # Errors
    ///
    /// [`StoreError::Busy`] when another program owns it.
    fn own(&self, log: &LogName) -> Result<(), StoreError>;

    /// Gives the right to add to a log back.
    fn release(&self, log: &LogName);

    /// Adds whole lines to a log that this server owns.
    ///
    /// # Errors
    ///
    /// When they cannot be written. The log is then as it was.
    fn append(&self, log: &LogName, lines: &str, durability: Durability) -> Result<(), StoreError>;

    /// Reads a log; none if there is no such log.
    ///
    /// # Errors
    ///
    /// When it cannot be read, or is larger than the limit of logs.
    fn read(&self, log: &LogName) -> Result<Option<Vec<u8>>, StoreError>;

    /// Lists the sessions, in the order of their names.
    ///
    /// # Errors
    ///
    /// When they cannot be listed.
    fn sessions(&self) -> Result<Vec<SessionId>, StoreError>;

    /// Lists the runs, in the order of their names.
    ///
    /// # Errors
    ///
    /// When they cannot be listed.
    fn runs(&self) -> Result<Vec<RunId>, StoreError>;

    /// Returns the time of the last addition to a log; none if there is no such log.
    ///
    /// # Errors
    ///
    /// When it cannot be read.
    fn changed_at(&self, log: &LogName) -> Result<Option<jiff::Timestamp>, StoreError>;

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

/// The key of a record.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum RecordKey {
    /// An approval.
    Approval(crate::id::ApprovalId),
    /// The use of an approval, by the run that it began.
    Use(crate::id::ApprovalId),
    /// What a run needs besides its log.
    Run(RunId),
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
    /// Another program owns the log.
    #[error("{0} is open in another program")]
    Busy(String),
    /// The log is larger than the limit.
    #[error("the log of {0} is too large")]
    TooLarge(String),
}
