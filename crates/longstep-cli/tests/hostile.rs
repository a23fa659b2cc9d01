//! The program against a hostile server: every command ends by itself, with the exit code of the mode, and within its
//! memory, which `ulimit` sets.
#![cfg(target_os = "linux")]
#![allow(clippy::disallowed_macros, clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;
#[path = "../../longstep-llm/tests/hostile/mod.rs"]
mod server;

use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::{PANTRY, longstep};
use serde_json::Value;
use server::{Hostile, Mode, Outcome, Place, Short, modes};

/// Address space of the program, in KiB: what it needs to start, and 300 MB.
const MEMORY: u32 = 500_000;

/// A program that is still there by then hangs. Nothing is measured by this.
const HANGS: Duration = Duration::from_secs(300);

/// The result of a run.
struct Ran {
    status: ExitStatus,
    stdout: String,
    stderr: String,
}

/// Runs a command of the program under the limit of memory.
fn run(home: &Path, arguments: &[&str], mode: &Mode, server: &Hostile, input: &str) -> Ran {
    let program = longstep(home);
    let mut command = Command::new("sh");
    command
        .args(["-c", &format!("ulimit -v {MEMORY}; exec \"$0\" \"$@\"")])
        .arg(program.get_program())
        .args(arguments)
        .args(["--model", &server.reference(), "--context", "8192"]);
    match mode.short {
        Short::Nothing => {}
        Short::Timeout => _ = command.args(["--timeout", "1"]),
        Short::Silence => _ = command.args(["--silence", "0.5"]),
    }
    if let Some(folder) = program.get_current_dir() {
        command.current_dir(folder);
    }
    for (name, value) in program.get_envs() {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
    command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let began = Instant::now();
    let mut child = command.spawn().unwrap();
    // It may end without having read everything.
    let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
    let stdout = collected(child.stdout.take().unwrap());
    let stderr = collected(child.stderr.take().unwrap());
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if began.elapsed() > HANGS {
            let _ = child.kill();
            let _ = child.wait();
            panic!("{}: `{arguments:?}` hangs", mode.name);
        }
        thread::sleep(Duration::from_millis(5));
    };
    Ran {
        status,
        stdout: stdout.join().unwrap(),
        stderr: stderr.join().unwrap(),
    }
}

fn collected(mut pipe: impl Read + Send + 'static) -> thread::JoinHandle<String> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = pipe.read_to_end(&mut bytes);
        String::from_utf8(bytes).unwrap()
    })
}

const PLAN: [&str; 5] = ["plan", "Put the cereal on the counter", "--env", PANTRY, "--json"];

#[test]
fn plan_ends_in_every_mode_with_its_exit_code() {
    let home = tempfile::tempdir().unwrap();
    let mut wrong = Vec::new();
    for mode in modes() {
        let server = Hostile::new(&mode);
        let ran = run(home.path(), &PLAN, &mode, &server, "");
        let told = ran.stderr.lines().any(|line| line.starts_with("error: "));
        let fits = ran.status.code() == Some(mode.code) && told == (mode.code != 0) && ran.stderr.len() < 2000;
        if !fits {
            wrong.push(format!("{}: {:?} {}", mode.name, ran.status, ran.stderr));
        }
        let option = match mode.outcome {
            Outcome::TimedOut => Some("--timeout"),
            Outcome::Silent => Some("--silence"),
            _ => None,
        };
        if let Some(option) = option {
            assert!(ran.stderr.contains(option), "{}: {}", mode.name, ran.stderr);
        }
        // Either the result or the error is an object.
        let object: Value = serde_json::from_str(&ran.stdout).unwrap();
        assert_eq!(
            object.get("error").is_some(),
            mode.code != 0,
            "{}: {}",
            mode.name,
            ran.stdout
        );
    }
    assert_eq!(wrong, [""; 0], "\n{}", wrong.join("\n"));
}

/// The modes that differ for other commands: each limit once.
const SOME: [&str; 9] = [
    "error without end",
    "text without end",
    "a line without end",
    "a piece every 20 ms for ever",
    "headers without end",
    "no answer",
    "closed at once",
    "context: an answer without end",
    "tokens: no answer",
];

fn some() -> impl Iterator<Item = Mode> {
    modes().into_iter().filter(|mode| SOME.contains(&mode.name))
}

#[test]
fn compose_ends_with_the_same_exit_codes() {
    let home = tempfile::tempdir().unwrap();
    let plans = home.path().join("fetch.json");
    let plan = longstep(home.path())
        .args(["solve", "--goal", "put(cereal, counter)", "--env", PANTRY, "--save"])
        .arg(&plans)
        .output()
        .unwrap();
    assert_eq!(plan.status.code(), Some(0));
    let plans = plans.display().to_string();
    let arguments = ["compose", "Do it", "--plans", &plans, "--env", PANTRY];
    for mode in some().filter(|mode| mode.place == Place::Chat) {
        let server = Hostile::new(&mode);
        let ran = run(home.path(), &arguments, &mode, &server, "");
        assert_eq!(ran.status.code(), Some(mode.code), "{}: {}", mode.name, ran.stderr);
    }
}

#[test]
fn a_chat_goes_on_after_a_hostile_answer() {
    let home = tempfile::tempdir().unwrap();
    for mode in some() {
        let server = Hostile::new(&mode);
        let input = "Put the cereal on the counter\n/env\n";
        let ran = run(home.path(), &["chat", "--env", PANTRY], &mode, &server, input);
        assert_eq!(ran.status.code(), Some(0), "{}: {}", mode.name, ran.stderr);
        let told = ran.stderr.contains("error: ") || ran.stdout.contains("cut off");
        assert_eq!(told, mode.code != 0, "{}: {}\n{}", mode.name, ran.stdout, ran.stderr);
    }
}

#[test]
fn an_evaluation_ends_with_the_same_exit_codes() {
    let home = tempfile::tempdir().unwrap();
    for (number, mode) in some().enumerate() {
        let server = Hostile::new(&mode);
        let out = home.path().join(number.to_string()).display().to_string();
        let arguments = ["eval", "branching", "--out", &out, "--case", "pantry-01"];
        let ran = run(home.path(), &arguments, &mode, &server, "");
        // A reply that is cut off is a mistake of the model, which is what an evaluation counts.
        let code = if mode.outcome == Outcome::CutOff { 0 } else { mode.code };
        assert_eq!(ran.status.code(), Some(code), "{}: {}", mode.name, ran.stderr);
    }
}

/// Ctrl-C where the program has a handler of its own: it ends, with what was done so far, long before the silence of
/// 60 s is over.
#[test]
fn an_evaluation_can_be_stopped_at_every_moment() {
    let home = tempfile::tempdir().unwrap();
    let stuck =
        |mode: &Mode| mode.short != Short::Nothing || mode.name.ends_with("drips") || mode.name.ends_with("no answer");
    for (number, mode) in modes().into_iter().filter(stuck).enumerate() {
        let server = Hostile::new(&mode);
        let mut child = longstep(home.path())
            .args(["eval", "branching", "--case", "pantry-01", "--out"])
            .arg(home.path().join(number.to_string()))
            .args(["--model", &server.reference()])
            // The size of the context is asked for unless it is given.
            .args(["--context", "8192"].iter().filter(|_| mode.place != Place::Context))
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        server.wait();
        let id = child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        let began = Instant::now();
        let stderr = collected(child.stderr.take().unwrap());
        while child.try_wait().unwrap().is_none() {
            assert!(began.elapsed() < HANGS, "{}", mode.name);
            thread::sleep(Duration::from_millis(5));
        }
        let stderr = stderr.join().unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(40), "{}: {stderr}", mode.name);
        assert!(
            stderr.contains("stopped after 0 instructions"),
            "{}: {stderr}",
            mode.name
        );
    }
}
