//! Folders and files that hold what people said: for their owner alone, whatever the umask is. Where the platform has no
//! such modes, its defaults hold.

use std::fs::File;
use std::path::Path;

/// Makes a folder and the ones above it that are missing, each for its owner alone (mode 700). One that is there stays
/// as it is.
///
/// # Errors
///
/// When it cannot be made.
pub fn create_private_folder(path: &Path) -> std::io::Result<()> {
    let mut builder = std::fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.recursive(true).create(path)
}

/// Takes a file away from everybody but its owner (mode 600).
///
/// # Errors
///
/// When the mode cannot be set.
#[cfg(unix)]
pub(crate) fn restrict(file: &File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o600))
}

#[cfg(not(unix))]
pub(crate) fn restrict(_: &File) -> std::io::Result<()> {
    Ok(())
}

/// Takes a folder of our own, and the files in it, away from everybody but their owner. A folder that holds anything else
/// than `ours` is somebody's own: it keeps its mode, and the files that are ours lose theirs. What belongs to another
/// user cannot be changed and stays.
#[cfg(unix)]
pub fn tighten_folder(folder: &Path, ours: impl Fn(&str) -> bool) {
    use std::os::unix::fs::PermissionsExt;
    let owner_only = |path: &Path| {
        if let Ok(there) = std::fs::symlink_metadata(path)
            && (there.is_file() || there.is_dir())
            && there.permissions().mode() & 0o077 != 0
        {
            let mode = there.permissions().mode() & 0o700;
            let _ = std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode));
        }
    };
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut all_ours = true;
    for entry in entries.flatten() {
        match entry.file_name().to_str().is_some_and(&ours) {
            true => owner_only(&entry.path()),
            false => all_ours = false,
        }
    }
    if all_ours {
        owner_only(folder);
    }
}

/// Modes are for Unix.
#[cfg(not(unix))]
pub fn tighten_folder(_: &Path, _: impl Fn(&str) -> bool) {}
