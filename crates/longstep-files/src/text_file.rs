//! Text files of users: domains, environments, plans.

use std::collections::BTreeMap;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

use crate::bounded::read_text_bounded;

/// Limit of bytes for a text file: 64 MiB. Environments, plans and domains are smaller.
const TEXT_LIMIT: u64 = 64 << 20;

/// A file or folder that cannot be read. `Display` is one line with the path; [`TextFileError::hint`] is the next step
/// for the user.
#[derive(Debug)]
pub struct TextFileError {
    path: PathBuf,
    reason: Error,
}

impl TextFileError {
    /// An error of the operating system for a path.
    pub fn new(path: impl Into<PathBuf>, reason: Error) -> Self {
        Self {
            path: path.into(),
            reason,
        }
    }

    /// The file or folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The next step for the user, if there is one.
    pub fn hint(&self) -> Option<&'static str> {
        match self.reason.kind() {
            ErrorKind::FileTooLarge => Some("check the path: environments, plans and domains are smaller"),
            ErrorKind::InvalidData => Some("save it as UTF-8"),
            _ => Some("check the path"),
        }
    }
}

impl std::fmt::Display for TextFileError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let path = self.path.display();
        match self.reason.kind() {
            ErrorKind::IsADirectory => write!(f, "{path} is a folder, not a file"),
            ErrorKind::FileTooLarge => write!(f, "{path} is larger than {} MiB", TEXT_LIMIT >> 20),
            ErrorKind::InvalidData => write!(f, "{path} is not a text file (not UTF-8)"),
            _ => write!(f, "cannot read {path}: {}", plain_reason(&self.reason)),
        }
    }
}

impl std::error::Error for TextFileError {}

/// The text of an I/O error without the number of the operating system, and without a capital letter.
///
/// ```
/// let error = std::fs::File::open("no/such/file").unwrap_err();
/// assert_eq!(longstep_files::plain_reason(&error), "no such file or directory");
/// ```
pub fn plain_reason(error: &Error) -> String {
    let text = error.to_string();
    let text = text.split(" (os error").next().unwrap_or_default();
    let mut letters = text.chars();
    let first = letters.next().map(|letter| letter.to_ascii_lowercase());
    first.into_iter().chain(letters).collect()
}

/// Reads a text file of at most 64 MiB, without the byte order mark that some editors put at its beginning.
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let file = tempfile::NamedTempFile::new()?;
/// std::fs::write(&file, "\u{feff}never opened(fridge)\n")?;
/// assert_eq!(longstep_files::read_text(file.path())?, "never opened(fridge)\n");
/// # Ok(()) }
/// ```
///
/// # Errors
///
/// When it cannot be read, is a folder, is larger, or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, TextFileError> {
    // Some systems open a folder like a file.
    let read = std::fs::metadata(path).and_then(|metadata| {
        if metadata.is_dir() {
            Err(ErrorKind::IsADirectory.into())
        } else {
            read_text_bounded(path, TEXT_LIMIT)
        }
    });
    read.map_err(|error| TextFileError::new(path, error))
}

/// Reads the text files of a folder whose names `wanted` accepts, by name. Skips hidden files.
///
/// # Errors
///
/// When the folder or one of the files cannot be read.
pub fn read_texts(folder: &Path, wanted: impl Fn(&str) -> bool) -> Result<BTreeMap<String, String>, TextFileError> {
    let failed = |error: Error| TextFileError::new(folder, error);
    let mut texts = BTreeMap::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
            continue;
        };
        if path.is_file() && !name.starts_with('.') && wanted(name) {
            texts.insert(name.to_owned(), read_text(&path)?);
        }
    }
    Ok(texts)
}
