//! The answers of an interview that was interrupted: a private file in the state folder.

use std::path::PathBuf;

use longstep_files::{create_private_folder, read_bounded, session_directory, write_whole};
use serde::{Deserialize, Serialize};

/// Limit for the file in bytes; a longer interview is not kept.
const LIMIT: u64 = 256 << 10;

/// The answers, and the folder of the domain that they are for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct KeptAnswers {
    pub(super) folder: String,
    pub(super) answers: Vec<String>,
}

fn path() -> Option<PathBuf> {
    Some(session_directory().ok()?.with_file_name("new-domain.json"))
}

impl KeptAnswers {
    /// Reads the kept answers; none if there are none, or if the file is not ours.
    pub(super) fn read() -> Option<Self> {
        let text = read_bounded(&path()?, LIMIT).ok()?;
        let kept: Self = serde_json::from_slice(&text).ok()?;
        (!kept.answers.is_empty()).then_some(kept)
    }

    /// Keeps the answers. They are a convenience, so a full disk does not stop the interview.
    pub(super) fn write(&self) {
        let (Some(path), Ok(text)) = (path(), serde_json::to_vec(self)) else {
            return;
        };
        if text.len() as u64 <= LIMIT {
            let created = path.parent().map_or(Ok(()), create_private_folder);
            let _ = created.and_then(|()| write_whole(&path, &text));
        }
    }

    /// Removes the kept answers.
    pub(super) fn remove() {
        if let Some(path) = path() {
            let _ = std::fs::remove_file(path);
        }
    }
}
