//! Atomic writes to files; pipes, devices and sockets are written through.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::private;

/// Longest chain of symlinks that is followed; Linux has the same limit.
const LINKS: usize = 40;

/// Writes a file atomically: a reader finds the old content or all of `content`, even after a power failure.
///
/// A new file gets mode 600. An existing file keeps its mode, and is refused if it is not writable. For a symlink, the
/// file that it names is written, and the link stays. A pipe, a device or a socket is written to, never replaced; so is
/// a file named through `/proc` or `/dev/fd`, because a program has that file open.
///
/// # Errors
///
/// When the folder is missing or not writable, the file is not writable, or the disk is full.
pub fn write_whole(path: &Path, content: &[u8]) -> std::io::Result<()> {
    let (target, open_elsewhere) = followed(path)?;
    let there = match std::fs::metadata(path) {
        Ok(there) => Some(there),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => None,
        Err(error) => return Err(error),
    };
    match there {
        Some(there) if there.is_dir() => Err(std::io::ErrorKind::IsADirectory.into()),
        Some(there) if there.is_file() && !open_elsewhere => {
            // Renaming over a file needs no write permission for it.
            OpenOptions::new().write(true).open(path)?;
            replace(&target, content, Some(there.permissions()))
        }
        Some(_) => write_through(path, content),
        None => replace(&target, content, None),
    }
}

/// Follows symlinks to the final path. Also returns whether one of them leads through the open files of a program.
fn followed(path: &Path) -> std::io::Result<(PathBuf, bool)> {
    let mut target = path.to_path_buf();
    let mut open_elsewhere = false;
    for _ in 0..LINKS {
        open_elsewhere |= target.starts_with("/proc") || target.starts_with("/dev/fd");
        let Ok(named) = std::fs::read_link(&target) else {
            return Ok((target, open_elsewhere));
        };
        target = folder(&target).join(named);
    }
    Err(std::io::Error::other("too many symbolic links"))
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn replace(target: &Path, content: &[u8], permissions: Option<std::fs::Permissions>) -> std::io::Result<()> {
    let mut file = tempfile::Builder::new().tempfile_in(folder(target))?;
    match permissions {
        Some(permissions) => file.as_file().set_permissions(permissions)?,
        None => private::restrict(file.as_file())?,
    }
    file.write_all(content)?;
    file.as_file().sync_all()?;
    file.persist(target).map_err(|error| error.error)?;
    Ok(())
}

fn write_through(path: &Path, content: &[u8]) -> std::io::Result<()> {
    match OpenOptions::new().append(true).open(path) {
        Ok(mut file) => file.write_all(content),
        Err(error) => through_socket(path, content).unwrap_or(Err(error)),
    }
}

/// Writes to a socket; `None` if the path is not a socket.
#[cfg(unix)]
fn through_socket(path: &Path, content: &[u8]) -> Option<std::io::Result<()>> {
    use std::os::unix::fs::FileTypeExt;
    let socket = std::fs::metadata(path).is_ok_and(|there| there.file_type().is_socket());
    socket.then(|| std::os::unix::net::UnixStream::connect(path)?.write_all(content))
}

#[cfg(not(unix))]
fn through_socket(_: &Path, _: &[u8]) -> Option<std::io::Result<()>> {
    None
}

/// Opens a file for appending. A new file gets mode 600; an existing file, pipe or device keeps its mode.
///
/// # Errors
///
/// When the file cannot be created or written.
pub fn append(path: &Path) -> std::io::Result<File> {
    match OpenOptions::new().append(true).create_new(true).open(path) {
        Ok(file) => {
            private::restrict(&file)?;
            Ok(file)
        }
        // `create_new` fails on a symlink to a missing file; this way creates it.
        Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {
            let new = !path.exists();
            let file = OpenOptions::new().append(true).create(true).open(path)?;
            if new {
                private::restrict(&file)?;
            }
            Ok(file)
        }
        Err(error) => Err(error),
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::io::Read;
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};

    use super::*;

    fn mode(path: &Path) -> u32 {
        std::fs::metadata(path).unwrap().permissions().mode() & 0o7777
    }

    fn entries(folder: &Path) -> usize {
        std::fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn a_new_file_is_private_and_an_old_one_keeps_its_mode() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plan.json");
        write_whole(&path, b"one").unwrap();
        assert_eq!(mode(&path), 0o600);
        for kept in [0o644, 0o640, 0o755] {
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(kept)).unwrap();
            write_whole(&path, b"two").unwrap();
            assert_eq!((mode(&path), std::fs::read(&path).unwrap()), (kept, b"two".to_vec()));
        }
        assert_eq!(entries(folder.path()), 1);
    }

    #[test]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join("inside");
        std::fs::create_dir(&inside).unwrap();
        let (file, link, chain) = (
            inside.join("plan.json"),
            folder.path().join("link"),
            folder.path().join("chain"),
        );
        symlink("inside/plan.json", &link).unwrap();
        symlink("link", &chain).unwrap();
        // The first time, the target of the links does not exist.
        for content in [b"one", b"two"] {
            write_whole(&chain, content).unwrap();
            assert_eq!(std::fs::read(&file).unwrap(), content);
            assert!(link.is_symlink() && chain.is_symlink());
        }
        let ring = folder.path().join("ring");
        symlink("ring", &ring).unwrap();
        assert!(write_whole(&ring, b"x").is_err());
        assert!(ring.is_symlink());
    }

    #[test]
    fn pipes_devices_and_sockets_are_written_through() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(
            std::process::Command::new("mkfifo")
                .arg(&pipe)
                .status()
                .unwrap()
                .success()
        );
        let reader = {
            let pipe = pipe.clone();
            std::thread::spawn(move || std::fs::read(pipe).unwrap())
        };
        write_whole(&pipe, b"through a pipe").unwrap();
        assert_eq!(reader.join().unwrap(), b"through a pipe");
        assert!(std::fs::metadata(&pipe).unwrap().file_type().is_fifo());

        let socket = folder.path().join("socket");
        let listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        let reader = std::thread::spawn(move || {
            let mut text = String::new();
            listener.accept().unwrap().0.read_to_string(&mut text).unwrap();
            text
        });
        write_whole(&socket, b"through a socket").unwrap();
        assert_eq!(reader.join().unwrap(), "through a socket");

        let null = folder.path().join("null");
        symlink("/dev/null", &null).unwrap();
        write_whole(&null, b"gone").unwrap();
        assert!(null.is_symlink());
        assert!(std::fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    }

    #[test]
    fn a_folder_and_a_file_that_may_not_be_written_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        assert!(write_whole(folder.path(), b"x").is_err());
        assert!(write_whole(&folder.path().join("missing/plan.json"), b"x").is_err());
    }

    #[test]
    fn append_creates_private_files_and_keeps_existing_modes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("recording");
        append(&path).unwrap().write_all(b"one").unwrap();
        assert_eq!(mode(&path), 0o600);
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o644)).unwrap();
        append(&path).unwrap().write_all(b"two").unwrap();
        assert_eq!(
            (mode(&path), std::fs::read(&path).unwrap()),
            (0o644, b"onetwo".to_vec())
        );
        append(Path::new("/dev/null")).unwrap();
    }
}
