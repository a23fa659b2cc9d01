//! Private files and folders: readable by their owner alone, whatever the umask is. On platforms without such modes the
//! defaults apply.

use std::fs::File;
use std::path::Path;

/// Creates a folder and its missing parents with mode 700. An existing folder keeps its mode.
///
/// # Errors
///
/// When it cannot be created.
pub fn create_private_folder(path: &Path) -> std::io::Result<()> {
    let mut builder = std::fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.recursive(true).create(path)
}

/// Sets a file's mode to 600.
///
/// # Errors
///
/// When the mode cannot be set.
#[cfg(unix)]
pub fn restrict(file: &File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o600))
}

#[cfg(not(unix))]
pub fn restrict(_: &File) -> std::io::Result<()> {
    Ok(())
}

/// Removes the permissions of group and others from a folder of the program and its files. If the folder holds a file
/// for which `ours` is false, it belongs to the user: it keeps its mode, and only our files change. Files of another
/// user cannot be changed and stay as they are.
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
        if entry.file_name().to_str().is_some_and(&ours) {
            owner_only(&entry.path())
        } else {
            all_ours = false
        }
    }
    if all_ours {
        owner_only(folder);
    }
}

/// Only Unix has modes.
#[cfg(not(unix))]
pub fn tighten_folder(_: &Path, _: impl Fn(&str) -> bool) {}
