//! Prefix cache on the disk: the computed state of a prompt, which the next start loads instead of computing it again.
//!
//! A state file is llama.cpp's format followed by a trailer of [`TRAILER`] bytes: the key of the prefix, the length and
//! a checksum. llama.cpp does not check what it loads, so a file without a matching trailer is not loaded.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use llama_cpp_2::context::LlamaContext;
use llama_cpp_2::token::LlamaToken;
use sha2::{Digest, Sha256};

use super::engine::SEQUENCE;
use longstep_files::create_private_folder;

/// Version of the engine that wrote a state; states of other versions are not loaded. Change it with llama-cpp-2 and
/// with the way that prompts are computed.
const ENGINE: &str = "llama-cpp-2 0.1.160, longstep 2";

/// Number of state files that are kept: those of two robots. One has eight prompts, if everything is used.
const KEPT: usize = 16;

const MAGIC: &[u8; 8] = b"LONGSTEP";
const TRAILER: usize = MAGIC.len() + 32 + 8 + 4;

/// Age after which the temporary file of a killed process is removed.
const ABANDONED: Duration = Duration::from_secs(3600);

/// The folder of the states of one model with one context size.
pub(super) struct States {
    folder: PathBuf,
    identity: String,
    context_tokens: u32,
}

/// The state file of one fixed prefix.
pub(super) struct StateFile {
    path: PathBuf,
    key: [u8; 32],
}

impl States {
    pub(super) fn new(folder: PathBuf, identity: String, context_tokens: u32) -> Self {
        Self {
            folder,
            identity,
            context_tokens,
        }
    }

    /// The state file for conversations that begin with these tokens.
    pub(super) fn file(&self, fixed: &[LlamaToken]) -> StateFile {
        let mut hash = Sha256::new();
        hash.update(format!("{ENGINE}\n{}\n{}\n", self.identity, self.context_tokens));
        for token in fixed {
            hash.update(token.0.to_le_bytes());
        }
        let key: [u8; 32] = hash.finalize().into();
        let name: String = key.iter().take(12).map(|byte| format!("{byte:02x}")).collect();
        StateFile {
            path: self.folder.join(format!("{name}.state")),
            key,
        }
    }
}

impl StateFile {
    /// Loads the saved state into an empty context and returns its tokens; `None` if there is no file or it is damaged.
    pub(super) fn load(&self, context: &mut LlamaContext<'_>) -> Option<Vec<LlamaToken>> {
        self.check().ok()?;
        let capacity = context.n_ctx() as usize;
        let (tokens, _) = context.state_seq_load_file(&self.path, SEQUENCE, capacity).ok()?;
        // The least recently used state is removed first; if the time cannot be updated, this one is removed earlier.
        let _ = File::options()
            .append(true)
            .open(&self.path)
            .and_then(|file| file.set_modified(SystemTime::now()));
        Some(tokens)
    }

    /// Saves the state of a context that holds these tokens.
    pub(super) fn save(&self, context: &LlamaContext<'_>, tokens: &[LlamaToken]) -> Result<(), String> {
        let folder = self.path.parent().ok_or("it has no folder")?;
        create_private_folder(folder).map_err(|error| error.to_string())?;
        let file = tempfile::Builder::new()
            .prefix(".saving-")
            .tempfile_in(folder)
            .map_err(|error| error.to_string())?;
        context
            .state_seq_save_file(file.path(), SEQUENCE, tokens)
            .map_err(|error| error.to_string())?;
        self.seal(file.path()).map_err(|error| error.to_string())?;
        file.persist(&self.path).map_err(|error| error.error.to_string())?;
        // Too many files only waste space; the next save tries again.
        let _ = prune(folder);
        Ok(())
    }

    /// Appends the trailer to a state that llama.cpp has written.
    fn seal(&self, path: &Path) -> io::Result<()> {
        let mut file = File::options().read(true).append(true).open(path)?;
        let length = file.metadata()?.len();
        let sum = checksum(&mut file, length)?;
        let mut trailer = Vec::with_capacity(TRAILER);
        trailer.extend_from_slice(MAGIC);
        trailer.extend_from_slice(&self.key);
        trailer.extend_from_slice(&length.to_le_bytes());
        trailer.extend_from_slice(&sum.to_le_bytes());
        file.write_all(&trailer)
    }

    /// Checks that the file is a complete state of this prefix.
    fn check(&self) -> io::Result<()> {
        let mut file = File::open(&self.path)?;
        let length = file
            .metadata()?
            .len()
            .checked_sub(TRAILER as u64)
            .ok_or(io::ErrorKind::UnexpectedEof)?;
        let sum = checksum(&mut file, length)?;
        let mut expected = Vec::with_capacity(TRAILER);
        expected.extend_from_slice(MAGIC);
        expected.extend_from_slice(&self.key);
        expected.extend_from_slice(&length.to_le_bytes());
        expected.extend_from_slice(&sum.to_le_bytes());
        let mut trailer = Vec::with_capacity(TRAILER);
        file.read_to_end(&mut trailer)?;
        if trailer == expected {
            Ok(())
        } else {
            Err(io::ErrorKind::InvalidData.into())
        }
    }
}

/// The checksum of the first `length` bytes. Leaves the file position behind them.
fn checksum(file: &mut File, length: u64) -> io::Result<u32> {
    file.seek(SeekFrom::Start(0))?;
    let mut hasher = crc32fast::Hasher::new();
    let mut buffer = vec![0; 1 << 20];
    let mut left = length;
    while left > 0 {
        let wanted = usize::try_from(left).map_or(buffer.len(), |left| left.min(buffer.len()));
        let part = buffer.get_mut(..wanted).ok_or(io::ErrorKind::InvalidData)?;
        file.read_exact(part)?;
        hasher.update(part);
        left -= wanted as u64;
    }
    Ok(hasher.finalize())
}

/// Removes the oldest states beyond [`KEPT`], and abandoned temporary files.
fn prune(folder: &Path) -> io::Result<()> {
    let now = SystemTime::now();
    let mut states = Vec::new();
    for entry in std::fs::read_dir(folder)?.flatten() {
        let Ok(modified) = entry.metadata().and_then(|metadata| metadata.modified()) else {
            continue;
        };
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.ends_with(".state") {
            states.push((modified, entry.path()));
        } else if name.starts_with(".saving-") && now.duration_since(modified).is_ok_and(|age| age > ABANDONED) {
            std::fs::remove_file(entry.path())?;
        }
    }
    states.sort();
    let surplus = states.len().saturating_sub(KEPT);
    for (_, path) in states.iter().take(surplus) {
        std::fs::remove_file(path)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sealed(folder: &Path, content: &[u8]) -> StateFile {
        let states = States::new(folder.to_path_buf(), "model".into(), 512);
        let file = states.file(&[LlamaToken(1), LlamaToken(2)]);
        std::fs::write(&file.path, content).unwrap();
        file.seal(&file.path).unwrap();
        file
    }

    #[test]
    fn state_file_check_rejects_damaged_or_foreign_states() {
        let folder = tempfile::tempdir().unwrap();
        let content: Vec<u8> = (0..3_000_000_u32).map(|number| number.to_le_bytes()[1]).collect();
        let file = sealed(folder.path(), &content);
        assert!(file.check().is_ok());
        let whole = std::fs::read(&file.path).unwrap();
        assert_eq!(whole.len(), content.len() + TRAILER);

        let mut flipped = whole.clone();
        flipped[1_500_000] ^= 1;
        let longer = [whole.clone(), vec![0]].concat();
        for damaged in [
            &whole[..whole.len() - 1],
            &whole[1..],
            &flipped,
            &longer,
            b"",
            b"LONGSTEP",
        ] {
            std::fs::write(&file.path, damaged).unwrap();
            assert!(file.check().is_err());
        }

        std::fs::write(&file.path, &whole).unwrap();
        let foreign = StateFile {
            path: file.path.clone(),
            key: [7; 32],
        };
        assert!(foreign.check().is_err());
    }

    #[test]
    fn state_key_depends_on_model_context_and_tokens() {
        let states = |identity: &str, size| States::new("s".into(), identity.into(), size);
        let tokens = [LlamaToken(1), LlamaToken(2)];
        let key = states("a", 512).file(&tokens).key;
        assert_eq!(key, states("a", 512).file(&tokens).key);
        assert_ne!(key, states("b", 512).file(&tokens).key);
        assert_ne!(key, states("a", 1024).file(&tokens).key);
        assert_ne!(key, states("a", 512).file(&tokens[..1]).key);
    }

    #[test]
    fn the_oldest_states_go_first() {
        let folder = tempfile::tempdir().unwrap();
        let written = KEPT + 4;
        for number in 0..written {
            let path = folder.path().join(format!("{number:02}.state"));
            std::fs::write(&path, b"x").unwrap();
            let age = Duration::from_secs(100) * u32::try_from(written - number).unwrap();
            let file = File::options().append(true).open(&path).unwrap();
            file.set_modified(SystemTime::now() - age).unwrap();
        }
        std::fs::write(folder.path().join(".saving-now"), b"x").unwrap();
        prune(folder.path()).unwrap();
        let mut left: Vec<_> = std::fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        left.sort();
        assert_eq!(left.len(), KEPT + 1);
        assert_eq!(left[1], "04.state");
    }

    #[test]
    fn the_engine_named_in_the_key_is_the_one_built() {
        let lock = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../Cargo.lock");
        let lock = std::fs::read_to_string(lock).unwrap();
        let version = lock.split("name = \"llama-cpp-2\"\nversion = \"").nth(1).unwrap();
        let version = version.split('"').next().unwrap();
        assert!(ENGINE.contains(version), "ENGINE must name llama-cpp-2 {version}");
    }
}
