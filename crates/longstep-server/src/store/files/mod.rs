//! Logs and records as files.

mod owned;
mod tail;

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use longstep_files::{LOG_LIMIT, create_private_folder, read_bounded, restrict};
use longstep_llm::LOG;
use sha2::{Digest, Sha256};

use self::owned::{OwnedFile, Registry};
use super::{LogName, LogState, OwnedLog, RecordKey, Store, StoreError, StoredRun};
use crate::id::{RunId, SessionId, hexadecimal};

/// Maximum length of a record in bytes.
const LARGEST_RECORD: u64 = 1 << 20;

/// The time after which a run has something in its log, if its program lives.
const BEGINNING: Duration = Duration::from_secs(60);

/// Logs and records as files, in the folder of the program's state: `sessions/NAME/session.jsonl` and
/// `runs/NAME.jsonl`, where `longstep chat` and `longstep run` have theirs, and `server/`.
///
/// The owner of a log holds a lock on its file, which ends with its program. Folders have mode 700, files 600.
#[derive(Debug)]
pub struct FileStore {
    sessions: PathBuf,
    runs: PathBuf,
    server: PathBuf,
    registry: Registry,
}

impl FileStore {
    /// Opens a store whose sessions are in a folder; runs and the files of the server are beside it.
    ///
    /// # Errors
    ///
    /// When a folder cannot be created.
    pub fn open(sessions: &Path) -> Result<Self, StoreError> {
        Self::open_named(sessions, "server")
    }

    /// Opens a store whose approvals and audit log are in the folder of this name, beside the sessions and the runs.
    ///
    /// # Errors
    ///
    /// When a folder cannot be created.
    pub fn open_named(sessions: &Path, name: &str) -> Result<Self, StoreError> {
        let state = sessions.parent().unwrap_or(sessions);
        let store = Self {
            sessions: sessions.to_owned(),
            runs: state.join("runs"),
            server: state.join(name),
            registry: Registry::default(),
        };
        for folder in [
            &store.sessions,
            &store.runs,
            &store.server,
            &store.records(),
            &store.server.join("robots"),
        ] {
            create_private_folder(folder).map_err(failed("cannot create", folder))?;
        }
        store.remove_runs_that_never_began()?;
        Ok(store)
    }

    /// Removes the empty logs of programs that were killed between taking a run and using its approval.
    fn remove_runs_that_never_began(&self) -> Result<(), StoreError> {
        for name in names(&self.runs)? {
            let path = self.runs.join(&name);
            let is_empty = fs::metadata(&path).is_ok_and(|metadata| {
                let age = metadata.modified().ok().and_then(|time| time.elapsed().ok());
                metadata.len() == 0 && age.is_some_and(|age| age > BEGINNING)
            });
            if let (true, Some(id)) = (is_empty, name.strip_suffix(".jsonl").and_then(RunId::parse)) {
                // Dropping one that is empty removes it; one in use is another program's.
                drop(OwnedFile::open(path, &LogName::Run(id), &self.registry));
            }
        }
        Ok(())
    }

    /// Returns the folder of the server's own files.
    pub fn folder(&self) -> &Path {
        &self.server
    }

    fn records(&self) -> PathBuf {
        self.server.join("records")
    }

    fn path(&self, log: &LogName) -> PathBuf {
        match log {
            LogName::Session(id) => self.sessions.join(id.as_str()).join(LOG),
            LogName::Run(id) => self.runs.join(format!("{id}.jsonl")),
            LogName::Audit => self.server.join("audit.jsonl"),
            LogName::Robot(key) => {
                // A key may have any letters.
                let name = hexadecimal(&Sha256::digest(key)[..16]);
                self.server.join("robots").join(format!("{name}.lock"))
            }
            LogName::Unit(key) => self.server.join("units").join(format!("{key}.lock")),
        }
    }

    fn record_path(&self, key: &RecordKey) -> PathBuf {
        let (kind, name) = key.parts();
        self.records().join(format!("{kind}-{name}.json"))
    }

    /// Returns a run with a record; none for a run of the command line.
    fn run(&self, id: RunId) -> Result<Option<StoredRun>, StoreError> {
        let Some(record) = self.record(&RecordKey::Run(id.clone()))? else {
            return Ok(None);
        };
        let log = LogName::Run(id);
        let Some(state) = self.state(&log)? else {
            return Ok(None);
        };
        Ok(Some(StoredRun {
            record,
            last: self.tail(&log, 1)?.pop(),
            state,
        }))
    }
}

impl Store for FileStore {
    fn is_shared(&self) -> bool {
        false
    }

    fn own(&self, log: &LogName) -> Result<Box<dyn OwnedLog>, StoreError> {
        let path = self.path(log);
        // Those of the other logs are there.
        if let (LogName::Session(_) | LogName::Unit(_), Some(folder)) = (log, path.parent()) {
            create_private_folder(folder).map_err(failed("cannot create", folder))?;
        }
        Ok(Box::new(OwnedFile::open(path, log, &self.registry)?))
    }

    fn state(&self, log: &LogName) -> Result<Option<LogState>, StoreError> {
        let path = self.path(log);
        let metadata = match fs::metadata(&path) {
            Ok(metadata) => metadata,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(failed("cannot read", &path)(error)),
        };
        let (epoch, is_owned) = self.registry.epoch(log);
        let changed = metadata.modified().ok();
        Ok(Some(LogState {
            length: metadata.len(),
            // A time outside of the calendar is no time.
            changed_at: changed.and_then(|time| jiff::Timestamp::try_from(time).ok()),
            epoch,
            is_owned,
        }))
    }

    fn read(&self, log: &LogName) -> Result<Option<Vec<u8>>, StoreError> {
        let path = self.path(log);
        match read_bounded(&path, LOG_LIMIT) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(failed("cannot read", &path)(error)),
        }
    }

    fn tail(&self, log: &LogName, limit: usize) -> Result<Vec<String>, StoreError> {
        let path = self.path(log);
        match File::open(&path).and_then(|mut file| tail::lines(&mut file, limit)) {
            Ok(lines) => Ok(lines),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Vec::new()),
            Err(error) => Err(failed("cannot read", &path)(error)),
        }
    }

    fn sessions(&self) -> Result<Vec<SessionId>, StoreError> {
        let is_session = |name: &str| self.sessions.join(name).join(LOG).is_file();
        let names = names(&self.sessions)?.into_iter().filter(|name| is_session(name));
        Ok(names.filter_map(|name| SessionId::parse(&name)).collect())
    }

    fn runs(&self, limit: usize) -> Result<Vec<StoredRun>, StoreError> {
        // Only names and times are read of those beyond the limit.
        let names = names(&self.runs)?.into_iter();
        let dated = names.filter_map(|name| {
            let id = RunId::parse(name.strip_suffix(".jsonl")?)?;
            let changed = fs::metadata(self.runs.join(&name)).and_then(|metadata| metadata.modified());
            let is_owned = self.registry.epoch(&LogName::Run(id.clone())).1;
            Some((is_owned, changed.unwrap_or(SystemTime::UNIX_EPOCH), id))
        });
        let mut dated: Vec<_> = dated.collect();
        dated.sort_by(|one, other| other.cmp(one));
        let mut runs = Vec::new();
        for (.., id) in dated {
            if runs.len() >= limit {
                break;
            }
            runs.extend(self.run(id)?);
        }
        Ok(runs)
    }

    fn insert(&self, key: &RecordKey, value: &str) -> Result<bool, StoreError> {
        let path = self.record_path(key);
        // The record has its name only when all of it is on the disk, and a name is given once.
        let name = crate::id::random(8).map_err(|error| failed("cannot name", &path)(error.into()))?;
        let draft = self.records().join(format!("{name}.draft"));
        let written = write_new(&draft, value).and_then(|()| fs::hard_link(&draft, &path));
        let _ = fs::remove_file(&draft);
        match written {
            Ok(()) => {
                let folder = File::open(self.records()).and_then(|folder| folder.sync_all());
                folder.map_err(failed("cannot write", &path))?;
                Ok(true)
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Ok(false),
            Err(error) => Err(failed("cannot write", &path)(error)),
        }
    }

    fn record(&self, key: &RecordKey) -> Result<Option<String>, StoreError> {
        let path = self.record_path(key);
        match read_bounded(&path, LARGEST_RECORD) {
            Ok(bytes) => Ok(Some(String::from_utf8_lossy(&bytes).into_owned())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(failed("cannot read", &path)(error)),
        }
    }
}

/// Writes a file that does not exist, with mode 600; it is on the disk when this returns.
fn write_new(path: &Path, text: &str) -> io::Result<()> {
    let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
    restrict(&file)?;
    file.write_all(text.as_bytes())?;
    file.sync_all()
}

fn names(folder: &Path) -> Result<Vec<String>, StoreError> {
    let entries = fs::read_dir(folder).map_err(failed("cannot read", folder))?;
    let names = entries
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok());
    let mut names: Vec<String> = names.collect();
    names.sort();
    Ok(names)
}

fn failed(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> StoreError {
    let path = path.to_path_buf();
    move |reason| StoreError::File { action, path, reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_logs_of_runs_are_removed_unless_they_are_new_or_in_use() {
        let folder = tempfile::tempdir().unwrap();
        let sessions = folder.path().join("sessions");
        let store = FileStore::open(&sessions).unwrap();
        let old = SystemTime::now() - 2 * BEGINNING;
        let log = |text: &str, is_old: bool| {
            let id = RunId::random().unwrap();
            let path = store.path(&LogName::Run(id));
            let mut file = File::create(&path).unwrap();
            file.write_all(text.as_bytes()).unwrap();
            if is_old {
                file.set_modified(old).unwrap();
            }
            path
        };
        let (never_began, new, begun, waiting) = (log("", true), log("", false), log("{}\n", true), log("", true));
        let in_use = File::open(&waiting).unwrap();
        in_use.try_lock().unwrap();
        FileStore::open(&sessions).unwrap();
        let is_there = [&never_began, &new, &begun, &waiting].map(|path| path.exists());
        assert_eq!(is_there, [false, true, true, true]);
    }
}
