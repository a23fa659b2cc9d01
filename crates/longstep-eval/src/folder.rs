//! A run on the disk, written so that it can be cut off at any point and taken up again.
//!
//! `run.json` says what is run, `results.jsonl` holds the attempts, `timings.jsonl` what they took. The lines of a unit
//! are written together, the timings first, in the order of the units: what is there is always the beginning of the
//! whole, and a unit that is there in part is dropped and run again.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use longstep::session::Settings;
use longstep_llm::{LOG_LIMIT, create_private_folder, read_bounded, tighten_folder, write_whole};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::attempt::{Attempt, Key, Timing};
use crate::run::Lines;

/// The version of the files.
pub const VERSION: u32 = 1;

/// Everything that a run's results depend on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The version of the files.
    pub version: u32,
    /// The program's version.
    pub longstep: String,
    /// The suite's name.
    pub suite: String,
    /// SHA-256 of its files.
    pub suite_sha256: String,
    /// The domain's name, or its folder.
    pub domain: String,
    /// SHA-256 of its files, prompts included.
    pub domain_sha256: String,
    /// The model, as it was named.
    pub model: String,
    /// SHA-256 of its file, of the recording, or of the recorded replies, where it is one of these.
    pub model_sha256: Option<String>,
    /// Which server has it, if one does; [`RunFolder::open`] sets it.
    #[serde(default)]
    pub server: Option<ServerMark>,
    /// How sessions went about it.
    pub settings: Settings,
    /// How freely the model chose its words.
    pub temperature: f64,
    /// Of the likeliest words, only those that make up this share.
    pub top_p: Option<f64>,
    /// The seed of the first trial; each further one has the next.
    pub seed: u64,
    /// How often each case was run.
    pub trials: u32,
    /// Only cases with all of these tags; every case if there are none.
    pub tags: Vec<String>,
    /// Only these cases; every case if there are none.
    pub cases: Vec<String>,
    /// Only these wordings; all that a case has if there are none.
    pub wordings: Vec<String>,
    /// What was changed in the domain or its prompts for this run, in words.
    pub changes: Vec<String>,
}

/// A mark of a server's address: SHA-256 of a random salt and the address. Within a folder, equal marks mean equal
/// servers; marks of two folders cannot be compared.
///
/// The address cannot be read from it. Whoever guesses the address can check the guess, and short addresses of a local
/// network are guessed quickly.
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

    /// Marks a server for a new folder.
    fn salted(address: &str) -> Result<Self, getrandom::Error> {
        let mut salt = [0; 16];
        getrandom::fill(&mut salt)?;
        Ok(Self::new(&hexadecimal(&salt), address))
    }
}

/// The first 16 bytes in hexadecimal digits.
fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().take(16).map(|byte| format!("{byte:02x}")).collect()
}

/// What a run has come to so far.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// What was run.
    pub plan: Plan,
    /// In the order in which they were run.
    pub attempts: Vec<Attempt>,
    /// What they took.
    pub timings: BTreeMap<Key, Timing>,
}

/// Why a run's folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// A file cannot be read or written.
    #[error("cannot {what} {}: {error}", .path.display())]
    File {
        /// What was tried.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// Why not.
        error: std::io::Error,
    },
    /// A file is not what it should be.
    #[error("{}:{line}: {reason}", .path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Its line.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// The folder holds another run.
    #[error("{} holds another run: {}", .path.display(), .differing.join(", "))]
    Another {
        /// The folder.
        path: PathBuf,
        /// In what it differs.
        differing: Vec<String>,
    },
}

impl FolderError {
    /// What to do about it.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::File { .. } => None,
            Self::Damaged { .. } => {
                Some("it was written by something else, or by hand; begin a new run with --out FOLDER")
            }
            Self::Another { .. } => {
                Some("keep this run in a folder of its own with --out FOLDER, or delete the other one")
            }
        }
    }
}

const PLAN: &str = "run.json";
const RESULTS: &str = "results.jsonl";
const TIMINGS: &str = "timings.jsonl";

/// The files of a run's folder, reports included.
const FILES: [&str; 5] = [PLAN, RESULTS, TIMINGS, "report.html", "report.md"];

/// A run's folder that is written to.
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
    /// Opens a run's folder, or makes it for its owner alone. Returns what has been run, as far as units are whole:
    /// `units` says how many steps each of them has, in order, with the key of its first. `server` is the address of the
    /// model's server; only its [`ServerMark`] is written down.
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
        // What was written in part goes before anything is added.
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

    /// How many units, from the first on, were there as a whole when the folder was opened.
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
/// When the folder holds none, or one that cannot be read. A last line that was cut off is left out.
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

/// How many units are there as a whole, from the first on, and how many attempts those are.
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

/// In what two runs differ, in words.
fn differing(known: &Plan, plan: &Plan) -> Vec<String> {
    let value = |plan: &Plan| serde_json::to_value(plan).unwrap_or_default();
    let (known, plan) = (value(known), value(plan));
    let entries = known.as_object().into_iter().flatten();
    entries
        .filter(|(key, value)| plan.get(key) != Some(value))
        .map(|(key, value)| {
            if key == "server" {
                return "the model's server is another one".to_owned();
            }
            let now = plan.get(key).cloned().unwrap_or_default();
            format!("{key} was {value} and is {now}")
        })
        .collect()
}

fn pretty<T: Serialize>(value: &T) -> String {
    // Plain data with string keys; writing it as JSON does not fail.
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

/// The lines of a file; none if it is not there. A last line without an end was cut off, and is left out.
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
