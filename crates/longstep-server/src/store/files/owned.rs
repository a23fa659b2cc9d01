//! A file that this program may add to.

use std::collections::{HashMap, HashSet};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use longstep_files::{LOG_LIMIT, restrict};

use super::{failed, tail};
use crate::store::{Durability, LogName, OwnedLog, StoreError};

/// The logs that this program owns.
#[derive(Debug, Clone, Default)]
pub(super) struct Registry(Arc<Mutex<Owned>>);

#[derive(Debug, Default)]
struct Owned {
    now: HashSet<LogName>,
    /// The number of times that a log was owned, for those that can be owned again.
    epochs: HashMap<LogName, u64>,
}

impl Registry {
    fn owned(&self) -> MutexGuard<'_, Owned> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the epoch of a log, and whether it is owned now.
    pub(super) fn epoch(&self, log: &LogName) -> (u64, bool) {
        let owned = self.owned();
        let epoch = owned.epochs.get(log).copied().unwrap_or_default();
        (epoch, owned.now.contains(log))
    }

    fn begin(&self, log: &LogName) -> u64 {
        let mut owned = self.owned();
        owned.now.insert(log.clone());
        let epoch = owned.epochs.entry(log.clone()).or_default();
        *epoch += 1;
        *epoch
    }

    fn end(&self, log: &LogName) {
        self.owned().now.remove(log);
    }
}

/// A file that this program may add to. The lock ends when it is dropped.
#[derive(Debug)]
pub(super) struct OwnedFile {
    path: PathBuf,
    log: LogName,
    registry: Registry,
    epoch: u64,
    written: Mutex<Written>,
}

#[derive(Debug)]
struct Written {
    file: File,
    /// Length in bytes of the whole lines.
    length: u64,
}

impl OwnedFile {
    /// Opens a file and locks it. A last line that is not whole is removed: nobody acted on it.
    pub(super) fn open(path: PathBuf, log: &LogName, registry: &Registry) -> Result<Self, StoreError> {
        let file = OpenOptions::new().read(true).append(true).create(true).open(&path);
        let mut file = file.map_err(failed("cannot open", &path))?;
        restrict(&file).map_err(failed("cannot write", &path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(StoreError::Open(log.words())),
            Err(TryLockError::Error(error)) => return Err(failed("cannot lock", &path)(error)),
        }
        let length = tail::whole_length(&mut file).map_err(failed("cannot read", &path))?;
        let is_torn = file.metadata().map_or(true, |metadata| metadata.len() > length);
        if is_torn {
            file.set_len(length).map_err(failed("cannot write", &path))?;
        }
        Ok(Self {
            epoch: registry.begin(log),
            path,
            log: log.clone(),
            registry: registry.clone(),
            written: Mutex::new(Written { file, length }),
        })
    }

    fn written(&self) -> MutexGuard<'_, Written> {
        self.written.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl OwnedLog for OwnedFile {
    fn length(&self) -> u64 {
        self.written().length
    }

    fn epoch(&self) -> u64 {
        self.epoch
    }

    fn append(&self, lines: &str, durability: Durability) -> Result<(), StoreError> {
        let mut written = self.written();
        let added = written.length + lines.len() as u64;
        if added > LOG_LIMIT {
            return Err(StoreError::TooLarge(self.log.words()));
        }
        if let Err(error) = written.file.write_all(lines.as_bytes()) {
            // A partial line would corrupt the next one.
            let length = written.length;
            let _ = written.file.set_len(length);
            let _ = written.file.seek(SeekFrom::End(0));
            return Err(failed("cannot write", &self.path)(error));
        }
        written.length = added;
        if durability == Durability::Later {
            return Ok(());
        }
        // Others may write while the disk works.
        let file = written.file.try_clone();
        drop(written);
        let synced = file.and_then(|file| file.sync_data());
        synced.map_err(failed("cannot write", &self.path))
    }

    fn is_lost(&self) -> bool {
        false
    }
}

impl Drop for OwnedFile {
    fn drop(&mut self) {
        // A run that never began leaves nothing. Still locked: nobody else adds to it.
        if matches!(self.log, LogName::Run(_)) && self.length() == 0 {
            let _ = fs::remove_file(&self.path);
        }
        self.registry.end(&self.log);
    }
}
