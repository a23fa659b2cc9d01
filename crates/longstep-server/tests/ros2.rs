//! A server in a real ROS 2: a node of `rclpy` sees its plans and runs, and asks it, through a real rosbridge server.
//!
//! `LONGSTEP_ROS2=$(scripts/robots/ros2.sh) cargo test -p longstep-server --test ros2 -- --ignored --nocapture`
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic, missing_docs, unreachable_pub)]

mod support;

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU16, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use longstep_robot::ros2::Configuration;
use longstep_robot::{OpenOptions, RobotReference, SimOptions};
use longstep_server::ros::{RosFace, RosOptions};
use longstep_server::{APPROVAL_LIFETIME, Body, Hub, RobotEntry, RunId, RunState, SessionId};
use serde_json::{Value, json};
use support::{DESK, hub, simulated, until};
use tempfile::TempDir;

const LONGEST: Duration = Duration::from_secs(60);

/// ROS domains of this run of the tests: other runs on this machine should not see them.
static NEXT_DOMAIN: AtomicU16 = AtomicU16::new(0);

fn installation() -> PathBuf {
    PathBuf::from(std::env::var("LONGSTEP_ROS2").unwrap())
}

/// A program that ends with the test, and what it started.
struct Program(Child);

impl Program {
    fn start(command: &mut Command) -> Self {
        Self(command.process_group(0).spawn().unwrap())
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let group = format!("-{}", self.0.id());
        let killed = Command::new("kill")
            .args(["-KILL", "--", &group])
            .stderr(Stdio::null())
            .status();
        drop(killed);
        drop(self.0.wait());
    }
}

/// A server, a bridge and a node of ROS 2.
struct Bench {
    folder: TempDir,
    domain: String,
    port: u16,
    hub: Arc<Hub>,
    face: RosFace,
    bridge: Option<Program>,
    robot: Option<Program>,
    commands: ChildStdin,
    results: BufReader<ChildStdout>,
    _caller: Program,
}

impl Bench {
    fn new(serving: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        // Each step takes a moment, so that progress is seen.
        let options: SimOptions = "ticks=1,pace=150".parse().unwrap();
        let simulated = simulated("sim", options, Body::PerSession);
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let number = u32::from(NEXT_DOMAIN.fetch_add(1, Ordering::SeqCst)) + std::process::id();
        let domain = (1 + number % 100).to_string();
        let toml = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/robots/ros2/robot.toml");
        // A busy machine finds the parts of a robot slowly.
        let toml = std::fs::read_to_string(toml)
            .unwrap()
            .replace("9090", &port.to_string())
            .replace("[timeouts]\n", "[timeouts]\nconnect = 60\n");
        let file = folder.path().join("robot.toml");
        std::fs::write(&file, format!("{toml}\n[serve]\n{serving}\n")).unwrap();
        let configuration = Configuration::parse("robot.toml", &std::fs::read_to_string(&file).unwrap()).unwrap();
        let reference: RobotReference = format!("ros2:{}", file.display()).parse().unwrap();
        let arm = RobotEntry::of_reference("arm", &reference, &OpenOptions::default().with_live(true));
        let hub = hub(&folder, vec![simulated, arm]);
        let face = RosFace::start(Arc::clone(&hub), RosOptions::new(&configuration)).unwrap();
        let mut caller = Program::start(
            Command::new(installation().join("python"))
                .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ros2_caller.py"))
                .arg(&configuration.serving().namespace)
                .env("ROS_DOMAIN_ID", &domain)
                .stdin(Stdio::piped())
                .stdout(Stdio::piped())
                .stderr(File::create(folder.path().join("caller.log")).unwrap()),
        );
        let commands = caller.0.stdin.take().unwrap();
        let mut results = BufReader::new(caller.0.stdout.take().unwrap());
        let mut line = String::new();
        results.read_line(&mut line).unwrap();
        let log = || std::fs::read_to_string(folder.path().join("caller.log")).unwrap();
        assert_eq!(line, "ready\n", "{}", log());
        let mut bench = Self {
            folder,
            domain,
            port,
            hub,
            face,
            bridge: None,
            robot: None,
            commands,
            results,
            _caller: caller,
        };
        bench.start_bridge();
        bench
    }

    /// Starts a bridge, and waits until the server is its client.
    fn start_bridge(&mut self) {
        let before = self.face.connections();
        let mut command = Command::new(installation().join("bridge"));
        command
            .args(["--bind", &format!("127.0.0.1:{}", self.port)])
            .env("ROS_DOMAIN_ID", &self.domain)
            .env("ROS_LOG_DIR", self.folder.path().join("bridge-log"))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        self.bridge = Some(Program::start(&mut command));
        let begun = Instant::now();
        while self.face.connections() == before || !self.face.is_connected() {
            assert!(begun.elapsed() < LONGEST, "the server does not connect");
            thread::sleep(Duration::from_millis(10));
        }
    }

    /// Starts the robot that `arm` moves, in the world of the sessions.
    fn start_robot(&mut self) {
        let environment = self.folder.path().join("desk.json");
        std::fs::write(&environment, DESK).unwrap();
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../longstep-cli/tests/robots/ros2_robot.py");
        let mut command = Command::new(installation().join("python"));
        command
            .arg(script)
            .args([&environment, self.folder.path()])
            .env("ROS_DOMAIN_ID", &self.domain)
            .stdout(Stdio::piped())
            .stderr(File::create(self.folder.path().join("robot.log")).unwrap());
        let mut robot = Program::start(&mut command);
        let mut line = String::new();
        let mut output = BufReader::new(robot.0.stdout.take().unwrap());
        output.read_line(&mut line).unwrap();
        assert_eq!(line, "ready\n");
        self.robot = Some(robot);
    }

    fn stop_bridge(&mut self) {
        self.bridge = None;
        while TcpStream::connect(("127.0.0.1", self.port)).is_ok() {
            thread::sleep(Duration::from_millis(10));
        }
        let begun = Instant::now();
        while self.face.is_connected() {
            assert!(begun.elapsed() < LONGEST, "the server does not notice");
            thread::sleep(Duration::from_millis(10));
        }
    }

    /// Has the node do something, and returns the result.
    fn node(&mut self, command: &Value) -> Value {
        writeln!(self.commands, "{command}").unwrap();
        let mut line = String::new();
        self.results.read_line(&mut line).unwrap();
        let log = || std::fs::read_to_string(self.folder.path().join("caller.log")).unwrap_or_default();
        let result: Value = serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {}", log()));
        assert!(result.get("timeout").is_none(), "nothing came for {command}");
        result
    }

    fn ask(&mut self, kind: &str, request: &Value) -> Value {
        self.node(&json!({"do": "ask", "kind": kind, "request": request}))
    }

    fn see(&mut self, topic: &str, fields: &Value) -> Value {
        self.node(&json!({"do": "see", "topic": topic, "with": fields}))
    }

    fn planned(&mut self, text: &str) -> (SessionId, String) {
        let answer = self.ask("say", &json!({"text": text}));
        assert_eq!(answer["state"], "plan", "{answer}");
        let session = SessionId::parse(answer["session"].as_str().unwrap()).unwrap();
        (session, answer["plan"].as_str().unwrap().to_owned())
    }
}

#[track_caller]
fn check_refused(answer: &Value, words: &str) {
    let message = answer["error"]["message"].as_str().unwrap_or_default();
    assert!(
        answer["ok"] == false && message.contains(words),
        "no `{words}` in {answer}"
    );
}

#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn a_node_sees_plans_and_begins_only_what_was_approved() {
    let mut bench = Bench::new("");
    let (session, plan) = bench.planned("Put the pen on the shelf");
    let shown = bench.see("plan", &json!({"plan": plan, "decision": "proposed"}));
    assert!(!shown["steps"].as_array().unwrap().is_empty(), "{shown}");
    let world = bench.see("world", &json!({"session": session}));
    assert_eq!(world["environment"]["object_states"]["<pen>"], "on_something(<desk>)");
    // A latched topic has its last message for whoever comes late.
    bench.node(&json!({"do": "late", "topic": "plan", "with": {"plan": plan}}));

    let execute = json!({"plan": plan, "session": session, "caller": "cell"});
    check_refused(&bench.ask("execute", &execute), "nobody has approved this plan");
    bench.hub.accept(&session, &plan, "ada").unwrap();
    check_refused(&bench.ask("execute", &execute), "nobody has approved this plan");
    assert!(bench.hub.runs().is_empty(), "nothing moved");

    let approval = bench
        .hub
        .approve(&session, &plan, "sim", "ada", APPROVAL_LIFETIME)
        .unwrap();
    check_refused(
        &bench.ask("execute", &json!({"plan": "ffff", "approval": approval.id})),
        "another plan",
    );
    let begun = bench.ask("execute", &execute);
    assert_eq!(begun["ok"], true, "{begun}");
    let done = bench.see("progress", &json!({"id": begun["run"], "state": "done"}));
    assert_eq!(
        (&done["end"]["done"], &done["by"]),
        (&json!(true), &json!("ros2:cell")),
        "{done}"
    );
    let steps = done["steps"].as_array().unwrap().len();
    let count = bench.node(&json!({"do": "count", "topic": "progress"}));
    assert!(count["count"].as_u64().unwrap() >= steps as u64, "{count}");
    // The last of several worlds, which comes after the end.
    let after = json!({"object_states": {"<pen>": "on_something(<shelf>)"}});
    bench.see("world", &json!({"run": begun["run"], "environment": after}));
    // The same hash again, by itself and with the approval that was used.
    for request in [execute.clone(), json!({"plan": plan, "approval": approval.id})] {
        assert_eq!(bench.ask("execute", &request)["ok"], false);
    }
    assert_eq!(bench.hub.runs().len(), 1);
}

#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn a_bridge_that_is_killed_and_started_again_works_again() {
    let mut bench = Bench::new("approve = true\nnamespace = \"/kitchen\"");
    let (session, plan) = bench.planned("Put the pen on the shelf");
    for _ in 0..2 {
        bench.stop_bridge();
        // The hub goes on without it.
        assert!(bench.hub.session(&session).is_ok());
        bench.start_bridge();
        // The new bridge has what the old one showed last.
        bench.node(&json!({"do": "late", "topic": "plan", "with": {"plan": plan}}));
    }
    let begun = bench.ask(
        "execute",
        &json!({"plan": plan, "session": session, "caller": "cell", "robot": "sim"}),
    );
    assert_eq!(begun["ok"], true, "{begun}");
    // Killed while the robot moves: the run goes on, and its end is shown afterwards.
    bench.see("progress", &json!({"id": begun["run"], "state": "running"}));
    bench.stop_bridge();
    bench.start_bridge();
    bench.see("progress", &json!({"id": begun["run"], "state": "done"}));
    check_refused(
        &bench.ask(
            "execute",
            &json!({"plan": plan, "session": session, "caller": "cell", "robot": "sim"}),
        ),
        "no accepted plan waits",
    );
    assert_eq!((bench.hub.runs().len(), bench.face.connections()), (1, 4));
}

#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn a_robot_of_the_same_bridge_carries_out_what_a_node_asked_for() {
    let mut bench = Bench::new("");
    bench.start_robot();
    let (session, plan) = bench.planned("Put the pen on the shelf");
    bench.hub.accept(&session, &plan, "ada").unwrap();
    bench
        .hub
        .approve(&session, &plan, "arm", "ada", APPROVAL_LIFETIME)
        .unwrap();
    let begun = bench.ask("execute", &json!({"plan": plan}));
    assert_eq!(
        (&begun["ok"], &begun["robot"]),
        (&json!(true), &json!("arm")),
        "{begun}"
    );
    let run = RunId::parse(begun["run"].as_str().unwrap()).unwrap();
    let ended = until(&bench.hub, &run, |run| run.state.is_ended());
    assert_eq!(ended.state, RunState::Done, "{ended:#?}");
    let done = bench.see("progress", &json!({"id": begun["run"], "state": "done"}));
    let journal = std::fs::read_to_string(bench.folder.path().join("journal")).unwrap();
    let performed = journal.lines().filter(|line| line.starts_with("done")).count();
    assert_eq!(performed, done["steps"].as_array().unwrap().len(), "{journal}");
    // The recording of the run has these steps too.
    let recording = bench.hub.recording(&bench.hub.runs()[0].record.id).unwrap();
    let messages = mcap::MessageStream::new(&recording).unwrap().map(Result::unwrap);
    let steps = messages.filter(|message| {
        message.channel.topic == "/longstep/step" && String::from_utf8_lossy(&message.data).contains("performed")
    });
    assert_eq!(steps.count(), performed);
}

#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn services_answer_nodes_that_have_their_type() {
    let mut bench = Bench::new("services = true");
    let say = json!({"text": "Put the pen on the shelf"});
    let answer = bench.node(&json!({"do": "call", "kind": "say", "request": say}));
    assert_eq!(answer["state"], "plan", "{answer}");
    let execute = json!({"plan": answer["plan"]});
    let refused = bench.node(&json!({"do": "call", "kind": "execute", "request": execute}));
    check_refused(&refused, "nobody has approved this plan");
}
