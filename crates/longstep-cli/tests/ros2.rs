//! Plans on real action servers of `rclpy`, through a real rosbridge server, on the loopback interface.
//!
//! `LONGSTEP_ROS2=$(scripts/robots/ros2.sh) cargo test -p longstep-cli --test ros2 -- --ignored --nocapture`
#![cfg(unix)]
#![allow(clippy::disallowed_macros, clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::net::{TcpListener, TcpStream};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU16, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use common::{PANTRY, ended, longstep, root};
use serde_json::Value;
use tempfile::TempDir;

const GOAL: &str = "put(butter, counter) & closed(fridge)";
/// The longest that anything may take.
const LONGEST: Duration = Duration::from_secs(60);

/// ROS domains of this run of the tests: other runs on this machine should not see them.
static NEXT_DOMAIN: AtomicU16 = AtomicU16::new(0);

fn installation() -> PathBuf {
    PathBuf::from(std::env::var("LONGSTEP_ROS2").unwrap())
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn signal(id: u32, name: &str) {
    let status = Command::new("kill")
        .args([&format!("-{name}"), &id.to_string()])
        .stderr(Stdio::null())
        .status();
    assert!(status.is_ok());
}

/// A program that ends with the test.
struct Program(Child);

impl Program {
    fn start(command: &mut Command) -> Self {
        // In a group of its own, so that what it starts ends with it.
        Self(command.stdin(Stdio::null()).process_group(0).spawn().unwrap())
    }

    fn signal(&self, name: &str) {
        signal(self.0.id(), name);
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let group = format!("-{}", self.0.id());
        let _ = Command::new("kill")
            .args(["-KILL", "--", &group])
            .stderr(Stdio::null())
            .status();
        let _ = self.0.wait();
    }
}

/// A robot and a bridge in a ROS domain of their own, and a plan.
struct Bench {
    folder: TempDir,
    domain: u16,
    port: u16,
    environment: PathBuf,
    robot: Option<Program>,
    bridge: Option<Program>,
}

impl Bench {
    /// Starts a robot with these faults, and a bridge.
    fn new(faults: &[&str]) -> Self {
        let mut bench = Self::with_plan(&["--goal", GOAL, "--env", PANTRY], PANTRY);
        bench.start_robot(faults);
        bench.start_bridge();
        bench
    }

    fn with_plan(solve: &[&str], environment: &str) -> Self {
        let folder = TempDir::new().unwrap();
        let solved = longstep(folder.path())
            .arg("solve")
            .args(solve)
            .arg("--save")
            .arg(folder.path().join("plan.json"))
            .output()
            .unwrap();
        assert_eq!(solved.status.code(), Some(0), "{}", text(&solved.stderr));
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let number = u32::from(NEXT_DOMAIN.fetch_add(1, Ordering::SeqCst)) + std::process::id();
        let bench = Self {
            environment: root().join(environment),
            domain: u16::try_from(1 + number % 100).unwrap(),
            port,
            folder,
            robot: None,
            bridge: None,
        };
        let toml = fs::read_to_string(root().join("examples/robots/ros2/robot.toml")).unwrap();
        // A busy machine finds the parts of a robot slowly.
        bench.configure(&toml.replace("[timeouts]\n", "[timeouts]\nconnect = 60\n"));
        bench
    }

    /// Writes `robot.toml`, with the port of this bench.
    fn configure(&self, toml: &str) {
        fs::write(self.path("robot.toml"), toml.replace("9090", &self.port.to_string())).unwrap();
    }

    fn reconfigure(&self, from: &str, to: &str) {
        let toml = fs::read_to_string(self.path("robot.toml")).unwrap();
        assert!(toml.contains(from), "{from}");
        fs::write(self.path("robot.toml"), toml.replace(from, to)).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn start_robot(&mut self, faults: &[&str]) {
        let mut command = Command::new(installation().join("python"));
        command
            .arg(root().join("crates/longstep-cli/tests/robots/ros2_robot.py"))
            .args([&self.environment, self.folder.path()])
            .args(faults)
            .env("ROS_DOMAIN_ID", self.domain.to_string())
            .stdout(Stdio::piped())
            .stderr(fs::File::create(self.path("robot.log")).unwrap());
        let mut robot = Program::start(&mut command);
        let mut line = String::new();
        BufReader::new(robot.0.stdout.take().unwrap())
            .read_line(&mut line)
            .unwrap();
        assert_eq!(
            line,
            "ready\n",
            "{}",
            fs::read_to_string(self.path("robot.log")).unwrap()
        );
        self.robot = Some(robot);
    }

    fn start_bridge(&mut self) {
        let mut command = Command::new(installation().join("bridge"));
        command
            .args(["--bind", &format!("127.0.0.1:{}", self.port)])
            .env("ROS_DOMAIN_ID", self.domain.to_string())
            .env("ROS_LOG_DIR", self.path("bridge-log"))
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        self.bridge = Some(Program::start(&mut command));
        let begun = Instant::now();
        while TcpStream::connect(("127.0.0.1", self.port)).is_err() {
            assert!(begun.elapsed() < LONGEST, "the bridge does not listen");
            thread::sleep(Duration::from_millis(10));
        }
        // The bridge has to discover the robot before anybody asks it.
        let begun = Instant::now();
        loop {
            let checked = self.check();
            if checked.status.code() == Some(0) {
                return;
            }
            assert!(begun.elapsed() < LONGEST, "{}", text(&checked.stdout));
        }
    }

    fn check(&self) -> Output {
        longstep(self.folder.path())
            .args(["robot", "check"])
            .arg(self.path("robot.toml"))
            .args(self.domain_arguments())
            .arg("--env")
            .arg(&self.environment)
            .output()
            .unwrap()
    }

    fn domain_arguments(&self) -> &[&str] {
        let is_dual = self.environment.ends_with("arms.json");
        if is_dual { &["--domain", "household-dual"] } else { &[] }
    }

    fn command(&self, log: &str, more: &[&str]) -> Command {
        let mut command = longstep(self.folder.path());
        command
            .arg("run")
            .arg(self.path("plan.json"))
            .args(self.domain_arguments())
            .arg("--robot")
            .arg(format!("ros2:{}", self.path("robot.toml").display()))
            .arg("--log")
            .arg(self.path(log))
            .args(more)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    /// Runs the plan for real.
    fn run(&self, log: &str) -> Output {
        ended(self.live(log).spawn().unwrap(), LONGEST)
    }

    fn live(&self, log: &str) -> Command {
        self.command(log, &["--live", "--approve", "never"])
    }

    fn resume(&self, log: &str) -> Command {
        let mut command = longstep(self.folder.path());
        command
            .args(["run", "--live", "--resume"])
            .arg(self.path(log))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    fn events(&self, log: &str) -> Vec<Value> {
        let text = fs::read_to_string(self.path(log)).unwrap_or_default();
        text.lines()
            .skip(1)
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    }

    /// The events that the robot wrote down: `done 3 grasp(<butter>)`.
    fn journal(&self) -> Vec<String> {
        let text = fs::read_to_string(self.path("journal")).unwrap_or_default();
        text.lines().map(str::to_owned).collect()
    }

    /// The steps that the robot did, as its world has them: `3 grasp(<butter>)`.
    fn performed(&self) -> Vec<String> {
        let text = fs::read_to_string(self.path("world.json")).unwrap_or("{\"performed\": []}".to_owned());
        let world: Value = serde_json::from_str(&text).unwrap();
        let performed = world["performed"].as_array().unwrap().iter();
        performed.map(|own| own.as_str().unwrap().to_owned()).collect()
    }

    fn count(&self, event: &str) -> usize {
        self.journal().iter().filter(|line| line.starts_with(event)).count()
    }

    /// Waits until the robot wrote down an event.
    fn wait_for(&self, event: &str) {
        let begun = Instant::now();
        while !self.journal().iter().any(|line| line.starts_with(event)) {
            assert!(begun.elapsed() < LONGEST, "no `{event}`: {:?}", self.journal());
            thread::sleep(Duration::from_millis(2));
        }
    }
}

#[track_caller]
fn check_end(output: &Output, code: i32, words: &str) {
    let both = text(&output.stdout) + &text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{both}");
    assert!(both.contains(words), "no `{words}` in:\n{both}");
}

#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn a_verified_plan_runs_on_real_action_servers() {
    let bench = Bench::new(&[]);
    let checked = bench.check();
    for words in [
        "fits the domain `household`",
        ": connected",
        "/execute_step: answers, longstep_msgs/action/ExecuteStep",
    ] {
        check_end(&checked, 0, words);
    }
    let dry = ended(bench.command("dry.jsonl", &[]).spawn().unwrap(), LONGEST);
    check_end(
        &dry,
        0,
        "would send {\"op\":\"send_action_goal\",\"action\":\"/execute_step\"",
    );
    assert!(bench.journal().is_empty(), "a dry run moves nothing");
    check_end(
        &ended(bench.resume("dry.jsonl").spawn().unwrap(), LONGEST),
        30,
        "dry run",
    );
    check_end(&bench.run("live.jsonl"), 0, "the goal is reached in the observed world");
    assert!(bench.count("done") >= 10, "{:?}", bench.journal());
    assert_eq!(bench.count("begun"), bench.count("done"));
}

#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn an_abort_is_mended_from_what_is_observed() {
    // Step 3 of the way to the shelf: the cereal falls from the hand to the floor.
    let mut bench = Bench::with_plan(&["--goal", "put(cereal, counter)", "--env", PANTRY], PANTRY);
    bench.start_robot(&["2=abort"]);
    bench.start_bridge();
    let output = bench.run("run.jsonl");
    check_end(&output, 0, "failed: it slipped");
    check_end(&output, 0, "the cereal is on the floor");
    let kinds: Vec<Value> = bench
        .events("run.jsonl")
        .iter()
        .map(|event| event["event"].clone())
        .collect();
    assert!(
        kinds.contains(&"failed".into()) && kinds.contains(&"assessed".into()),
        "{kinds:?}"
    );
}

#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn an_abort_that_ends_the_run_stops_everything_else() {
    let bench = Bench::new(&["3=abort"]);
    bench.reconfigure("done = ", "aborted = \"stop\"\ndone = ");
    check_end(
        &bench.run("run.jsonl"),
        51,
        "step 3 was aborted by the robot: it slipped",
    );
    assert_eq!(bench.count("begun"), 3);
}

#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn ctrl_c_cancels_and_the_server_sees_it() {
    let bench = Bench::new(&["4=hang"]);
    let child = bench.live("run.jsonl").spawn().unwrap();
    bench.wait_for("begun 4");
    signal(child.id(), "INT");
    check_end(&ended(child, LONGEST), 50, "stopped at a request");
    bench.wait_for("cancelled 4");
    assert_eq!(bench.count("begun"), 4);
    let events = bench.events("run.jsonl");
    assert_eq!(events.last().unwrap()["under_way"], serde_json::json!([4]));
}

#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn one_run_drives_a_robot_at_a_time() {
    let bench = Bench::new(&["2=slow", "3=hang"]);
    let first = bench.live("first.jsonl").spawn().unwrap();
    bench.wait_for("begun 3");
    check_end(&bench.run("second.jsonl"), 55, "another program drives the robot");
    signal(first.id(), "KILL");
    drop(ended(first, LONGEST));
    // The connection is gone, and the heartbeat with it: the robot stands still by itself.
    let begun = Instant::now();
    while bench.count("cancelled 3") + bench.count("aborted 3") == 0 {
        assert!(begun.elapsed() < LONGEST, "{:?}", bench.journal());
        thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(bench.count("begun"), 3);
}

#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn failures_have_their_own_messages_and_exit_codes() {
    let bench = Bench::new(&["3=reject"]);
    check_end(&bench.run("rejected.jsonl"), 54, "the robot rejected step 3: ");
    assert_eq!((bench.count("begun"), bench.count("rejected")), (2, 1));
    let before = bench.journal();

    bench.reconfigure("\"/execute_step\"", "\"/nobody\"");
    bench.reconfigure("connect = 60", "connect = 1");
    check_end(&bench.run("missing.jsonl"), 56, "no action server `/nobody` answers");
    bench.reconfigure("\"/nobody\"", "\"/execute_step\"");
    bench.reconfigure("longstep_msgs/action/ExecuteStep", "test_msgs/action/Fibonacci");
    check_end(
        &bench.run("type.jsonl"),
        57,
        "`/execute_step` does not have the type `test_msgs/action/Fibonacci`",
    );
    bench.reconfigure("test_msgs/action/Fibonacci", "longstep_msgs/action/ExecuteStep");
    bench.reconfigure("step = \"{step}\"", "stop = \"{step}\"");
    check_end(&bench.run("field.jsonl"), 54, "the robot rejected step 1: ");
    bench.reconfigure("stop = \"{step}\"", "step = \"{item}\"");
    check_end(&bench.run("hole.jsonl"), 30, "has no parameter `item`");
    bench.reconfigure("step = \"{item}\"", "step = \"{step}\"");
    bench.reconfigure("ws://127.0.0.1", "ws://127.0.0.2");
    check_end(
        &bench.run("unreachable.jsonl"),
        52,
        "cannot start the robot `ws://127.0.0.2:",
    );
    bench.reconfigure("ws://127.0.0.2", "ws://127.0.0.1");
    assert_eq!(bench.journal(), before, "nothing was performed after the first failure");
}

#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn a_robot_that_falls_silent_ends_the_run() {
    let bench = Bench::new(&["3=slow"]);
    bench.reconfigure("perform = 10", "perform = 2\nstop = 0.5");
    let child = bench.live("run.jsonl").spawn().unwrap();
    bench.wait_for("begun 3");
    let robot = bench.robot.as_ref().unwrap();
    robot.signal("STOP");
    check_end(&ended(child, LONGEST), 53, "the robot did not answer within");
    robot.signal("CONT");
    thread::sleep(Duration::from_secs(1));
    assert_eq!(bench.count("begun"), 3, "{:?}", bench.journal());
}

#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn a_bridge_that_is_killed_and_restarted_is_gone_on_with() {
    let mut bench = Bench::new(&["5=hang"]);
    let child = bench.live("run.jsonl").spawn().unwrap();
    bench.wait_for("begun 5");
    bench.bridge = None;
    let output = ended(child, LONGEST);
    check_end(&output, 52, "the robot failed: the robot is gone");
    check_end(&output, 52, "longstep run --resume");
    // The robot hears no heartbeat any more.
    bench.wait_for("aborted 5");
    assert_eq!(bench.count("begun"), 5);
    check_end(
        &ended(bench.resume("run.jsonl").spawn().unwrap(), LONGEST),
        52,
        "cannot start the robot",
    );
    bench.start_bridge();
    let mut child = bench.resume("run.jsonl").stdin(Stdio::piped()).spawn().unwrap();
    // Step 5 moves the hand, which no observation shows.
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), b"n\n").unwrap();
    check_end(&ended(child, LONGEST), 0, "the goal is reached in the observed world");
    assert_eq!(repeated(&bench.performed()), BTreeMap::new());
}

/// Goals outlive Longstep where the robot does not listen for the heartbeat.
#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn a_goal_that_a_killed_run_left_has_ended_before_the_run_goes_on() {
    let mut bench = Bench::new(&["5=outlive"]);
    let child = bench.live("run.jsonl").spawn().unwrap();
    bench.wait_for("begun 5");
    // A bridge that lives may cancel the goals of a client that is gone, as this one does.
    bench.bridge = None;
    signal(child.id(), "KILL");
    drop(ended(child, LONGEST));
    bench.start_bridge();
    let refused = bench.run("new.jsonl");
    check_end(&refused, 55, "`/execute_step` has a goal under way: ");
    assert_eq!((bench.count("begun"), bench.count("cancelled")), (5, 0));
    let mut child = bench.resume("run.jsonl").stdin(Stdio::piped()).spawn().unwrap();
    // Step 5 moves the hand, which no observation shows.
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), b"n\n").unwrap();
    let output = ended(child, LONGEST);
    check_end(&output, 0, "the goal is reached in the observed world");
    check_end(
        &output,
        0,
        "Cancelled what the interrupted run had left under way: 1 goal",
    );
    let journal = bench.journal();
    let place = |event: &str| journal.iter().position(|line| line.starts_with(event)).unwrap();
    assert!(place("cancelled 5") < place("begun 6"), "{journal:?}");
    assert_eq!(place("cancelled 5"), place("begun 5") + 1, "{journal:?}");
    assert_eq!(repeated(&bench.performed()), BTreeMap::new());
}

#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn a_goal_that_a_killed_run_left_and_nobody_can_cancel_is_waited_for_or_refused() {
    let bench = Bench::new(&["5=stubborn"]);
    bench.reconfigure("[timeouts]", "[timeouts]\nstop = 0.5");
    let child = bench.live("run.jsonl").spawn().unwrap();
    bench.wait_for("begun 5");
    signal(child.id(), "KILL");
    drop(ended(child, LONGEST));
    let refused = ended(bench.resume("run.jsonl").spawn().unwrap(), LONGEST);
    check_end(&refused, 55, "the server does not accept its cancellation");
    assert_eq!(bench.count("begun"), 5);
    bench.wait_for("done 5");
    let mut child = bench.resume("run.jsonl").stdin(Stdio::piped()).spawn().unwrap();
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), b"y\n").unwrap();
    let output = ended(child, LONGEST);
    check_end(&output, 0, "the goal is reached in the observed world");
    assert_eq!(repeated(&bench.performed()), BTreeMap::new());
}

/// The steps that were done more than once.
fn repeated(performed: &[String]) -> BTreeMap<&str, usize> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for line in performed {
        *counts.entry(line.split_once(' ').unwrap().1).or_default() += 1;
    }
    // The plan itself grasps and releases the handle twice.
    counts.retain(|call, count| *count > 1 + usize::from(call.contains("fridge_handle") && !call.contains("-by-")));
    counts
}

/// Kills the bridge or the robot at a moment of a run, and takes the run up again.
fn killed_at(number: u64) {
    let mut bench = Bench::new(&[]);
    bench.reconfigure("perform = 10", "perform = 3\naccept = 3\nobserve = 3\nstop = 0.3");
    let log = "run.jsonl";
    let mut draw = number.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 33;
    let kills_bridge = draw.is_multiple_of(2);
    draw /= 2;
    let moment = 1 + draw % 14;
    let mut child = bench.live(log).spawn().unwrap();
    let begun = format!("begun {moment} ");
    // On a busy machine the run may end before that moment, because the robot took too long.
    while bench.count(&begun) == 0 && child.try_wait().unwrap().is_none() {
        thread::sleep(Duration::from_millis(2));
    }
    thread::sleep(Duration::from_millis(draw / 14 % 60));
    if kills_bridge {
        bench.bridge = None;
    } else {
        bench.robot = None;
    }
    let output = ended(child, LONGEST);
    if output.status.code() != Some(0) {
        let what = if kills_bridge { "bridge" } else { "robot" };
        assert!(
            matches!(output.status.code(), Some(51..=53)),
            "{what} at {moment}: {}",
            text(&output.stderr)
        );
        let before = bench.events(log);
        let stopped = before.last().unwrap();
        assert_eq!(stopped["event"], "stopped");
        if kills_bridge {
            // The robot notices that nobody is there.
            thread::sleep(Duration::from_millis(2_200));
            bench.start_bridge();
        } else {
            bench.start_robot(&[]);
            bench.bridge = None;
            bench.start_bridge();
        }
        go_on(&bench, log, stopped);
        let after = bench.events(log);
        assert_eq!(after[..before.len()], before[..], "no event is lost");
    }
    let after = bench.events(log);
    assert_eq!(after.last().unwrap()["event"], "done");
    let environment = &after.last().unwrap()["environment"];
    assert_eq!(environment["object_states"]["<butter>"], "on_something(<counter>)");
    let performed = bench.performed();
    assert_eq!(repeated(&performed), BTreeMap::new(), "{number}: {performed:?}");
    assert_eq!(performed.len(), 14, "{number}: {performed:?}");
}

/// Resumes a run, and answers the question about a step that no observation shows by what the robot wrote down.
fn go_on(bench: &Bench, log: &str, stopped: &Value) {
    let under_way = stopped["under_way"].as_array().unwrap();
    let was_done = |order: &Value| {
        let done = format!("{order} ");
        bench.performed().iter().any(|line| line.starts_with(&done))
    };
    let answers: String = under_way
        .iter()
        .map(|order| if was_done(order) { "y\n" } else { "n\n" })
        .collect();
    let mut child = bench.resume(log).stdin(Stdio::piped()).spawn().unwrap();
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), answers.as_bytes()).unwrap();
    check_end(&ended(child, LONGEST), 0, "the goal is reached in the observed world");
}

/// With `LONGSTEP_ROS2_KILLS=50` this kills at as many moments.
#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn a_robot_that_dies_at_any_moment_repeats_no_step() {
    let count = std::env::var("LONGSTEP_ROS2_KILLS")
        .ok()
        .and_then(|own| own.parse().ok())
        .unwrap_or(4);
    for number in 1..=count {
        killed_at(number);
    }
}

#[test]
#[ignore = "needs LONGSTEP_ROS2"]
fn two_arms_run_at_the_same_time() {
    let environment = r#"{"assets": ["<table>", "<left_shelf>", "<right_shelf>"], "objects": ["<cup>", "<pen>"],
        "asset_states": {"<left_shelf>": "reachable_by(left)", "<right_shelf>": "reachable_by(right)"},
        "object_states": {"<cup>": "on_something(<table>)", "<pen>": "on_something(<table>)"}}"#;
    let world = TempDir::new().unwrap();
    let file = world.path().join("arms.json");
    fs::write(&file, environment).unwrap();
    let file = file.to_str().unwrap();
    let goal = "put(cup, left shelf) & put(pen, right shelf)";
    let mut bench = Bench::with_plan(
        &[
            "--goal",
            goal,
            "--env",
            file,
            "--domain",
            "household-dual",
            "--parallel",
        ],
        file,
    );
    let toml = fs::read_to_string(Path::new(&bench.path("robot.toml"))).unwrap();
    let by_lane = "server = { left = \"/left/execute_step\", right = \"/right/execute_step\" }";
    let toml = toml.replace("server = \"/execute_step\"", by_lane);
    fs::write(
        bench.path("robot.toml"),
        toml.replace("rate = 20", "rate = 100\nparallel = 2"),
    )
    .unwrap();
    bench.reconfigure(", \"open-by-rotate\", \"close-by-rotate\"", "");
    bench.start_robot(&["arms"]);
    bench.start_bridge();
    check_end(&bench.run("run.jsonl"), 0, "the goal is reached in the observed world");
    let journal = bench.journal();
    let (mut running, mut most) = (0, 0);
    for line in &journal {
        running += i32::from(line.starts_with("begun")) - i32::from(line.starts_with("done"));
        most = most.max(running);
    }
    assert_eq!(most, 2, "{journal:?}");
}
