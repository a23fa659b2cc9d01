//! Files of one folder that belong together, written as a whole.

use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

use crate::text_file::plain_reason;
use crate::whole_file::write_whole;

/// A set of files that cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileSetError {
    /// A file of this name has another origin.
    #[error("{} exists, and another program or a person wrote it", .0.display())]
    Foreign(PathBuf),
    /// An error of the operating system.
    #[error("cannot write {}: {}", .0.display(), plain_reason(.1))]
    Io(PathBuf, #[source] Error),
}

impl FileSetError {
    /// The next step for the user.
    pub fn hint(&self) -> &'static str {
        match self {
            Self::Foreign(_) => "name another folder, or move the file away",
            Self::Io(..) => "check that the folder can be made, and is writable",
        }
    }
}

/// Writes files that belong together into a folder, and returns their paths.
///
/// A new folder appears with all files or not at all. In an existing folder each file is replaced as a whole, and the last one is
/// there only while all others belong to it: it is removed first and written last. An existing file is replaced only if it is equal
/// or begins with `mark`, the first line of every file of this origin; nothing is written otherwise.
///
/// # Errors
///
/// [`FileSetError::Foreign`] for a file that was not written here; [`FileSetError::Io`] if the folder or a file cannot be written.
///
/// ```
/// let there = tempfile::tempdir()?;
/// let folder = there.path().join("task");
/// let files = [("a.txt", "; ours\n1\n"), ("b.txt", "; ours\n2\n")];
/// let paths = longstep_files::write_file_set(&folder, "; ours\n", &files)?;
/// assert_eq!(paths, [folder.join("a.txt"), folder.join("b.txt")]);
/// std::fs::write(&paths[0], "; mine\n")?;
/// assert!(longstep_files::write_file_set(&folder, "; ours\n", &files).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_file_set(folder: &Path, mark: &str, files: &[(&str, &str)]) -> Result<Vec<PathBuf>, FileSetError> {
    let paths: Vec<PathBuf> = files.iter().map(|(name, _)| folder.join(name)).collect();
    let texts = files.iter().map(|(_, text)| *text);
    // A link that leads nowhere counts as there.
    if folder.symlink_metadata().is_ok() {
        replace(&paths, mark, texts)?;
    } else {
        create(folder, files)?;
    }
    Ok(paths)
}

fn create(folder: &Path, files: &[(&str, &str)]) -> Result<(), FileSetError> {
    let parent = match folder.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let failed = |error| FileSetError::Io(folder.to_owned(), error);
    std::fs::create_dir_all(parent).map_err(|error| FileSetError::Io(parent.to_owned(), error))?;
    let beside = tempfile::Builder::new()
        .prefix(".longstep-")
        .tempdir_in(parent)
        .map_err(failed)?;
    for (name, text) in files {
        write_whole(&beside.path().join(name), text.as_bytes()).map_err(failed)?;
    }
    std::fs::rename(beside.path(), folder).map_err(failed)?;
    // Nothing of this name is left to remove.
    let _ = beside.keep();
    Ok(())
}

fn replace<'t>(
    paths: &[PathBuf],
    mark: &str,
    texts: impl Iterator<Item = &'t str> + Clone,
) -> Result<(), FileSetError> {
    for (path, text) in paths.iter().zip(texts.clone()) {
        match std::fs::read(path) {
            Ok(there) if there.starts_with(mark.as_bytes()) || there == text.as_bytes() => {}
            Ok(_) => return Err(FileSetError::Foreign(path.clone())),
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => return Err(FileSetError::Io(path.clone(), error)),
        }
    }
    if let Some(last) = paths.last() {
        match std::fs::remove_file(last) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(FileSetError::Io(last.clone(), error)),
            _ => {}
        }
    }
    for (path, text) in paths.iter().zip(texts) {
        write_whole(path, text.as_bytes()).map_err(|error| FileSetError::Io(path.clone(), error))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const MARK: &str = "; ours\n";

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_set_makes_its_folder_and_leaves_nothing_else() {
        let there = tempfile::tempdir().unwrap();
        let folder = there.path().join("a/b");
        let paths = write_file_set(&folder, MARK, &[("x", "; ours\n1"), ("y", "; ours\n2")]).unwrap();
        assert_eq!(paths, [folder.join("x"), folder.join("y")]);
        assert_eq!(names(&folder), ["x", "y"]);
        assert_eq!(names(&there.path().join("a")), ["b"]);
    }

    #[test]
    fn a_file_set_replaces_its_own_files_only() {
        let there = tempfile::tempdir().unwrap();
        let folder = there.path();
        write_file_set(folder, MARK, &[("x", "; ours\n1"), ("y", "; ours\n2")]).unwrap();
        write_file_set(folder, MARK, &[("x", "; ours\n3"), ("y", "; ours\n4")]).unwrap();
        assert_eq!(std::fs::read_to_string(folder.join("y")).unwrap(), "; ours\n4");
        std::fs::write(folder.join("y"), "mine").unwrap();
        let error = write_file_set(folder, MARK, &[("x", "; ours\n5"), ("y", "; ours\n6")]).unwrap_err();
        assert!(
            matches!(&error, FileSetError::Foreign(path) if *path == folder.join("y")),
            "{error}"
        );
        // Nothing was written.
        assert_eq!(std::fs::read_to_string(folder.join("x")).unwrap(), "; ours\n3");
        write_file_set(folder, MARK, &[("x", "; ours\n5"), ("y", "mine")]).unwrap();
        assert_eq!(names(folder), ["x", "y"]);
    }

    #[test]
    #[cfg(unix)]
    fn a_file_set_that_cannot_be_written_leaves_no_last_file() {
        let there = tempfile::tempdir().unwrap();
        let folder = there.path();
        write_file_set(folder, MARK, &[("x", "; ours\n1"), ("y", "; ours\n2")]).unwrap();
        std::fs::remove_file(folder.join("x")).unwrap();
        std::os::unix::fs::symlink("nowhere/x", folder.join("x")).unwrap();
        let error = write_file_set(folder, MARK, &[("x", "; ours\n3"), ("y", "; ours\n4")]).unwrap_err();
        assert!(
            matches!(&error, FileSetError::Io(path, _) if *path == folder.join("x")),
            "{error}"
        );
        assert_eq!(names(folder), ["x"]);
        let file = folder.join("file");
        std::fs::write(&file, "").unwrap();
        assert!(write_file_set(&file, MARK, &[("x", "")]).is_err());
        assert!(write_file_set(&file.join("under"), MARK, &[("x", "")]).is_err());
    }
}
