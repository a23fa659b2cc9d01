//! Robots that are killed in the middle of a run. The log says what was done and what is unknown, and a run that is resumed
//! repeats no step unasked.
//!
//! `LONGSTEP_VIRTUALHOME=$(scripts/robots/virtualhome.sh) LONGSTEP_PYROBOSIM=$(scripts/robots/pyrobosim.sh) \
//!     LONGSTEP_DEATHS=50 cargo test -p longstep-cli --test dead_robot -- --ignored --nocapture`
#![cfg(unix)]
#![allow(
    clippy::disallowed_macros,
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    missing_docs
)]

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::{check_log, ended, longstep};
use serde_json::Value;
use tempfile::TempDir;

/// The longest time that a run may take.
const LIMIT: Duration = Duration::from_secs(60);

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A robot that keeps its world in a file, as a real world is kept: it can be killed and started again.
trait Mortal {
    /// The domain of its plans.
    fn domain(&self) -> String;
    /// The environment in which the plan begins.
    fn environment(&self) -> PathBuf;
    /// The goal of the plan.
    fn goal(&self) -> &'static str;
    /// Starts the robot, unless the run does that itself; returns its name for `--robot`.
    fn start(&mut self, folder: &Path) -> String;
    /// Kills the robot; returns false if there is none yet.
    fn kill(&mut self, folder: &Path) -> bool;
}

/// The steps that were really performed, as the robot's world knows them.
fn performed(folder: &Path) -> Vec<Value> {
    let Ok(text) = fs::read_to_string(folder.join("state.json")) else {
        return Vec::new();
    };
    let state: Value = serde_json::from_str(&text).unwrap();
    state["performed"].as_array().unwrap().clone()
}

fn send(id: u32, signal: &str) -> bool {
    let mut command = Command::new("kill");
    command
        .args([&format!("-{signal}"), &id.to_string()])
        .stderr(Stdio::null());
    command.status().unwrap().success()
}

/// The exit codes of a robot that failed.
fn is_robot_failure(output: &Output) -> bool {
    output.status.code().is_some_and(|code| (51..60).contains(&code))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn events(log: &Path) -> Vec<Value> {
    let Ok(text) = fs::read_to_string(log) else {
        return Vec::new();
    };
    text.lines()
        .skip(1)
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

fn count(events: &[Value], name: &str) -> usize {
    events.iter().filter(|event| event["event"] == name).count()
}

/// The orders of which nobody knows whether they were done, by what the log says.
fn unknown(events: &[Value]) -> Vec<u64> {
    let stopped = events.iter().rfind(|event| event["event"] == "stopped");
    let under_way = stopped.map(|event| event["under_way"].as_array().unwrap().clone());
    under_way
        .unwrap_or_default()
        .iter()
        .map(|order| order.as_u64().unwrap())
        .collect()
}

/// Marsaglia's xorshift: the same moments in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % bound
    }
}

/// A folder with the plan of a robot, and a folder for each of its runs.
struct Bench<'a> {
    robot: &'a mut dyn Mortal,
    home: TempDir,
}

impl<'a> Bench<'a> {
    fn new(robot: &'a mut dyn Mortal) -> Self {
        let home = TempDir::new().unwrap();
        let solved = longstep(home.path())
            .args(["solve", "--goal", robot.goal(), "--domain", &robot.domain(), "--env"])
            .arg(robot.environment())
            .arg("--save")
            .arg(home.path().join("plan.json"))
            .output()
            .unwrap();
        assert_eq!(solved.status.code(), Some(0), "{}", text(&solved.stderr));
        Self { robot, home }
    }

    /// The number of steps of the plan.
    fn steps(&self) -> usize {
        let plan: Value =
            serde_json::from_str(&fs::read_to_string(self.home.path().join("plan.json")).unwrap()).unwrap();
        plan["task_cohesion"]["task_sequence"].as_array().unwrap().len()
    }

    fn folder(&self, name: &str) -> PathBuf {
        let folder = self.home.path().join(name);
        fs::create_dir(&folder).unwrap();
        folder
    }

    /// Starts the robot and a run on it.
    fn run(&mut self, folder: &Path) -> Child {
        let name = self.robot.start(folder);
        let mut command = longstep(self.home.path());
        command.arg("run").arg(self.home.path().join("plan.json"));
        command.args([
            "--goal",
            self.robot.goal(),
            "--domain",
            &self.robot.domain(),
            "--approve",
            "never",
        ]);
        command
            .args(["--robot", &name])
            .arg("--log")
            .arg(folder.join("run.jsonl"));
        command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command.spawn().unwrap()
    }

    /// Starts the robot again, if it is dead, and resumes the run.
    fn resume(&mut self, folder: &Path, answer: &str) -> Output {
        let name = self.robot.start(folder);
        let mut command = longstep(self.home.path());
        command
            .args(["run", "--resume"])
            .arg(folder.join("run.jsonl"))
            .args(["--robot", &name]);
        command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        // It may not ask.
        let _ = child.stdin.take().unwrap().write_all(answer.as_bytes());
        ended(child, LIMIT)
    }

    /// One run, whose robot dies after `wait`. Returns where in the run that was.
    fn death(&mut self, number: u64, wait: Duration) -> &'static str {
        let folder = self.folder(&format!("run-{number}"));
        let mut child = self.run(&folder);
        let log = folder.join("run.jsonl");
        // Some die before the run has begun.
        if !number.is_multiple_of(10) {
            begins(&mut child, &log);
        }
        thread::sleep(wait);
        let begun = Instant::now();
        while !self.robot.kill(&folder) && begun.elapsed() < LIMIT {
            thread::sleep(Duration::from_millis(2));
        }
        let output = ended(child, LIMIT);
        let first = events(&log);
        let told = || format!("number {number}, {wait:?}: {}", text(&output.stderr));
        if first.is_empty() {
            // The robot had not been opened: nothing has moved, and there is nothing to resume.
            assert!(is_robot_failure(&output), "{}", told());
            assert_eq!(performed(&folder), Vec::<Value>::new(), "{}", told());
            return "before the run";
        }
        if output.status.code() == Some(0) {
            assert_eq!(first.last().unwrap()["event"], "done");
            return "after the run";
        }
        assert!(is_robot_failure(&output), "{}", told());
        assert_eq!(first.last().unwrap()["event"], "stopped", "{}", told());
        // What was done is in the log; what is unknown is too, and nothing else happened.
        let (done, open) = (count(&first, "performed"), unknown(&first));
        let real = performed(&folder).len();
        assert!(open.len() <= 1, "{open:?} {}", told());
        assert!(
            (done..=done + open.len()).contains(&real),
            "{done} {open:?} {real} {}",
            told()
        );
        // Nobody answers: what cannot be observed is not repeated.
        let mut again = self.resume(&folder, "");
        if again.status.code() == Some(50) {
            assert!(text(&again.stderr).contains("Was it done?"), "{}", text(&again.stderr));
            assert_eq!(performed(&folder).len(), real, "{}", told());
            let truth = if real > done { "y\n" } else { "n\n" };
            again = self.resume(&folder, truth);
        }
        assert_eq!(again.status.code(), Some(0), "{}{}", told(), text(&again.stderr));
        let all = events(&log);
        assert_eq!(all[..first.len()], first[..], "no event is lost: {}", told());
        check_log(&all);
        // Every step of the plan was performed, and none of them twice.
        assert_eq!(count(&all, "changed"), 0, "{}", told());
        assert_eq!(
            performed(&folder).len(),
            self.steps(),
            "{:?} {}",
            performed(&folder),
            told()
        );
        self.robot.kill(&folder);
        match (open.is_empty(), real > done) {
            (true, _) => "between two steps",
            (false, false) => "in a step, before its effect",
            (false, true) => "in a step, after its effect",
        }
    }
}

/// Waits until a run has opened its robot, which may take longer than the run, or has ended.
fn begins(child: &mut Child, log: &Path) {
    let begun = Instant::now();
    while !log.exists() && matches!(child.try_wait(), Ok(None)) {
        assert!(begun.elapsed() < LIMIT, "the run does not begin");
        thread::sleep(Duration::from_millis(2));
    }
}

/// Kills a robot at `LONGSTEP_DEATHS` moments (4).
fn deaths(robot: &mut dyn Mortal) {
    let mut bench = Bench::new(robot);
    // How long a run takes depends on the machine.
    let folder = bench.folder("whole");
    let mut child = bench.run(&folder);
    begins(&mut child, &folder.join("run.jsonl"));
    let begun = Instant::now();
    let whole = ended(child, LIMIT);
    let longest = u64::try_from(begun.elapsed().as_millis()).unwrap();
    assert_eq!(whole.status.code(), Some(0), "{}", text(&whole.stderr));
    assert_eq!(performed(&folder).len(), bench.steps());
    bench.robot.kill(&folder);

    let wanted = std::env::var("LONGSTEP_DEATHS").ok().and_then(|own| own.parse().ok());
    let wanted: u64 = wanted.unwrap_or(4);
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let mut phases: BTreeMap<&str, usize> = BTreeMap::new();
    for number in 1..=wanted {
        let wait = Duration::from_millis(random.below(longest));
        *phases.entry(bench.death(number, wait)).or_default() += 1;
    }
    println!("killed at {wanted} moments of {longest} ms: {phases:?}");
}

/// The server of VirtualHome.
#[derive(Default)]
struct VirtualHome {
    server: Option<Child>,
    port: u16,
}

impl Mortal for VirtualHome {
    fn domain(&self) -> String {
        "virtualhome".to_owned()
    }

    fn environment(&self) -> PathBuf {
        root().join("examples/environments/flat.json")
    }

    fn goal(&self) -> &'static str {
        "heated(cupcake, oven) & put(magazine, nightstand)"
    }

    fn start(&mut self, folder: &Path) -> String {
        if self
            .server
            .as_mut()
            .is_some_and(|child| matches!(child.try_wait(), Ok(None)))
        {
            return format!("virtualhome:http://127.0.0.1:{}", self.port);
        }
        let mut command = Command::new(std::env::var("LONGSTEP_VIRTUALHOME").unwrap());
        command.arg(root().join("examples/robots/virtualhome/server.py"));
        command.arg("--environment").arg(self.environment());
        command.args(["--port", "0", "--lifetime", "600", "--pace", "0.04", "--state"]);
        let mut child = command
            .arg(folder.join("state.json"))
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut url = String::new();
        BufReader::new(child.stdout.take().unwrap())
            .read_line(&mut url)
            .unwrap();
        self.port = url.trim().rsplit(':').next().unwrap().parse().unwrap();
        self.server = Some(child);
        format!("virtualhome:{}", url.trim())
    }

    fn kill(&mut self, _: &Path) -> bool {
        let Some(mut child) = self.server.take() else {
            return true;
        };
        child.kill().unwrap();
        child.wait().unwrap();
        true
    }
}

impl Drop for VirtualHome {
    fn drop(&mut self) {
        self.kill(Path::new(""));
    }
}

/// The program of pyrobosim, which the run starts.
struct PyRoboSim;

impl PyRoboSim {
    fn folder() -> PathBuf {
        root().join("examples/robots/pyrobosim")
    }
}

impl Mortal for PyRoboSim {
    fn domain(&self) -> String {
        Self::folder().join("domain").to_str().unwrap().to_owned()
    }

    fn environment(&self) -> PathBuf {
        Self::folder().join("domain/environment.json")
    }

    fn goal(&self) -> &'static str {
        "put(soda, trash) & robot_at(bathroom)"
    }

    fn start(&mut self, folder: &Path) -> String {
        let _ = fs::remove_file(folder.join("process"));
        let python = std::env::var("LONGSTEP_PYROBOSIM").unwrap();
        let (program, state) = (Self::folder().join("robot.py"), folder.join("state.json"));
        let process = folder.join("process");
        format!(
            "process:sh -c 'echo $$ > {}; exec {python} {} --speed 8 --state {}'",
            process.display(),
            program.display(),
            state.display()
        )
    }

    fn kill(&mut self, folder: &Path) -> bool {
        let process = fs::read_to_string(folder.join("process")).unwrap_or_default();
        let Ok(id) = process.trim().parse() else {
            return false;
        };
        // It may have ended with the run.
        send(id, "KILL");
        true
    }
}

#[test]
#[ignore = "needs LONGSTEP_VIRTUALHOME, the Python that scripts/robots/virtualhome.sh prints"]
fn a_run_whose_simulator_dies_is_taken_up_again() {
    deaths(&mut VirtualHome::default());
}

#[test]
#[ignore = "needs LONGSTEP_PYROBOSIM, the Python that scripts/robots/pyrobosim.sh prints"]
fn a_run_whose_program_dies_is_taken_up_again() {
    deaths(&mut PyRoboSim);
}
