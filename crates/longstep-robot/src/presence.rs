//! The presence of a robot's program, which may outlive this one.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant, SystemTime};

use longstep_core::{secret, visible};
use serde::{Deserialize, Serialize};

use crate::error::RobotError;
use crate::{lock, processes};

/// The beginning and the end of the names of presence files.
const NAME: (&str, &str) = ("program-", ".alive");
/// Maximum length of a presence file.
const LARGEST: u64 = 64 << 10;
/// The time for the end of a program whose Longstep has just ended.
const PATIENCE: Duration = Duration::from_secs(1);
/// The time between two looks at such a program.
const TICK: Duration = Duration::from_millis(20);
/// The most processes that a message names.
const NAMED: usize = 5;

/// The presence file of a robot's program. The program and its children inherit the open file with its lock, so that the file
/// is locked as long as one of them runs, also after this program was killed. It names the robot that the program drives.
///
/// A program without orders has an empty file, and drives nothing.
#[derive(Debug)]
pub struct Presence {
    path: PathBuf,
    /// None after the end of the program.
    file: Option<File>,
    record: Record,
}

/// The content of a presence file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Record {
    /// The parts of the robot, by the names of their locks.
    robots: Vec<String>,
    /// The command line for people.
    command: String,
    /// The command line with its folder, hashed: it may hold a password.
    key: String,
    /// The number of the process, which is the one of its group too.
    process: u32,
    /// The time at which the process began; none where that is not known.
    started: Option<processes::Moment>,
    /// The process that ends the program after this one; it drives nothing.
    guard: Option<u32>,
}

impl Presence {
    /// Creates the presence file of a program that is not started yet, and removes the files of programs that ended.
    pub(crate) fn create(folder: &Path, command: &str, key: &str) -> io::Result<Self> {
        static NEXT: AtomicU64 = AtomicU64::new(0);

        alive(folder)?;
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let name = format!(
            "{}{}-{}-{}",
            NAME.0,
            std::process::id(),
            since.unwrap_or_default().as_nanos(),
            NEXT.fetch_add(1, Ordering::SeqCst)
        );
        let new = folder.join(format!("{name}.new"));
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(&new)?;
        file.try_lock()?;
        // Under its last name the file was never without its lock.
        let path = folder.join(name + NAME.1);
        fs::rename(&new, &path)?;
        Ok(Self {
            path,
            file: Some(file),
            record: Record {
                robots: Vec::new(),
                command: secret::redacted(command).into_owned(),
                key: hashed(key),
                process: 0,
                started: None,
                guard: None,
            },
        })
    }

    /// The file that the program has to inherit.
    pub(crate) fn file(&self) -> Option<&File> {
        self.file.as_ref()
    }

    /// Sets the process of the program, and of the one that ends it after this program.
    pub(crate) fn set_processes(&mut self, process: u32, guard: u32) {
        self.record.process = process;
        self.record.started = processes::begun(process);
        self.record.guard = Some(guard);
    }

    /// Writes the robot that the program drives from now on.
    pub(crate) fn declare(&self, robots: &[String]) -> io::Result<()> {
        let Some(mut file) = self.file.as_ref() else {
            return Ok(());
        };
        let record = Record {
            robots: robots.to_vec(),
            ..self.record.clone()
        };
        let mut text = serde_json::to_string(&record)?;
        text.push('\n');
        file.write_all(text.as_bytes())
    }

    /// Removes the file after the end of the program. If the robot did not confirm that it stands still, the file stays as long
    /// as a process of the program runs.
    pub(crate) fn end(&mut self, is_confirmed: bool) {
        self.file = None;
        let is_dead = || matches!(look(&self.path), Ok(Found::Dead));
        if is_confirmed || is_dead() {
            // A file that stays is removed before the next program is started.
            let _ = fs::remove_file(&self.path);
        }
    }
}

impl Drop for Presence {
    fn drop(&mut self) {
        self.end(false);
    }
}

fn hashed(key: &str) -> String {
    format!("{:016x}", lock::hash(key))
}

/// The state of the program of a presence file.
enum Found {
    /// It ended.
    Dead,
    /// It runs, without orders.
    Idle,
    /// It runs, and drives a robot.
    Driving(Record),
}

/// Looks at the program of a presence file.
fn look(path: &Path) -> io::Result<Found> {
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Found::Dead),
        Err(error) => return Err(error),
    };
    let is_locked = match file.try_lock_shared() {
        Ok(()) => false,
        Err(TryLockError::WouldBlock) => true,
        Err(TryLockError::Error(error)) => return Err(error),
    };
    let mut text = String::new();
    (&file).take(LARGEST).read_to_string(&mut text)?;
    if text.is_empty() {
        return Ok(if is_locked { Found::Idle } else { Found::Dead });
    }
    let record: Record = serde_json::from_str(&text)?;
    // A program may close what it inherited, as `sudo` does.
    let is_alive = is_locked || !survivors(&record).is_empty();
    Ok(if is_alive { Found::Driving(record) } else { Found::Dead })
}

fn survivors(record: &Record) -> Vec<u32> {
    match &record.started {
        Some(started) => processes::in_group(record.process, started, record.guard),
        None => Vec::new(),
    }
}

/// Returns the programs in a folder that drive robots. Removes the files of those that ended.
fn alive(folder: &Path) -> io::Result<Vec<(PathBuf, Record)>> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if name.starts_with(NAME.0) && name.ends_with(NAME.1) {
            paths.push(path);
        }
    }
    paths.sort();
    let mut alive = Vec::new();
    for path in paths {
        let place = |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
        match look(&path).map_err(place)? {
            Found::Dead => {
                // Another program may have removed it, or will.
                let _ = fs::remove_file(&path);
            }
            Found::Idle => {}
            Found::Driving(record) => alive.push((path, record)),
        }
    }
    Ok(alive)
}

/// Fails if a program of an earlier run, which has ended, still drives one of the robots. Waits a moment for its end. The locks of
/// these robots must have been taken.
pub(crate) fn refuse_robots(folder: &Path, own: Option<&Presence>, robots: &[String]) -> Result<(), RobotError> {
    let is_own = |path: &Path| own.is_some_and(|own| own.path == path);
    let drives = |record: &Record| robots.iter().find(|robot| record.robots.contains(robot)).cloned();
    refuse(
        folder,
        &|path, record| drives(record).filter(|_| !is_own(path)),
        &|_| Ok(()),
    )
}

/// Fails if a program with this command line still drives a robot: for another run, or for an earlier one, which has ended.
pub(crate) fn refuse_command(folder: &Path, key: &str) -> Result<(), RobotError> {
    let key = hashed(key);
    let drives = |_: &Path, record: &Record| record.robots.first().filter(|_| record.key == key).cloned();
    // The lock is free if the run has ended that drove the robot.
    refuse(folder, &drives, &|robot| lock::take(robot, folder).map(drop))
}

fn refuse(
    folder: &Path,
    drives: &dyn Fn(&Path, &Record) -> Option<String>,
    check: &dyn Fn(&str) -> Result<(), RobotError>,
) -> Result<(), RobotError> {
    let begun = Instant::now();
    loop {
        let alive = alive(folder).map_err(|error| RobotError::Unreachable {
            robot: folder.display().to_string(),
            reason: format!(
                "the programs that drive robots are not known: {error}; if no robot moves, remove this file"
            ),
        })?;
        let mut found = alive.iter();
        let Some((robot, path, record)) =
            found.find_map(|(path, record)| drives(path, record).map(|robot| (robot, path, record)))
        else {
            return Ok(());
        };
        check(&robot)?;
        if begun.elapsed() >= PATIENCE {
            let program = described(path, record);
            return Err(RobotError::Abandoned { robot, program });
        }
        std::thread::sleep(TICK);
    }
}

/// Returns the processes of a program for a message: `process 1234 (python3 robot.py)`.
fn described(path: &Path, record: &Record) -> String {
    let mut numbers = survivors(record);
    numbers.extend(processes::holding(path));
    numbers.sort_unstable();
    numbers.dedup();
    let more = numbers.len().saturating_sub(NAMED);
    let shown: Vec<String> = numbers.iter().take(NAMED).map(u32::to_string).collect();
    let named = match (numbers.len(), more) {
        (0, _) => "a process that cannot be named".to_owned(),
        (1, _) => format!("process {}", shown.join(", ")),
        (_, 0) => format!("processes {}", shown.join(", ")),
        _ => format!("processes {} and {more} more", shown.join(", ")),
    };
    format!("{named} ({})", visible::line(&record.command))
}
