//! The folders for models, engine states and sessions.

use std::path::PathBuf;

use etcetera::{BaseStrategy, choose_base_strategy};

/// Neither a variable of Longstep nor a home folder names a place.
#[derive(Debug, thiserror::Error)]
#[error("no cache folder: neither `LONGSTEP_CACHE` nor a home folder is set")]
#[non_exhaustive]
pub struct NoHomeFolder;

impl NoHomeFolder {
    /// The next step for the user.
    pub fn hint(&self) -> &'static str {
        "set `LONGSTEP_CACHE` to a folder"
    }
}

/// The folder for models and engine states: `LONGSTEP_CACHE` if it is set and not empty, else
/// `longstep` in the platform's cache folder (`~/.cache` on Linux, or `XDG_CACHE_HOME`).
///
/// The folder need not exist yet.
///
/// # Errors
///
/// [`NoHomeFolder`] when neither the variable nor a home folder is known.
pub fn cache_directory() -> Result<PathBuf, NoHomeFolder> {
    if let Some(named) = std::env::var_os("LONGSTEP_CACHE").filter(|value| !value.is_empty()) {
        return Ok(PathBuf::from(named));
    }
    let platform = choose_base_strategy().map_err(|_| NoHomeFolder)?;
    Ok(platform.cache_dir().join("longstep"))
}

/// The folder for sessions: `LONGSTEP_SESSIONS` if it is set and not empty, else `longstep/sessions` in the platform's
/// state folder (`~/.local/state` on Linux, or `XDG_STATE_HOME`), or in its data folder where there is none for state.
///
/// The folder need not exist yet.
///
/// # Errors
///
/// [`NoHomeFolder`] when neither the variable nor a home folder is known.
pub fn session_directory() -> Result<PathBuf, NoHomeFolder> {
    if let Some(named) = std::env::var_os("LONGSTEP_SESSIONS").filter(|value| !value.is_empty()) {
        return Ok(PathBuf::from(named));
    }
    let platform = choose_base_strategy().map_err(|_| NoHomeFolder)?;
    let folder = platform.state_dir().unwrap_or_else(|| platform.data_dir());
    Ok(folder.join("longstep").join("sessions"))
}
