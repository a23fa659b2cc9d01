//! Model files and their verified hashes.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::ModelError;
use crate::catalogue::Entry;

/// Size, modification time and hash, saved beside a verified file, so that a gigabyte is not hashed at every start.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Note {
    bytes: u64,
    modified_nanoseconds: u128,
    sha256: String,
}

impl Note {
    fn of(path: &Path, sha256: String) -> Result<Self, ModelError> {
        let (bytes, modified_nanoseconds) = size_and_time(path)?;
        Ok(Self {
            bytes,
            modified_nanoseconds,
            sha256,
        })
    }

    fn path(model: &Path) -> PathBuf {
        model.with_extension("gguf.verified")
    }

    fn read(model: &Path) -> Option<Self> {
        let text = std::fs::read(Self::path(model)).ok()?;
        serde_json::from_slice(&text).ok()
    }

    /// Writes the note. Without it the next start hashes the file again, which is only slow.
    fn write(&self, model: &Path) {
        if let Ok(text) = serde_json::to_vec(self) {
            let _ = std::fs::write(Self::path(model), text);
        }
    }
}

fn size_and_time(path: &Path) -> Result<(u64, u128), ModelError> {
    let metadata = std::fs::metadata(path).map_err(ModelError::file("cannot read", path))?;
    let modified = metadata.modified().map_err(ModelError::file("cannot read", path))?;
    let since = modified.duration_since(UNIX_EPOCH).unwrap_or_default();
    Ok((metadata.len(), since.as_nanos()))
}

/// Checks that the file matches the entry, by its note or by hashing it.
pub(super) fn check(entry: &Entry, path: &Path) -> Result<(), ModelError> {
    let expected = Note::of(path, entry.sha256.to_owned())?;
    if Note::read(path).as_ref() == Some(&expected) {
        return Ok(());
    }
    let (got, _) = hash_file(path)?;
    let got = hexadecimal(got);
    if got != entry.sha256 {
        return Err(wrong(entry, &path.display().to_string(), got));
    }
    expected.write(path);
    Ok(())
}

fn wrong(entry: &Entry, place: &str, got: String) -> ModelError {
    ModelError::WrongHash {
        name: entry.name,
        place: place.to_owned(),
        expected: entry.sha256,
        got,
    }
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

fn hash_file(path: &Path) -> Result<(Sha256, u64), ModelError> {
    let mut file = File::open(path).map_err(ModelError::file("cannot read", path))?;
    let mut hash = Sha256::new();
    let mut buffer = vec![0; 1 << 20];
    let mut bytes = 0;
    loop {
        let read = file.read(&mut buffer).map_err(ModelError::file("cannot read", path))?;
        let Some(part) = buffer.get(..read).filter(|part| !part.is_empty()) else {
            return Ok((hash, bytes));
        };
        hash.update(part);
        bytes += read as u64;
    }
}

/// A model file that is hashed while it is written.
pub(super) struct HashedFile {
    path: PathBuf,
    file: File,
    hash: Sha256,
    written: u64,
}

impl HashedFile {
    /// Creates a new file.
    pub(super) fn create(path: PathBuf) -> Result<Self, ModelError> {
        let file = File::create(&path).map_err(ModelError::file("cannot write", &path))?;
        Ok(Self {
            path,
            file,
            hash: Sha256::new(),
            written: 0,
        })
    }

    /// Continues an existing file, or creates a new one.
    pub(super) fn resume(path: PathBuf) -> Result<Self, ModelError> {
        if !path.exists() {
            return Self::create(path);
        }
        let (hash, written) = hash_file(&path)?;
        let file = File::options()
            .append(true)
            .open(&path)
            .map_err(ModelError::file("cannot write", &path))?;
        Ok(Self {
            path,
            file,
            hash,
            written,
        })
    }

    /// Empties the file and starts again.
    pub(super) fn restart(&mut self) -> Result<(), ModelError> {
        self.file
            .set_len(0)
            .and_then(|()| self.file.seek(SeekFrom::Start(0)))
            .map_err(ModelError::file("cannot write", &self.path))?;
        self.hash = Sha256::new();
        self.written = 0;
        Ok(())
    }

    pub(super) fn write(&mut self, part: &[u8]) -> Result<(), ModelError> {
        self.file
            .write_all(part)
            .map_err(ModelError::file("cannot write", &self.path))?;
        self.hash.update(part);
        self.written += part.len() as u64;
        Ok(())
    }

    /// Bytes written so far.
    pub(super) fn written(&self) -> u64 {
        self.written
    }

    /// Renames the file to its final name if its hash matches; otherwise removes it.
    pub(super) fn finish(self, entry: &Entry, path: &Path, source: &str) -> Result<(), ModelError> {
        let got = hexadecimal(self.hash);
        if got != entry.sha256 {
            drop(self.file);
            std::fs::remove_file(&self.path).map_err(ModelError::file("cannot remove", &self.path))?;
            return Err(wrong(entry, source, got));
        }
        // After a power failure, a file under its final name must be complete.
        self.file
            .sync_all()
            .map_err(ModelError::file("cannot write", &self.path))?;
        drop(self.file);
        std::fs::rename(&self.path, path).map_err(ModelError::file("cannot write", path))?;
        Note::of(path, got)?.write(path);
        Ok(())
    }
}

/// A cheap fingerprint of a file: a hash of its path, size, modification time, and first and last mebibyte.
#[cfg_attr(not(feature = "embedded"), allow(dead_code))]
pub(crate) fn identity(path: &Path) -> Result<String, ModelError> {
    const SAMPLE: u64 = 1 << 20;
    let cannot = || ModelError::file("cannot read", path);
    let (bytes, modified) = size_and_time(path)?;
    let place = path.canonicalize().map_err(cannot())?;
    let mut file = File::open(path).map_err(cannot())?;
    let mut sample = Vec::new();
    (&file).take(SAMPLE).read_to_end(&mut sample).map_err(cannot())?;
    file.seek(SeekFrom::Start(bytes.saturating_sub(SAMPLE)))
        .map_err(cannot())?;
    file.take(SAMPLE).read_to_end(&mut sample).map_err(cannot())?;
    let mut hash = Sha256::new();
    hash.update(format!("{}\n{bytes}\n{modified}\n", place.display()));
    hash.update(&sample);
    Ok(hexadecimal(hash))
}
