//! Logs and records as files.

use std::collections::HashMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use longstep_files::{LOG_LIMIT, create_private_folder, read_bounded, read_to_limit, restrict};
use longstep_llm::LOG;

use super::{Durability, LogName, RecordKey, Store, StoreError};
use crate::id::{RunId, SessionId};

/// Maximum length of a record in bytes.
const LARGEST_RECORD: u64 = 1 << 20;

/// Logs and records as files, in the folder of the program's state: `sessions/NAME/session.jsonl` and
/// `runs/NAME.jsonl`, where `longstep chat` and `longstep run` have theirs, and `server/`.
///
/// The owner of a log holds a lock on its file, which ends with its program. Folders have mode 700, files 600.
#[derive(Debug)]
pub struct FileStore {
    sessions: PathBuf,
    runs: PathBuf,
    server: PathBuf,
    owned: Mutex<HashMap<LogName, Owned>>,
}

/// A log that this program owns.
#[derive(Debug)]
struct Owned {
    file: File,
    /// Length in bytes of the whole lines.
    length: u64,
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
            owned: Mutex::default(),
        };
        for folder in [
            &store.sessions,
            &store.runs,
            &store.server,
            &store.server.join("records"),
        ] {
            create_private_folder(folder).map_err(failed("cannot create", folder))?;
        }
        Ok(store)
    }

    /// Returns the folder of the server's own files.
    pub fn folder(&self) -> &Path {
        &self.server
    }

    fn path(&self, log: &LogName) -> PathBuf {
        match log {
            LogName::Session(id) => self.sessions.join(id.as_str()).join(LOG),
            LogName::Run(id) => self.runs.join(format!("{id}.jsonl")),
            LogName::Audit => self.server.join("audit.jsonl"),
        }
    }

    fn record_path(&self, key: &RecordKey) -> PathBuf {
        let (kind, id) = match key {
            RecordKey::Approval(id) => ("approval", id.as_str()),
            RecordKey::Use(id) => ("use", id.as_str()),
            RecordKey::Run(id) => ("run", id.as_str()),
        };
        self.server.join("records").join(format!("{kind}-{id}.json"))
    }

    fn owned(&self) -> MutexGuard<'_, HashMap<LogName, Owned>> {
        self.owned.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Store for FileStore {
    fn own(&self, log: &LogName) -> Result<(), StoreError> {
        let mut owned = self.owned();
        if owned.contains_key(log) {
            return Ok(());
        }
        let path = self.path(log);
        if let (LogName::Session(_), Some(folder)) = (log, path.parent()) {
            create_private_folder(folder).map_err(failed("cannot create", folder))?;
        }
        let own = opened(&path, &name_of(log))?;
        owned.insert(log.clone(), own);
        Ok(())
    }

    fn release(&self, log: &LogName) {
        self.owned().remove(log);
    }

    fn append(&self, log: &LogName, lines: &str, durability: Durability) -> Result<(), StoreError> {
        let path = self.path(log);
        let mut owned = self.owned();
        let own = owned.get_mut(log).ok_or_else(|| StoreError::Busy(name_of(log)))?;
        let added = own.length + lines.len() as u64;
        if added > LOG_LIMIT {
            return Err(StoreError::TooLarge(name_of(log)));
        }
        if let Err(error) = own.file.write_all(lines.as_bytes()) {
            // A partial line would corrupt the next one.
            let _ = own.file.set_len(own.length);
            let _ = own.file.seek(SeekFrom::End(0));
            return Err(failed("cannot write", &path)(error));
        }
        own.length = added;
        if durability == Durability::Later {
            return Ok(());
        }
        // Others may write while the disk works.
        let file = own.file.try_clone();
        drop(owned);
        let synced = file.and_then(|file| file.sync_data());
        synced.map_err(failed("cannot write", &path))
    }

    fn read(&self, log: &LogName) -> Result<Option<Vec<u8>>, StoreError> {
        let path = self.path(log);
        match read_bounded(&path, LOG_LIMIT) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(failed("cannot read", &path)(error)),
        }
    }

    fn sessions(&self) -> Result<Vec<SessionId>, StoreError> {
        let is_session = |name: &str| self.sessions.join(name).join(LOG).is_file();
        let names = names(&self.sessions)?.into_iter().filter(|name| is_session(name));
        Ok(names.filter_map(|name| SessionId::parse(&name)).collect())
    }

    fn runs(&self) -> Result<Vec<RunId>, StoreError> {
        let names = names(&self.runs)?.into_iter();
        Ok(names
            .filter_map(|name| RunId::parse(name.strip_suffix(".jsonl")?))
            .collect())
    }

    fn changed_at(&self, log: &LogName) -> Result<Option<jiff::Timestamp>, StoreError> {
        let path = self.path(log);
        match fs::metadata(&path).and_then(|metadata| metadata.modified()) {
            // A time outside of the calendar is no time.
            Ok(time) => Ok(jiff::Timestamp::try_from(time).ok()),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(failed("cannot read", &path)(error)),
        }
    }

    fn insert(&self, key: &RecordKey, value: &str) -> Result<bool, StoreError> {
        let path = self.record_path(key);
        // The record has its name only when all of it is on the disk, and a name is given once.
        let name = crate::id::random(8).map_err(|error| failed("cannot name", &path)(error.into()))?;
        let draft = path.with_extension(name);
        let written = write_new(&draft, value).and_then(|()| fs::hard_link(&draft, &path));
        let _ = fs::remove_file(&draft);
        match written {
            Ok(()) => {
                let folder = File::open(self.server.join("records")).and_then(|folder| folder.sync_all());
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

/// Opens a log to add to it, and locks it. A last line that is not whole is removed: nobody acted on it.
fn opened(path: &Path, name: &str) -> Result<Owned, StoreError> {
    let file = OpenOptions::new().read(true).append(true).create(true).open(path);
    let mut file = file.map_err(failed("cannot open", path))?;
    restrict(&file).map_err(failed("cannot write", path))?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => return Err(StoreError::Busy(name.to_owned())),
        Err(TryLockError::Error(error)) => return Err(failed("cannot lock", path)(error)),
    }
    let bytes = read_to_limit(&mut file, LOG_LIMIT).map_err(failed("cannot read", path))?;
    let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
    let length = whole as u64;
    if whole < bytes.len() {
        file.set_len(length).map_err(failed("cannot write", path))?;
    }
    Ok(Owned { file, length })
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

fn name_of(log: &LogName) -> String {
    match log {
        LogName::Session(id) => format!("session `{id}`"),
        LogName::Run(id) => format!("run `{id}`"),
        LogName::Audit => "the audit log".to_owned(),
    }
}

fn failed(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> StoreError {
    let path = path.to_path_buf();
    move |reason| StoreError::File { action, path, reason }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::ApprovalId;

    fn store(folder: &tempfile::TempDir) -> FileStore {
        FileStore::open(&folder.path().join("sessions")).unwrap()
    }

    #[test]
    fn a_log_has_one_owner_and_whole_lines() {
        let folder = tempfile::tempdir().unwrap();
        let (one, other) = (store(&folder), store(&folder));
        let log = LogName::Session(SessionId::parse("s").unwrap());
        assert!(matches!(
            one.append(&log, "no owner\n", Durability::Now),
            Err(StoreError::Busy(_))
        ));
        assert!(one.read(&log).unwrap().is_none());
        one.own(&log).unwrap();
        one.own(&log).unwrap();
        one.append(&log, "a\nb\n", Durability::Now).unwrap();
        assert!(matches!(other.own(&log), Err(StoreError::Busy(_))));
        one.release(&log);
        let torn = folder.path().join("sessions/s").join(LOG);
        OpenOptions::new()
            .append(true)
            .open(&torn)
            .unwrap()
            .write_all(b"torn")
            .unwrap();
        other.own(&log).unwrap();
        other.append(&log, "c\n", Durability::Later).unwrap();
        assert_eq!(other.read(&log).unwrap().unwrap(), b"a\nb\nc\n");
        assert_eq!(other.sessions().unwrap(), [SessionId::parse("s").unwrap()]);
    }

    #[test]
    fn a_record_is_written_once_by_one_of_many() {
        let folder = tempfile::tempdir().unwrap();
        let key = RecordKey::Use(ApprovalId::parse("a").unwrap());
        let first = std::thread::scope(|scope| {
            let writers: Vec<_> = (0..8)
                .map(|number| {
                    let (store, key) = (store(&folder), key.clone());
                    scope.spawn(move || store.insert(&key, &number.to_string()).is_ok_and(|written| written))
                })
                .collect();
            writers
                .into_iter()
                .map(|writer| writer.join().unwrap())
                .filter(|written| *written)
                .count()
        });
        assert_eq!(first, 1);
        assert!(store(&folder).record(&key).unwrap().is_some());
    }
}
