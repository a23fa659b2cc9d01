//! Where models and engine states are kept.

use std::path::PathBuf;

use etcetera::{BaseStrategy, choose_base_strategy};

use crate::ModelError;

/// The folder for models and engine states: `LONGSTEP_CACHE` if it is set and not empty, else
/// `longstep` in the platform's cache folder (`~/.cache` on Linux, or `XDG_CACHE_HOME`).
///
/// The folder need not exist yet.
///
/// # Errors
///
/// [`ModelError::NoCacheDirectory`] when neither the variable nor a home folder is known.
pub fn cache_directory() -> Result<PathBuf, ModelError> {
    if let Some(named) = std::env::var_os("LONGSTEP_CACHE").filter(|value| !value.is_empty()) {
        return Ok(PathBuf::from(named));
    }
    let platform = choose_base_strategy().map_err(|_| ModelError::NoCacheDirectory)?;
    Ok(platform.cache_dir().join("longstep"))
}
