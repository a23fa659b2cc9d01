//! Domain folders, and the shipped domains by name.

use std::collections::BTreeMap;
use std::path::Path;

use longstep_model::diagnostic::{Diagnostics, nearest};
use longstep_model::domain::{self, Files};

use crate::text_file::{TextFileError, read_text, read_texts};

/// Files that every domain has.
const REQUIRED: [&str; 4] = ["domain.pddl", "domain.toml", "prompt/goal.md", "prompt/examples.toml"];

/// Reason why a domain cannot be loaded. [`DomainError::hint`] is the next step for the user.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DomainError {
    /// Neither a shipped domain nor a folder has this name.
    #[error("there is no domain `{0}`")]
    Unknown(String),
    /// A file cannot be read.
    #[error(transparent)]
    File(#[from] TextFileError),
    /// The files have errors or contradict each other.
    #[error(transparent)]
    Findings(#[from] Diagnostics),
}

impl DomainError {
    /// The next step for the user, if there is one; findings have hints of their own.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Unknown(name) => {
                let shipped = domain::shipped_names();
                Some(match nearest(name, shipped.iter().copied()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!(
                        "use a shipped domain ({}) or the path of a domain's folder",
                        shipped.join(", ")
                    ),
                })
            }
            Self::File(error) => error.hint().map(str::to_owned),
            Self::Findings(_) => None,
        }
    }
}

/// Reads the files of a shipped domain by its name, or of any domain by the path of its folder.
///
/// ```
/// let files = longstep_files::domain_files("household")?;
/// assert_eq!(longstep_model::domain::load(&files)?.name, "household");
/// let error = longstep_files::domain_files("houshold").unwrap_err();
/// assert_eq!(error.hint().as_deref(), Some("did you mean `household`?"));
/// # Ok::<(), longstep_files::DomainError>(())
/// ```
///
/// # Errors
///
/// When there is no such domain, or a file cannot be read.
pub fn domain_files(name: &str) -> Result<Files, DomainError> {
    if let Some(shipped) = domain::shipped_files(name) {
        return Ok(shipped);
    }
    let folder = Path::new(name);
    if !folder.is_dir() {
        return Err(DomainError::Unknown(name.to_owned()));
    }
    let skills = skills_file(folder)?;
    if let Some((path, text)) = &skills
        && let Some(base) = Files::base_of(path, text)?
    {
        let base = domain::shipped_files(&base).ok_or(DomainError::Unknown(base))?;
        return Ok(Files { skills, ..base });
    }
    let prompt = prompt_files(&folder.join("prompt"))?;
    let mut texts: Vec<(String, String)> = prompt
        .into_iter()
        .map(|(name, text)| (format!("prompt/{name}"), text))
        .collect();
    for file in REQUIRED {
        if !texts.iter().any(|(path, _)| path == file) {
            texts.push((file.to_owned(), read_text(&folder.join(file))?));
        }
    }
    Ok(Files {
        skills,
        ..Files::from_texts(prefix(folder), texts)
    })
}

/// The path and the text of `skills.toml`, which a domain need not have.
fn skills_file(folder: &Path) -> Result<Option<(String, String)>, TextFileError> {
    let path = folder.join("skills.toml");
    if path.exists() {
        Ok(Some((path.display().to_string(), read_text(&path)?)))
    } else {
        Ok(None)
    }
}

/// Replaces prompt files of a domain by those of another folder; see [`Files::overlay`].
///
/// # Errors
///
/// When a file cannot be read, or no domain has a file of that name.
pub fn overlay_prompt(files: &mut Files, folder: &Path) -> Result<(), DomainError> {
    Ok(files.overlay(&prefix(folder), prompt_files(folder)?)?)
}

/// The texts of a folder of prompt files, by name, without the backups of editors.
fn prompt_files(folder: &Path) -> Result<BTreeMap<String, String>, TextFileError> {
    read_texts(folder, |name| !name.ends_with('~'))
}

/// The path of a folder in findings, with one slash at its end.
fn prefix(folder: &Path) -> String {
    format!("{}/", folder.display().to_string().trim_end_matches('/'))
}
