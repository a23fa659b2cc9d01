//! A session on the disk: its event log, and the accepted plans as files.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use longstep::session::{Entry, Event, Log, LogError, Session};

use longstep_files::{
    LOG_LIMIT, create_private_folder, read_bounded, read_to_limit, restrict, tighten_folder, write_whole,
};

/// The name of the log in a session's folder.
pub const LOG: &str = "session.jsonl";

/// True for the files that a session writes: the log, plans named by their number, and the logs of runs.
fn is_ours(name: &str) -> bool {
    let number = name.strip_suffix(".json");
    let number = number.or_else(|| name.strip_prefix("run-")?.strip_suffix(".jsonl"));
    name == LOG || number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
}

/// The folder of a session: `session.jsonl`, and `0.json`, `1.json`, ... in the paper's format.
///
/// The log is the authority. A line is on the disk before the session continues, and an accepted plan is flushed
/// (`fsync`) when [`SessionFolder::keep`] returns. The plan files are derived from the log and written again if they
/// are missing. One program at a time can open a session.
///
/// A session contains the user's words: its folder has mode 700, its files mode 600. Opening a session removes broader
/// permissions of an older folder.
#[derive(Debug)]
pub struct SessionFolder {
    folder: PathBuf,
    log: File,
    /// Length of the log in bytes.
    length: u64,
}

/// An error of a session's folder. `Display` is one line; [`FolderError::hint`] is the next step for the user.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FolderError {
    /// A file or folder cannot be read or written.
    #[error("{action} {}: {reason}", path.display())]
    File {
        /// The action that failed: `cannot read`, `cannot write`.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        reason: std::io::Error,
    },
    /// The folder of a new session already has one.
    #[error("{} already contains a session", .0.display())]
    Exists(PathBuf),
    /// The folder has no session to resume.
    #[error("there is no session in {}", .0.display())]
    Missing(PathBuf),
    /// Another program has the session open.
    #[error("the session in {} is open in another program", .0.display())]
    Busy(PathBuf),
    /// The log cannot be read.
    #[error("{}: {reason}", path.display())]
    Log {
        /// The log.
        path: PathBuf,
        /// The reason.
        reason: LogError,
    },
}

impl FolderError {
    /// The next step for the user, if there is one.
    pub fn hint(&self) -> Option<String> {
        Some(match self {
            Self::File { .. } => "check the path, its permissions, and that the disk is not full".to_owned(),
            Self::Exists(folder) => format!("resume it with `longstep chat --resume {}`", folder.display()),
            Self::Missing(_) => "`longstep session list` lists the sessions".to_owned(),
            Self::Busy(_) => "close the other program first".to_owned(),
            Self::Log { reason, .. } => match reason {
                LogError::TooNew { .. } => "update longstep".to_owned(),
                LogError::Empty => "the session has no accepted plans: begin a new one".to_owned(),
                _ => "the accepted plans in the folder (0.json, 1.json, ...) are still valid".to_owned(),
            },
        })
    }
}

impl SessionFolder {
    /// Creates the folder of a new session.
    ///
    /// # Errors
    ///
    /// When there is a session already, or the folder is not writable.
    pub fn create(folder: &Path) -> Result<Self, FolderError> {
        create_private_folder(folder).map_err(file_error("cannot create", folder))?;
        let path = folder.join(LOG);
        let mut options = OpenOptions::new();
        let log = options
            .read(true)
            .append(true)
            .create_new(true)
            .open(&path)
            .map_err(|error| match error.kind() {
                std::io::ErrorKind::AlreadyExists => FolderError::Exists(folder.to_owned()),
                _ => file_error("cannot write", &path)(error),
            })?;
        restrict(&log).map_err(file_error("cannot write", &path))?;
        tighten_folder(folder, is_ours);
        lock(&log, folder)?;
        Ok(Self {
            folder: folder.to_owned(),
            log,
            length: 0,
        })
    }

    /// Opens the folder of a session to resume, and reads its log. An incomplete last line is removed.
    ///
    /// # Errors
    ///
    /// When there is no session, another program has it open, or its log is damaged.
    pub fn open(folder: &Path) -> Result<(Self, Log), FolderError> {
        let path = folder.join(LOG);
        if std::fs::metadata(&path).is_ok_and(|there| !there.is_file()) {
            let reason = std::io::Error::other("it is not a regular file");
            return Err(file_error("cannot open", &path)(reason));
        }
        let opened = OpenOptions::new().read(true).append(true).open(&path);
        let mut log = opened.map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => FolderError::Missing(folder.to_owned()),
            _ => file_error("cannot open", &path)(error),
        })?;
        lock(&log, folder)?;
        tighten_folder(folder, is_ours);
        let bytes = read_to_limit(&mut log, LOG_LIMIT).map_err(file_error("cannot read", &path))?;
        let read = Log::read(&bytes).map_err(|reason| FolderError::Log {
            path: path.clone(),
            reason,
        })?;
        let length = read.whole as u64;
        log.set_len(length).map_err(file_error("cannot write", &path))?;
        let folder = folder.to_owned();
        Ok((Self { folder, log, length }, read))
    }

    /// Reads a session's log without opening the session.
    ///
    /// # Errors
    ///
    /// When there is no log, or it is damaged.
    pub fn read(folder: &Path) -> Result<Log, FolderError> {
        let path = if folder.is_dir() {
            folder.join(LOG)
        } else {
            folder.to_owned()
        };
        let bytes = read_bounded(&path, LOG_LIMIT).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => FolderError::Missing(folder.to_owned()),
            _ => file_error("cannot read", &path)(error),
        })?;
        Log::read(&bytes).map_err(|reason| FolderError::Log { path, reason })
    }

    /// The path of the folder.
    pub fn path(&self) -> &Path {
        &self.folder
    }

    /// Saves the events since the last call, and the plans.
    ///
    /// # Errors
    ///
    /// When something cannot be written. The last events are then not saved; the log is as it was before.
    pub fn keep(&mut self, session: &mut Session) -> Result<(), FolderError> {
        let events = session.take_events();
        if events.is_empty() {
            return Ok(());
        }
        let at = jiff::Timestamp::now().to_string();
        let through = events.iter().any(Event::is_lasting);
        let mut text = String::new();
        let mut numbers = Vec::new();
        for event in events {
            if let Event::Accept { number, .. } | Event::Undo { number } = &event {
                numbers.push(*number);
            }
            text.push_str(&Entry::new(at.clone(), event).line());
        }
        self.append(text.as_bytes(), through)?;
        numbers.into_iter().try_for_each(|number| self.plan(session, number))
    }

    /// Writes missing plan files of the session's log, and removes those of undone plans.
    ///
    /// # Errors
    ///
    /// When a file cannot be written or removed.
    pub fn mend(&self, session: &Session) -> Result<(), FolderError> {
        (0..=session.accepted().len()).try_for_each(|number| self.plan(session, number))
    }

    fn append(&mut self, bytes: &[u8], through: bool) -> Result<(), FolderError> {
        let path = self.folder.join(LOG);
        let written = self
            .log
            .write_all(bytes)
            .and_then(|()| if through { self.log.sync_data() } else { Ok(()) });
        if let Err(error) = written {
            // A partial line would corrupt the next one.
            let _ = self.log.set_len(self.length);
            let _ = self.log.seek(SeekFrom::End(0));
            return Err(file_error("cannot write", &path)(error));
        }
        self.length += bytes.len() as u64;
        Ok(())
    }

    /// Writes one plan file, or removes it if the plan was undone.
    fn plan(&self, session: &Session, number: usize) -> Result<(), FolderError> {
        let path = self.folder.join(format!("{number}.json"));
        match session.plan_file(number) {
            Some(plan) => {
                // A plan is plain data with string keys; its serialization does not fail.
                let mut json = serde_json::to_string_pretty(&plan).unwrap_or_default();
                json.push('\n');
                if std::fs::read(&path).is_ok_and(|there| there == json.as_bytes()) {
                    return Ok(());
                }
                write_whole(&path, json.as_bytes()).map_err(file_error("cannot write", &path))
            }
            None => match std::fs::remove_file(&path) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    Err(file_error("cannot remove", &path)(error))
                }
                _ => Ok(()),
            },
        }
    }
}

fn lock(log: &File, folder: &Path) -> Result<(), FolderError> {
    match log.try_lock() {
        Err(TryLockError::WouldBlock) => Err(FolderError::Busy(folder.to_owned())),
        // Some file systems cannot lock; the session is opened without a lock then.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

fn file_error(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> FolderError {
    let path = path.to_path_buf();
    move |reason| FolderError::File { action, path, reason }
}
