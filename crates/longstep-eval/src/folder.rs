//! A run on the disk, which can be interrupted at any point and resumed.
//!
//! `run.json` describes the run, `results.jsonl` contains the attempts, and `timings.jsonl` their durations. The lines
//! of a unit are written together, timings first, in the order of the units. So a folder always contains the beginning
//! of a run, and an incomplete unit is removed and run again.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use longstep::session::Settings;
use longstep_files::{LOG_LIMIT, create_private_folder, read_bounded, tighten_folder, write_whole};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::attempt::{Attempt, Key, Timing};
use crate::run::Lines;

/// The version of the file formats.
pub const VERSION: u32 = 1;

/// Everything that the results of a run depend on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The version of the file formats.
    pub version: u32,
    /// The version of the program.
    pub longstep: String,
    /// The suite's name.
    pub suite: String,
    /// SHA-256 of its files.
    pub suite_sha256: String,
    /// The domain's name, or its folder.
    pub domain: String,
    /// SHA-256 of its files, prompts included.
    pub domain_sha256: String,
    /// The model, as the user named it.
    pub model: String,
    /// SHA-256 of the model file, the recording or the recorded replies, if the model is one of these.
    pub model_sha256: Option<String>,
    /// The adapters of an embedded model: `catalogue`, `off`, or SHA-256 of the files.
    #[serde(default = "of_the_catalogue")]
    pub adapters: String,
    /// Mark of the model's server, if it has one; set by [`RunFolder::open`].
    #[serde(default)]
    pub server: Option<ServerMark>,
    /// Settings of the sessions.
    pub settings: Settings,
    /// Sampling temperature of the model.
    pub temperature: f64,
    /// Nucleus sampling: total probability of the most likely tokens that are kept.
    pub top_p: Option<f64>,
    /// Seed of the first trial; each further trial adds 1.
    pub seed: u64,
    /// Number of trials of each case.
    pub trials: u32,
    /// Selected cases: those with all of these tags; empty means all.
    pub tags: Vec<String>,
    /// Selected cases by id; empty means all.
    pub cases: Vec<String>,
    /// Selected wordings; empty means all wordings of a case.
    pub wordings: Vec<String>,
    /// Descriptions of the changes of the domain or its prompts for this run.
    pub changes: Vec<String>,
}

/// The adapters of a run that was kept before there were any others.
fn of_the_catalogue() -> String {
    "catalogue".to_owned()
}

/// A mark of a server's address: SHA-256 of a random salt and the address. Within a folder, equal marks mean equal
/// servers; marks of different folders are not comparable.
///
/// The address cannot be derived from it, but a guess can be checked, and short addresses of a local network are
/// quickly guessed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ServerMark {
    /// 32 hexadecimal digits.
    pub salt: String,
    /// 32 hexadecimal digits: half of the hash.
    pub hash: String,
}

impl ServerMark {
    fn new(salt: &str, address: &str) -> Self {
        let mut hash = Sha256::new();
        hash.update("longstep run.json server\0");
        hash.update(salt);
        hash.update([0]);
        hash.update(address);
        Self {
            salt: salt.to_owned(),
            hash: hexadecimal(&hash.finalize()),
        }
    }

    /// Marks a server with a new salt.
    fn salted(address: &str) -> Result<Self, getrandom::Error> {
        let mut salt = [0; 16];
        getrandom::fill(&mut salt)?;
        Ok(Self::new(&hexadecimal(&salt), address))
    }
}

/// The first 16 bytes, in hexadecimal digits.
fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().take(16).map(|byte| format!("{byte:02x}")).collect()
}

/// The results of a run so far.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Results {
    /// The description of the run.
    pub plan: Plan,
    /// The attempts, in the order of the run.
    pub attempts: Vec<Attempt>,
    /// Durations of the attempts.
    pub timings: BTreeMap<Key, Timing>,
}

/// Reason why a run's folder cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FolderError {
    /// A file cannot be read or written.
    #[error("cannot {what} {}: {error}", .path.display())]
    File {
        /// The action.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        error: std::io::Error,
    },
    /// A file has invalid content.
    #[error("{}:{line}: {reason}", .path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Number of the line.
        line: usize,
        /// The reason.
        reason: String,
    },
    /// The folder holds another run.
    #[error("{} contains another run: {}", .path.display(), .differing.join(", "))]
    Another {
        /// The folder.
        path: PathBuf,
        /// The differences.
        differing: Vec<String>,
    },
}

impl FolderError {
    /// The next step for the user.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::File { .. } => None,
            Self::Damaged { .. } => Some("the file was damaged or edited: begin a new run with `--out FOLDER`"),
            Self::Another { .. } => Some("use another folder with `--out FOLDER`, or delete the other run"),
        }
    }
}

const PLAN: &str = "run.json";
const RESULTS: &str = "results.jsonl";
const TIMINGS: &str = "timings.jsonl";

/// The files of a run's folder, including reports.
const FILES: [&str; 5] = [PLAN, RESULTS, TIMINGS, "report.html", "report.md"];

/// A run's folder, open for writing.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    results: File,
    timings: File,
    units_done: usize,
}

fn failed(what: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> FolderError {
    move |error| FolderError::File {
        what,
        path: path.to_path_buf(),
        error,
    }
}

impl RunFolder {
    /// Opens a run's folder, or creates it with mode 700. Returns the results of all complete units. `units` contains
    /// the number of steps of each unit, in order, with the key of its first step. `server` is the address of the
    /// model's server; only its [`ServerMark`] is saved.
    ///
    /// # Errors
    ///
    /// When the folder holds another run, or cannot be read or written.
    pub fn open(
        path: &Path,
        plan: &Plan,
        server: Option<&str>,
        units: &[(Key, usize)],
    ) -> Result<(Self, Results), FolderError> {
        create_private_folder(path).map_err(failed("make", path))?;
        tighten_folder(path, |name| FILES.contains(&name));
        let plan_file = path.join(PLAN);
        let mut plan = plan.clone();
        if plan_file.exists() {
            let known = read_plan(path)?;
            plan.server = server.map(|address| {
                let salt = known.server.as_ref().map_or("", |mark| &mark.salt);
                ServerMark::new(salt, address)
            });
            let differing = differing(&known, &plan);
            if !differing.is_empty() {
                return Err(FolderError::Another {
                    path: path.to_path_buf(),
                    differing,
                });
            }
        } else {
            let mark = server.map(ServerMark::salted).transpose();
            plan.server = mark.map_err(|error| failed("mark the server in", &plan_file)(error.into()))?;
            let text = format!("{}\n", pretty(&plan));
            write_whole(&plan_file, text.as_bytes()).map_err(failed("write", &plan_file))?;
        }
        let (results, timings) = (path.join(RESULTS), path.join(TIMINGS));
        let mut attempts: Vec<Attempt> = lines(&results)?;
        let mut timed: Vec<Timing> = lines(&timings)?;
        let (units_done, whole) = whole_units(&attempts, units);
        attempts.truncate(whole);
        timed.truncate(whole);
        // Incomplete units are removed before anything is added.
        rewrite(&results, &attempts)?;
        rewrite(&timings, &timed)?;
        let append = |path: &Path| {
            OpenOptions::new()
                .append(true)
                .open(path)
                .map_err(failed("write", path))
        };
        let folder = Self {
            path: path.to_path_buf(),
            results: append(&results)?,
            timings: append(&timings)?,
            units_done,
        };
        let results = Results {
            plan,
            attempts,
            timings: timed.into_iter().map(|timing| (timing.key.clone(), timing)).collect(),
        };
        Ok((folder, results))
    }

    /// The number of complete units at the time of opening.
    pub fn units_done(&self) -> usize {
        self.units_done
    }

    /// Adds the attempts of a unit.
    ///
    /// # Errors
    ///
    /// When they cannot be written.
    pub fn add(&mut self, unit: &Lines) -> Result<(), FolderError> {
        let timings: String = unit.iter().map(|(_, timing)| line(timing)).collect();
        let attempts: String = unit.iter().map(|(attempt, _)| line(attempt)).collect();
        let path = self.path.clone();
        let write = |file: &mut File, name: &str, text: &str| {
            let kept = file.write_all(text.as_bytes()).and_then(|()| file.sync_data());
            kept.map_err(failed("write", &path.join(name)))
        };
        write(&mut self.timings, TIMINGS, &timings)?;
        write(&mut self.results, RESULTS, &attempts)
    }
}

/// Reads a run.
///
/// # Errors
///
/// When the folder contains no run, or the run cannot be read. An incomplete last line is ignored.
pub fn read(path: &Path) -> Result<Results, FolderError> {
    let timed: Vec<Timing> = lines(&path.join(TIMINGS))?;
    Ok(Results {
        plan: read_plan(path)?,
        attempts: lines(&path.join(RESULTS))?,
        timings: timed.into_iter().map(|timing| (timing.key.clone(), timing)).collect(),
    })
}

fn read_plan(path: &Path) -> Result<Plan, FolderError> {
    let file = path.join(PLAN);
    let bytes = read_bounded(&file, LOG_LIMIT).map_err(failed("read", &file))?;
    serde_json::from_slice(&bytes).map_err(|error| FolderError::Damaged {
        line: error.line(),
        reason: error.to_string(),
        path: file,
    })
}

/// The number of complete units from the first on, and the number of their attempts.
fn whole_units(attempts: &[Attempt], units: &[(Key, usize)]) -> (usize, usize) {
    let (mut done, mut whole) = (0, 0);
    for (first, steps) in units {
        let there = attempts[whole..]
            .iter()
            .take(*steps)
            .enumerate()
            .filter(|(step, attempt)| {
                let key = &attempt.key;
                key.step == *step && (&key.case, &key.wording, key.trial) == (&first.case, &first.wording, first.trial)
            });
        if there.count() < *steps {
            break;
        }
        done += 1;
        whole += steps;
    }
    (done, whole)
}

/// The differences between two runs, as text.
fn differing(known: &Plan, plan: &Plan) -> Vec<String> {
    let value = |plan: &Plan| serde_json::to_value(plan).unwrap_or_default();
    let (known, plan) = (value(known), value(plan));
    let entries = known.as_object().into_iter().flatten();
    entries
        .filter(|(key, value)| plan.get(key) != Some(value))
        .map(|(key, value)| {
            if key == "server" {
                return "the model's server is different".to_owned();
            }
            let now = plan.get(key).cloned().unwrap_or_default();
            format!("{key} was {value} and is {now}")
        })
        .collect()
}

fn pretty<T: Serialize>(value: &T) -> String {
    // Plain data with string keys; its serialization does not fail.
    serde_json::to_string_pretty(value).unwrap_or_default()
}

fn line<T: Serialize>(value: &T) -> String {
    format!("{}\n", serde_json::to_string(value).unwrap_or_default())
}

fn rewrite<T: Serialize>(path: &Path, all: &[T]) -> Result<(), FolderError> {
    let text: String = all.iter().map(line).collect();
    if std::fs::read(path).is_ok_and(|known| known == text.as_bytes()) {
        return Ok(());
    }
    write_whole(path, text.as_bytes()).map_err(failed("write", path))
}

/// The lines of a file; none if it does not exist. A last line without a line end is incomplete and ignored.
fn lines<T: serde::de::DeserializeOwned>(path: &Path) -> Result<Vec<T>, FolderError> {
    let bytes = match read_bounded(path, LOG_LIMIT) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(failed("read", path)(error)),
    };
    let text = String::from_utf8_lossy(&bytes);
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    let lines = whole.lines().enumerate().filter(|(_, line)| !line.is_empty());
    lines
        .map(|(number, line)| {
            serde_json::from_str(line).map_err(|error| FolderError::Damaged {
                path: path.to_path_buf(),
                line: number + 1,
                reason: error.to_string(),
            })
        })
        .collect()
}
