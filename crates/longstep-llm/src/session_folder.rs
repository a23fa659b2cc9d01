//! A session on the disk: its event log, and the accepted plans as files.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use longstep::session::{Entry, Event, Log, LogError, Session};

use crate::bounded::{LOG_LIMIT, read_bounded, read_to_limit};
use crate::private::{create_private_folder, restrict, tighten_folder};
use crate::whole_file::write_whole;

/// The name of the log in a session's folder.
pub const LOG: &str = "session.jsonl";

/// Returns whether a file of a session's folder is one that a session writes: the log, or a plan by its number.
fn is_ours(name: &str) -> bool {
    let number = name.strip_suffix(".json");
    name == LOG || number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
}

/// The folder of a session: `session.jsonl`, and `0.json`, `1.json`, ... in the paper's format.
///
/// The log is what counts. A line is on the disk before anybody goes on from it, and an accepted plan has been
/// written through to the disk (`fsync`) when [`SessionFolder::keep`] returns; the plan files follow from the log and
/// are written anew where they are missing. One program at a time has a session open.
///
/// A session holds what people said: its folder is for its owner alone (mode 700), and so are its files (600). A broader
/// mode of an older folder is taken away when the session is opened.
#[derive(Debug)]
pub struct SessionFolder {
    folder: PathBuf,
    log: File,
    /// How long the log is.
    length: u64,
}

/// What can go wrong with a session's folder. `Display` is one line; [`FolderError::hint`] says what to do.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// A file or folder cannot be read or written.
    #[error("{action} {}: {reason}", path.display())]
    File {
        /// `cannot read`, `cannot write`.
        action: &'static str,
        /// Which.
        path: PathBuf,
        /// Why.
        reason: std::io::Error,
    },
    /// There is a session already where one was to begin.
    #[error("there is a session in {} already", .0.display())]
    Exists(PathBuf),
    /// There is no session where one was to be taken up.
    #[error("there is no session in {}", .0.display())]
    Missing(PathBuf),
    /// Another program has it open.
    #[error("the session in {} is open in another program", .0.display())]
    Busy(PathBuf),
    /// The log cannot be read.
    #[error("{}: {reason}", path.display())]
    Log {
        /// The log.
        path: PathBuf,
        /// Why.
        reason: LogError,
    },
}

impl FolderError {
    /// What to do about it, if there is something.
    pub fn hint(&self) -> Option<String> {
        Some(match self {
            Self::File { .. } => "check the path, its permissions, and that the disk is not full".to_owned(),
            Self::Exists(folder) => format!("go on with it: `longstep chat --resume {}`", folder.display()),
            Self::Missing(_) => "`longstep session list` shows the sessions that there are".to_owned(),
            Self::Busy(_) => "close the other program first".to_owned(),
            Self::Log { reason, .. } => match reason {
                LogError::TooNew { .. } => "use a newer longstep".to_owned(),
                LogError::Empty => "nothing was accepted in it: begin a new session".to_owned(),
                _ => "the accepted plans in the folder (0.json, 1.json, ...) are good all the same".to_owned(),
            },
        })
    }
}

impl SessionFolder {
    /// Makes the folder of a session that begins.
    ///
    /// # Errors
    ///
    /// When there is a session already, or nothing can be written there.
    pub fn create(folder: &Path) -> Result<Self, FolderError> {
        create_private_folder(folder).map_err(file_error("cannot make", folder))?;
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

    /// Opens the folder of a session that is to go on, and reads its log. A torn last line is cut off.
    ///
    /// # Errors
    ///
    /// When there is no session, another program has it open, or its log is damaged.
    pub fn open(folder: &Path) -> Result<(Self, Log), FolderError> {
        let path = folder.join(LOG);
        if std::fs::metadata(&path).is_ok_and(|there| !there.is_file()) {
            let reason = std::io::Error::other("it is no regular file");
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

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.folder
    }

    /// Writes down what has happened in the session since the last time, and its plans.
    ///
    /// # Errors
    ///
    /// When something cannot be written. What was accepted is then not safe; the log is as it was before.
    pub fn keep(&mut self, session: &mut Session) -> Result<(), FolderError> {
        let events = session.take_events();
        if events.is_empty() {
            return Ok(());
        }
        let at = jiff::Timestamp::now().to_string();
        let lasting = |event: &Event| matches!(event, Event::Begin { .. } | Event::Accept { .. } | Event::Undo { .. });
        let through = events.iter().any(lasting);
        let mut text = String::new();
        let mut numbers = Vec::new();
        for event in events {
            if let Event::Accept { number, .. } | Event::Undo { number } = &event {
                numbers.push(*number);
            }
            text.push_str(&Entry { at: at.clone(), event }.line());
        }
        self.append(text.as_bytes(), through)?;
        numbers.into_iter().try_for_each(|number| self.plan(session, number))
    }

    /// Writes the plan files that the session's log says there should be, and takes away what it took back.
    ///
    /// # Errors
    ///
    /// When one cannot be written.
    pub fn mend(&self, session: &Session) -> Result<(), FolderError> {
        (0..=session.accepted().len()).try_for_each(|number| self.plan(session, number))
    }

    fn append(&mut self, bytes: &[u8], through: bool) -> Result<(), FolderError> {
        let path = self.folder.join(LOG);
        let written = self.log.write_all(bytes).and_then(|()| match through {
            true => self.log.sync_data(),
            false => Ok(()),
        });
        if let Err(error) = written {
            // Half a line would be taken for the beginning of the next one.
            let _ = self.log.set_len(self.length);
            let _ = self.log.seek(SeekFrom::End(0));
            return Err(file_error("cannot write", &path)(error));
        }
        self.length += bytes.len() as u64;
        Ok(())
    }

    /// Writes one plan file, or takes it away when the plan was taken back.
    fn plan(&self, session: &Session, number: usize) -> Result<(), FolderError> {
        let path = self.folder.join(format!("{number}.json"));
        match session.plan_file(number) {
            Some(plan) => {
                // A plan is plain data with string keys; writing it as JSON does not fail.
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
        // Some file systems cannot lock; a session is worth more than the lock.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

fn file_error(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> FolderError {
    let path = path.to_path_buf();
    move |reason| FolderError::File { action, path, reason }
}
