//! A password in an address of a robot, at the right place or at a wrong one, is in no message and in no file.
#![cfg(unix)]
#![allow(clippy::disallowed_macros, clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use common::{PANTRY, longstep};
use tempfile::TempDir;

const PASSWORD: &str = "hunter2secret";
const GOAL: &str = "put(juice, shelf top)";

const ROBOT: &str = r#"
name = "arm"
url = "ws://127.0.0.1"
allow = ["grasp"]
parallel = 1
rate = 1.0
[timeouts]
stop = 2
[[action]]
name = "grasp"
server = "/grasp"
type = "a/action/A"
goal = { item = "{item}" }
[[observation]]
topic = "/seen"
type = "a/msg/Seen"
entity = "{name}"
say = [{ state = "on_something({on})" }]
"#;

struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        let bench = Self(TempDir::new().unwrap());
        let solved = bench.ran(&[
            "solve",
            "--goal",
            GOAL,
            "--env",
            PANTRY,
            "--save",
            &bench.text("plan.json"),
        ]);
        assert_eq!(solved.status.code(), Some(0));
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }

    fn ran(&self, arguments: &[&str]) -> Output {
        longstep(self.0.path()).args(arguments).output().unwrap()
    }

    /// Checks that a command fails, and that the password is in nothing that it left.
    #[track_caller]
    fn check(&self, arguments: &[&str]) -> String {
        let output = self.ran(arguments);
        let both = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success(), "{arguments:?}: {both}");
        assert!(!both.contains(PASSWORD), "{arguments:?}: {both}");
        both
    }

    /// The files below the home that have the password in their name or content.
    fn with_password(&self, folder: &Path) -> Vec<PathBuf> {
        let mut found = Vec::new();
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                found.extend(self.with_password(&path));
            } else if path.to_str().unwrap().contains(PASSWORD)
                || String::from_utf8_lossy(&fs::read(&path).unwrap()).contains(PASSWORD)
            {
                found.push(path);
            }
        }
        found
    }
}

#[test]
fn a_password_at_any_place_of_a_robots_file_is_in_no_message() {
    let bench = Bench::new();
    let address = format!("ws://me:{PASSWORD}@arm:9090");
    let bare = format!("me:{PASSWORD}@arm:9090");
    for value in [
        &address,
        &bare,
        &format!("http://{bare}/x"),
        &format!("ws://arm/?token={PASSWORD}"),
    ] {
        for (from, to) in [
            ("url = \"ws://127.0.0.1\"", "url = \"VALUE\""),
            ("parallel = 1", "parallel = \"VALUE\""),
            ("rate = 1.0", "rate = \"VALUE\""),
            ("stop = 2", "stop = \"VALUE\""),
            ("stop = 2", "\"VALUE\" = 2"),
            ("allow = [\"grasp\"]", "allow = [\"VALUE\"]"),
            ("allow = [\"grasp\"]", "allow = \"VALUE\""),
            ("name = \"grasp\"", "name = \"VALUE\""),
            ("server = \"/grasp\"", "server = \"VALUE\""),
            ("type = \"a/action/A\"", "type = \"VALUE\""),
            ("\"{item}\"", "\"{item|VALUE}\""),
            ("\"{item}\"", "\"{VALUE}\""),
            ("topic = \"/seen\"", "topic = \"VALUE\""),
            ("on_something({on})", "VALUE({on})"),
        ] {
            assert!(ROBOT.contains(from), "{from}");
            fs::write(
                bench.path("robot.toml"),
                ROBOT.replacen(from, &to.replace("VALUE", value), 1),
            )
            .unwrap();
            bench.check(&["robot", "check", "--offline", &bench.text("robot.toml")]);
        }
    }
}

#[test]
fn a_password_in_the_name_of_a_robot_is_in_no_message_and_no_file() {
    let bench = Bench::new();
    fs::write(bench.path("dies.py"), "raise SystemExit(3)\n").unwrap();
    let dies = bench.text("dies.py");
    for robot in [
        format!("virtualhome:ftp://me:{PASSWORD}@arm"),
        format!("virtualhome:me:{PASSWORD}@arm:80"),
        format!("virtualhome:http://me:{PASSWORD}@127.0.0.1:1"),
        format!("virtualhome:http://127.0.0.1:1/?key={PASSWORD}"),
        format!("virtualhome:http://127.0.0.1:1,door=http://me:{PASSWORD}@arm"),
        format!("http://me:{PASSWORD}@arm"),
        format!("process:/no/such/program ws://me:{PASSWORD}@arm"),
        format!("process:python3 '{dies}' ws://me:{PASSWORD}@arm"),
        format!("process:'ws://me:{PASSWORD}@arm"),
        format!("ros2:ws://me:{PASSWORD}@arm"),
    ] {
        bench.check(&[
            "run",
            &bench.text("plan.json"),
            "--robot",
            &robot,
            "--live",
            "--approve",
            "never",
        ]);
        bench.check(&["robot", "environment", &robot]);
    }
    bench.check(&["run", &bench.text("plan.json"), &format!("http://me:{PASSWORD}@arm")]);
    assert_eq!(bench.with_password(bench.0.path()), Vec::<PathBuf>::new());
}

/// A robot that performs one step, and dies in the second.
const MORTAL: &str = r#"
import json, sys
count = 0
for line in sys.stdin:
    message = json.loads(line)
    result = {}
    if message["method"] == "initialize":
        result = {"protocol": 1, "name": "mortal", "capabilities": {"observe": True}}
    elif message["method"] == "observe":
        result = {"states": {}}
    elif message["method"] == "perform":
        count += 1
        if count == 2:
            raise SystemExit(3)
    print(json.dumps({"jsonrpc": "2.0", "id": message["id"], "result": result}), flush=True)
"#;

#[test]
fn the_log_of_a_run_has_no_password_and_the_robot_is_named_again() {
    let bench = Bench::new();
    fs::write(bench.path("mortal.py"), MORTAL).unwrap();
    let robot = format!("process:python3 '{}' ws://me:{PASSWORD}@arm", bench.text("mortal.py"));
    let log = bench.text("run.jsonl");
    let live = ["--live", "--approve", "never"];
    bench.check(
        &[
            &["run", &bench.text("plan.json"), "--robot", &robot, "--log", &log][..],
            &live,
        ]
        .concat(),
    );
    assert_eq!(bench.with_password(bench.0.path()), Vec::<PathBuf>::new());
    let refused = bench.check(&["run", "--resume", &log, "--live"]);
    assert!(
        refused.contains("the log does not keep the password of `process:python3"),
        "{refused}"
    );
    assert!(refused.contains("--robot"), "{refused}");
    let resumed = bench.check(&["run", "--resume", &log, "--live", "--robot", &robot]);
    assert!(resumed.contains("Resuming"), "{resumed}");
}

#[test]
fn the_password_of_a_database_is_in_no_message_and_in_no_file() {
    let bench = Bench::new();
    for place in [
        "127.0.0.1:1/x",
        "127.0.0.1:port/x",
        "no host/x",
        "127.0.0.1/x?sslmode=always",
    ] {
        let address = format!("postgres://me:{PASSWORD}@{place}");
        let serve = ["serve", "--no-model", "--listen", "127.0.0.1:0", "--store", &address];
        let refused = bench.check(&serve);
        assert!(refused.contains("postgres://[removed]@"), "{refused}");
    }
    assert_eq!(bench.with_password(bench.0.path()), Vec::<PathBuf>::new());
}
