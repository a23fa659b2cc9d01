//! Domains with their prompts, from folders and by name.

use std::path::Path;

use longstep::domain::{self, Domain, Files};
use longstep_files::{DomainError, domain_files, overlay_prompt};

/// Loads a shipped domain by name, or any domain by the path of its folder.
///
/// ```
/// assert_eq!(longstep_llm::load_domain("household")?.name, "household");
/// let error = longstep_llm::load_domain("houshold").unwrap_err();
/// assert_eq!(error.to_string(), "there is no domain `houshold`");
/// assert_eq!(error.hint().as_deref(), Some("did you mean `household`?"));
/// # Ok::<(), longstep_files::DomainError>(())
/// ```
///
/// # Errors
///
/// When there is no such domain, or its files cannot be read, have errors or contradict each other.
pub fn load_domain(name: &str) -> Result<Domain, DomainError> {
    from_files(name, &domain_files(name)?)
}

/// Loads a domain as [`load_domain`] does, with prompt files of another folder in place of its own.
///
/// # Errors
///
/// As [`load_domain`]; also when the folder cannot be read, or no domain has a file of that name.
pub fn load_domain_with_prompt(name: &str, prompt: &Path) -> Result<Domain, DomainError> {
    let mut files = domain_files(name)?;
    overlay_prompt(&mut files, prompt)?;
    from_files(name, &files)
}

fn from_files(name: &str, files: &Files) -> Result<Domain, DomainError> {
    let mut domain = domain::load(files)?;
    // A session's log can be read from any working directory, so it names the whole path.
    if domain::shipped_files(name).is_none()
        && let Ok(folder) = std::path::absolute(name)
    {
        domain.origin = folder.display().to_string();
    }
    Ok(domain)
}
