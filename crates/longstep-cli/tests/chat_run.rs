//! `/run` and `/observe` in `longstep chat`: a conversation with a robot, a simulated one or a program that hangs.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::{Answer, PANTRY, Ran, Server, ended, goals, longstep, run};
use serde_json::Value;
use tempfile::TempDir;

const LIMIT: Duration = Duration::from_secs(60);

struct Home(TempDir);

impl Home {
    fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn chat(&self, server: &Server, more: &[&str]) -> Command {
        let mut command = longstep(self.0.path());
        command.args(["chat", "--env", PANTRY, "--model", &server.reference(), "--session"]);
        command.arg(self.path("session")).args(more);
        command
    }

    fn resume(&self, server: &Server, more: &[&str]) -> Command {
        let mut command = longstep(self.0.path());
        command.args(["chat", "--model", &server.reference(), "--resume"]);
        command.arg(self.path("session")).args(more);
        command
    }

    /// A robot that is no simulation and never ends its first step.
    fn hanging_robot(&self) -> String {
        let (program, notes) = (self.path("robot.py"), self.path("notes"));
        fs::write(&program, HANGING).unwrap();
        format!("process:python3 {} {}", program.display(), notes.display())
    }

    fn said(&self, wanted: &[&str], more: &[&str], lines: &str) -> Ran {
        run(&mut self.chat(&serving(wanted), more), lines)
    }

    /// The events of the session with this name, or of the log of a run.
    fn events(&self, file: &str, kind: &str) -> Vec<Value> {
        let text = fs::read_to_string(self.path("session").join(file)).unwrap();
        let events = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        events.filter(|event| event["event"] == kind).collect()
    }
}

/// A server that wants one goal after the other.
fn serving(wanted: &[&str]) -> Server {
    let answers: Vec<Answer> = wanted.iter().map(|goal| goals(&[goal])).collect();
    Server::giving(answers)
}

const CEREAL: &str = "put(cereal, counter)";
const JUICE: &str = "put(juice, counter)";

#[test]
fn run_command_executes_each_accepted_plan_once() {
    let home = Home::new();
    let ran = home.said(
        &[CEREAL, JUICE, "put(cereal, shelf top)"],
        &["--robot", "sim:seed=4"],
        "The cereal goes on the counter\n\nThe juice goes on the counter\n\n/run\n\
         The cereal goes on the shelf top\n\n/run\n/run\n",
    );
    let text = format!("{}{}", ran.stdout, ran.stderr);
    let done = home.events("session.jsonl", "carried_out");
    let numbers: Vec<(u64, bool)> = done
        .iter()
        .map(|event| (event["number"].as_u64().unwrap(), event["reached"].as_bool().unwrap()))
        .collect();
    assert_eq!(numbers, [(0, true), (1, true), (2, true)], "{text}");
    assert!(text.contains("the robot has carried out every accepted plan"), "{text}");
    for (log, calls) in [("run-1.jsonl", 6), ("run-2.jsonl", 6), ("run-3.jsonl", 6)] {
        assert_eq!(home.events(log, "ordered").len(), calls, "{log}: {text}");
        assert_eq!(home.events(log, "done").len(), 1);
    }
    // Nothing is left to run after a resumption.
    let again = run(&mut home.resume(&serving(&[]), &["--robot", "sim"]), "/run\n/env\n");
    assert!(
        again.stderr.contains("has carried out every accepted plan"),
        "{}",
        again.stderr
    );
    assert!(again.stdout.contains("on_something(<shelf_top>)"), "{}", again.stdout);
}

#[test]
fn the_next_instruction_begins_in_the_observed_world() {
    let home = Home::new();
    let seen = home.path("seen.json");
    fs::write(
        &seen,
        r#"{"states": {"<cereal>": "inside_something(<trash_bin>)", "<cat>": "closed()"}}"#,
    )
    .unwrap();
    let lines = format!(
        "The cereal goes on the counter\n\n/observe {}\n/observe\nThe cereal goes on the counter\n\n/undo\n/env\n",
        seen.display()
    );
    let ran = home.said(&[CEREAL, CEREAL], &[], &lines);
    let text = format!("{}{}", ran.stdout, ran.stderr);
    assert!(text.contains("Changed since the last plan"), "{text}");
    assert!(text.contains("is not on the counter any more"), "{text}");
    assert!(text.contains("<cat>"), "{text}");
    assert!(
        text.contains("this conversation has no robot that could look"),
        "{text}"
    );
    let accepted = home.events("session.jsonl", "accept");
    assert_eq!(accepted.len(), 2, "{text}");
    assert_eq!(
        accepted[1]["plan"]["environment_before"]["object_states"]["<cereal>"],
        "inside_something(<trash_bin>)"
    );
    // The plan is taken back, the observation is not.
    let after = ran.stdout.rsplit("Objects").next().unwrap();
    assert!(after.contains("inside_something(<trash_bin>)"), "{after}");
    let replay = longstep(home.0.path())
        .args(["session", "replay"])
        .arg(home.path("session"))
        .output()
        .unwrap();
    assert_eq!(replay.status.code(), Some(0), "{replay:?}");
}

#[test]
fn a_mishap_is_mended_and_a_simulated_world_is_observed() {
    for seed in ["1", "2", "3"] {
        let home = Home::new();
        let robot = format!("sim:seed={seed},faults=2,kinds=slips+moved+undone");
        let ran = home.said(
            &[CEREAL, JUICE],
            &["--robot", &robot, "--approve", "never"],
            "The cereal goes on the counter\n\n/run\n/observe\nThe juice goes on the counter\n\n/run\n",
        );
        let text = format!("{}{}", ran.stdout, ran.stderr);
        assert!(text.contains("The world is as expected"), "{text}");
        let done = home.events("session.jsonl", "carried_out");
        assert!(
            done.iter().all(|event| event["reached"] == true) && done.len() == 2,
            "{text}"
        );
    }
}

#[test]
fn chat_explains_why_run_or_observe_is_not_possible() {
    let table: [(&[&str], &str, &str); 5] = [
        (&[], "/run\n", "this conversation has no robot"),
        (
            &["--robot", "sim"],
            "/run\n",
            "the robot has carried out every accepted plan",
        ),
        (
            &["--robot", "sim"],
            "The cereal goes on the counter\n/run\n",
            "an instruction is in progress",
        ),
        (
            &["--robot", "drone"],
            "The cereal goes on the counter\n\n/run\n",
            "`drone` is no robot",
        ),
        (
            &["--robot", "sim"],
            "The cereal goes on the counter\n/observe\n",
            "an observation does not fit here",
        ),
    ];
    for (more, lines, error) in table {
        let home = Home::new();
        let ran = home.said(&[CEREAL], more, lines);
        assert!(ran.stderr.contains(error), "{lines}: {}", ran.stderr);
        assert!(ran.stderr.contains("hint:"), "{lines}: {}", ran.stderr);
        assert_eq!(ran.code, 0, "{lines}: {}", ran.stderr);
    }
}

#[test]
fn run_command_asks_for_each_step_on_a_pipe() {
    let home = Home::new();
    let answers = "y\n".repeat(5) + "n\n";
    let ran = home.said(
        &[CEREAL],
        &["--robot", "sim", "--approve", "each-step"],
        &format!("The cereal goes on the counter\n\n/run\n{answers}/env\n"),
    );
    assert_eq!(home.events("run-1.jsonl", "ordered").len(), 5, "{}", ran.stderr);
    let done = home.events("session.jsonl", "carried_out");
    assert_eq!(done[0]["reached"], false);
    // The hand still holds what it did not release.
    let after = ran.stdout.rsplit("Objects").next().unwrap();
    assert!(after.contains("inside_hand()"), "{after}");
}

/// A robot whose steps never end, and which writes down when it begins one and when it is told to stop.
const HANGING: &str = r#"
import json, os, sys
def answer(id, result):
    print(json.dumps({"jsonrpc": "2.0", "id": id, "result": result}), flush=True)
def note(word):
    with open(sys.argv[1], "a") as file:
        file.write(f"{word} {os.getpid()}\n")
for line in sys.stdin:
    message = json.loads(line)
    method = message["method"]
    note(method)
    if method == "initialize":
        answer(message["id"], {"protocol": 1, "name": "hanging", "capabilities": {"observe": True}})
    elif method == "observe":
        answer(message["id"], {"states": {}})
    elif method in ("stop", "shutdown"):
        answer(message["id"], {})
        if method == "shutdown":
            break
"#;

/// A chat with the hanging robot, up to its first step.
fn hanging(home: &Home) -> (Child, ChildStdin) {
    let robot = home.hanging_robot();
    let server = serving(&[CEREAL]);
    let mut command = home.chat(&server, &["--robot", &robot, "--live"]);
    command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    input.write_all(b"The cereal goes on the counter\n\n/run\n").unwrap();
    wait_for(home, "perform", 1);
    (child, input)
}

#[test]
fn a_real_robot_moves_only_with_live() {
    let home = Home::new();
    let robot = home.hanging_robot();
    let lines = "The cereal goes on the counter\n\n/run\n/observe\n/run\n";
    let ran = home.said(&[CEREAL], &["--robot", &robot], lines);
    let text = format!("{}{}", ran.stdout, ran.stderr);
    assert_eq!(ran.code, 0, "{text}");
    assert_eq!(noted(&home, "perform") + noted(&home, "observe"), 0, "{text}");
    // The plan waits after a dry run, so that a second one shows it again.
    for (times, part) in [
        (12, "would send"),
        (2, "the plan still waits"),
        (1, "a dry run observes nothing"),
    ] {
        assert_eq!(text.matches(part).count(), times, "{part}: {text}");
    }
    assert!(home.events("session.jsonl", "carried_out").is_empty(), "{text}");
}

fn noted(home: &Home, word: &str) -> usize {
    let notes = fs::read_to_string(home.path("notes")).unwrap_or_default();
    notes.lines().filter(|line| line.starts_with(word)).count()
}

fn wait_for(home: &Home, word: &str, count: usize) {
    let begun = Instant::now();
    while noted(home, word) < count {
        assert!(begun.elapsed() < LIMIT, "no {word}");
        thread::sleep(Duration::from_millis(5));
    }
}

fn kill(child: &Child, signal: &str) {
    let sent = Command::new("kill")
        .args([format!("-{signal}"), child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
}

#[test]
fn ctrl_c_stops_the_robot_and_returns_to_the_prompt() {
    let home = Home::new();
    let (child, mut input) = hanging(&home);
    kill(&child, "INT");
    wait_for(&home, "stop", 1);
    // The conversation goes on: the robot is opened again for the plan that was stopped.
    input.write_all(b"/run\n").unwrap();
    wait_for(&home, "perform", 2);
    kill(&child, "INT");
    wait_for(&home, "stop", 2);
    input.write_all(b"/plan\n/quit\n").unwrap();
    drop(input);
    let output = ended(child, LIMIT);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(stderr.contains("stopped at a request"), "{stderr}");
    let done = home.events("session.jsonl", "carried_out");
    assert!(
        done.len() == 2 && done.iter().all(|event| event["reached"] == false),
        "{done:?}"
    );
    assert_eq!(
        home.events("run-1.jsonl", "stopped")[0]["under_way"],
        serde_json::json!([1])
    );
    assert_eq!(noted(&home, "initialize"), 2);
}

#[test]
fn sigterm_stops_the_robot_and_ends_the_program() {
    for signal in ["TERM", "HUP"] {
        let home = Home::new();
        let (child, input) = hanging(&home);
        kill(&child, signal);
        let output = ended(child, LIMIT);
        drop(input);
        assert_eq!(output.status.code(), Some(50), "{output:?}");
        assert_eq!(noted(&home, "stop"), 1);
        assert_eq!(home.events("session.jsonl", "accept").len(), 1);
        let notes = fs::read_to_string(home.path("notes")).unwrap();
        let id = notes.split_whitespace().last().unwrap().to_owned();
        assert!(
            !PathBuf::from(format!("/proc/{id}/cmdline")).exists() || is_gone(&id),
            "{id} lives"
        );
    }
}

fn is_gone(id: &str) -> bool {
    let line = fs::read(format!("/proc/{id}/cmdline")).unwrap_or_default();
    !String::from_utf8_lossy(&line).contains("robot.py")
}
