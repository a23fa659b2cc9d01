//! The program carries out plans on robots: in the simulator, and behind programs that hang, until a signal or a kill.
#![cfg(unix)]
#![allow(clippy::disallowed_macros, clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::{Answer, PANTRY, Server, check_log, ended, goals, longstep, question};
use serde_json::Value;
use tempfile::TempDir;

const GOAL: &str = "put(butter, counter) & closed(fridge)";

/// A folder with a plan for [`GOAL`].
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        let plan = folder.path().join("plan.json");
        let solved = longstep(folder.path())
            .args(["solve", "--goal", GOAL, "--env", PANTRY, "--save"])
            .arg(&plan)
            .output()
            .unwrap();
        assert_eq!(
            solved.status.code(),
            Some(0),
            "{}",
            String::from_utf8_lossy(&solved.stderr)
        );
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, log: &str, robot: &str, more: &[&str]) -> Command {
        let mut command = longstep(self.folder.path());
        command
            .arg("run")
            .arg(self.path("plan.json"))
            .args(["--goal", GOAL, "--robot", robot]);
        command.arg("--log").arg(self.path(log)).args(more);
        command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    fn events(&self, log: &str) -> Vec<Value> {
        let text = fs::read_to_string(self.path(log)).unwrap();
        // A line that a kill cut off is no event.
        let complete = text.rfind('\n').map_or(0, |end| end + 1);
        text[..complete]
            .lines()
            .skip(1)
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    }
}

fn kill(id: u32, signal: &str) {
    let sent = Command::new("kill")
        .arg(format!("-{signal}"))
        .arg(id.to_string())
        .status()
        .unwrap();
    assert!(sent.success());
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn run_completes_in_the_simulator_despite_faults() {
    let bench = Bench::new();
    for (index, robot) in [
        "sim",
        "sim:seed=3,faults=1,kinds=moved",
        "sim:seed=5,faults=2,kinds=slips+fails",
    ]
    .iter()
    .enumerate()
    {
        let log = format!("{index}.jsonl");
        let output = bench
            .command(&log, robot, &["--approve", "never", "--json"])
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{robot}: {}", text(&output.stderr));
        let lines = text(&output.stdout);
        let last: Value = serde_json::from_str(lines.lines().last().unwrap()).unwrap();
        assert_eq!(last["event"], "done");
        assert_eq!(
            last["environment"]["object_states"]["<butter>"],
            "on_something(<counter>)"
        );
        // What is printed is what is in the log, where each event has its time.
        let printed: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let mut events = bench.events(&log);
        for event in &mut events {
            let at = event.as_object_mut().unwrap().remove("at");
            assert!(at.is_some_and(|at| at.as_str().is_some_and(|at| at.ends_with('Z'))));
        }
        assert_eq!(printed, events);
    }
}

#[test]
fn runs_export_writes_the_same_recording_of_a_log_each_time() {
    let bench = Bench::new();
    let robot = "sim:seed=5,faults=2,kinds=slips+fails";
    let output = bench
        .command("run.jsonl", robot, &["--approve", "never"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let export = |log: &str, file: &str| {
        let mut command = longstep(bench.folder.path());
        command.args(["runs", "export"]).arg(bench.path(log));
        command.arg("--output").arg(bench.path(file)).output().unwrap()
    };
    for file in ["one.mcap", "other.mcap"] {
        let output = export("run.jsonl", file);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    }
    let one = fs::read(bench.path("one.mcap")).unwrap();
    assert!(one.starts_with(b"\x89MCAP0\r\n") && one.ends_with(b"\x89MCAP0\r\n"));
    assert_eq!(one, fs::read(bench.path("other.mcap")).unwrap());
    let missing = export("no.jsonl", "no.mcap");
    assert_eq!(missing.status.code(), Some(30));
    assert!(text(&missing.stderr).contains("longstep runs list") && !bench.path("no.mcap").exists());
}

/// From words to a changed world in one command.
#[test]
fn an_instruction_runs_in_the_simulator() {
    for (answers, instruction, code) in [
        (
            vec![goals(&[GOAL])],
            "Put the butter on the counter and close the fridge",
            0,
        ),
        (vec![question("Which butter?")], "Put it away", 13),
    ] {
        let home = TempDir::new().unwrap();
        let server = Server::giving(answers);
        let output = longstep(home.path())
            .args(["run", instruction, "--env", PANTRY, "--model", &server.reference()])
            .args(["--robot", "sim:seed=2,faults=1", "--approve", "never", "--save-after"])
            .arg(home.path().join("after.json"))
            .arg("--log")
            .arg(home.path().join("run.jsonl"))
            .stdin(Stdio::null())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(code), "{}", text(&output.stderr));
        if code == 0 {
            let after: Value = serde_json::from_slice(&fs::read(home.path().join("after.json")).unwrap()).unwrap();
            assert_eq!(after["object_states"]["<butter>"], "on_something(<counter>)");
            assert_eq!(after["object_states"]["<fridge_handle>"], "closed()");
        } else {
            assert!(!home.path().join("run.jsonl").exists(), "nothing has run");
        }
    }
}

#[test]
fn run_shows_omissions_of_a_saved_plan_before_it_starts() {
    let home = TempDir::new().unwrap();
    let answer = serde_json::json!({"goal": GOAL, "left_out": [{"text": "by noon", "kind": "time"}], "question": ""});
    let server = Server::giving(vec![Answer::Says(answer.to_string())]);
    let planned = longstep(home.path())
        .args([
            "plan",
            "Put the butter on the counter and close the fridge by noon",
            "--env",
            PANTRY,
        ])
        .args(["--model", &server.reference(), "--save"])
        .arg(home.path().join("plan.json"))
        .output()
        .unwrap();
    assert_eq!(planned.status.code(), Some(0), "{}", text(&planned.stderr));
    let output = longstep(home.path())
        .arg("run")
        .arg(home.path().join("plan.json"))
        .args(["--robot", "sim"])
        .stdin(Stdio::null())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(50), "{}", text(&output.stderr));
    let told = text(&output.stderr);
    assert!(told.contains("Not in the plan: \"by noon\""), "{told}");
}

#[test]
fn a_plan_that_nobody_approves_does_not_run() {
    let bench = Bench::new();
    for (index, answer) in ["", "n\n"].iter().enumerate() {
        let log = format!("{index}.jsonl");
        let mut command = bench.command(&log, "sim", &[]);
        let mut child = command.stdin(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(answer.as_bytes()).unwrap();
        let output = ended(child, Duration::from_secs(60));
        assert_eq!(output.status.code(), Some(50), "{}", text(&output.stderr));
        let events = bench.events(&log);
        assert!(events.iter().all(|event| event["event"] != "ordered"), "{events:?}");
    }
    let mut child = bench
        .command("yes.jsonl", "sim", &[])
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(b"what?\ny\n").unwrap();
    assert_eq!(ended(child, Duration::from_secs(60)).status.code(), Some(0));
}

#[test]
fn run_rejects_an_invalid_robot_argument() {
    let bench = Bench::new();
    for robot in [
        "drone",
        "sim:faults=many",
        "process:",
        "process:/no/such/program",
        "ros2:",
        "ros2:no/such/robot.toml",
        "ros2:Cargo.toml",
    ] {
        let output = bench
            .command("x.jsonl", robot, &["--approve", "never"])
            .output()
            .unwrap();
        assert!(matches!(output.status.code(), Some(30 | 52)), "{robot}: {output:?}");
        let is_configuration = robot.ends_with(".toml");
        assert!(is_configuration || text(&output.stderr).contains("hint:"), "{robot}");
    }
}

/// A robot whose steps never end, and which writes down when it is told to stop.
const HANGING: &str = r#"
import json, sys, time
def answer(id, result):
    print(json.dumps({"jsonrpc": "2.0", "id": id, "result": result}), flush=True)
for line in sys.stdin:
    message = json.loads(line)
    method = message["method"]
    if method == "initialize":
        answer(message["id"], {"protocol": 1, "name": "hanging", "simulated": True, "capabilities": {"observe": True}})
    elif method == "observe":
        answer(message["id"], {"states": {}})
    elif method == "perform":
        open(sys.argv[1], "w").write("performing")
    elif method == "stop":
        open(sys.argv[2], "w").write(repr(time.time()))
        answer(message["id"], {})
"#;

/// Sends a signal while a step hangs; returns the time until the robot was told to stop.
fn stopped(bench: &Bench, number: usize, signal: &str) -> Duration {
    let file = |name: &str| bench.path(&format!("{name}-{number}"));
    fs::write(bench.path("robot.py"), HANGING).unwrap();
    let robot = format!(
        "process:python3 {} {} {}",
        bench.path("robot.py").display(),
        file("performing").display(),
        file("stopped").display()
    );
    let log = format!("signal-{number}.jsonl");
    let child = bench.command(&log, &robot, &["--approve", "never"]).spawn().unwrap();
    let begun = Instant::now();
    while !file("performing").exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "the robot got no step");
        thread::sleep(Duration::from_millis(2));
    }
    let sent = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .unwrap();
    kill(child.id(), signal);
    let output = ended(child, Duration::from_secs(60));
    assert_eq!(output.status.code(), Some(50), "{}", text(&output.stderr));
    let events = bench.events(&log);
    let last = events.last().unwrap();
    assert_eq!(
        (&last["event"], &last["under_way"]),
        (&"stopped".into(), &serde_json::json!([1]))
    );
    let at: f64 = fs::read_to_string(file("stopped")).unwrap().parse().unwrap();
    Duration::from_secs_f64((at - sent.as_secs_f64()).max(0.0))
}

/// A robot that takes its time before it is ready, and which writes down when it is told to stop.
const SLOW: &str = r#"
import json, sys
for line in sys.stdin:
    message = json.loads(line)
    with open(sys.argv[1], "a") as file:
        file.write(message["method"] + "\n")
    if message["method"] != "initialize":
        print(json.dumps({"jsonrpc": "2.0", "id": message["id"], "result": {}}), flush=True)
"#;

#[test]
fn a_signal_stops_a_robot_that_is_being_opened() {
    let bench = Bench::new();
    fs::write(bench.path("slow.py"), SLOW).unwrap();
    for signal in ["INT", "TERM", "HUP"] {
        let notes = bench.path(&format!("notes-{signal}"));
        let robot = format!(
            "process:python3 {} {}",
            bench.path("slow.py").display(),
            notes.display()
        );
        let log = format!("opening-{signal}.jsonl");
        let child = bench.command(&log, &robot, &["--approve", "never"]).spawn().unwrap();
        let begun = Instant::now();
        while !notes.exists() {
            assert!(begun.elapsed() < Duration::from_secs(60), "the robot is not opened");
            thread::sleep(Duration::from_millis(2));
        }
        kill(child.id(), signal);
        let output = ended(child, Duration::from_secs(60));
        assert_eq!(output.status.code(), Some(50), "{}", text(&output.stderr));
        assert!(
            text(&output.stderr).contains("nothing has moved"),
            "{}",
            text(&output.stderr)
        );
        let methods = fs::read_to_string(&notes).unwrap();
        assert!(methods.starts_with("initialize\nstop\n"), "{methods}");
        assert!(!bench.path(&log).exists(), "a run that did not begin has no log");
    }
}

/// A robot that does not observe cannot take up a run: what it did is not known.
#[test]
fn a_run_is_taken_up_again_only_by_a_robot_that_observes() {
    let bench = Bench::new();
    let output = bench
        .command("one.jsonl", "sim:faults=1,kinds=fails", &["--approve", "never"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let whole = fs::read_to_string(bench.path("one.jsonl")).unwrap();
    let cut: String = whole.lines().take(4).map(|line| format!("{line}\n")).collect();
    fs::write(bench.path("cut.jsonl"), &cut).unwrap();
    let blind = r#"import json, sys
for line in sys.stdin:
    message = json.loads(line)
    result = {"protocol": 1, "name": "blind"} if message["method"] == "initialize" else {}
    print(json.dumps({"jsonrpc": "2.0", "id": message["id"], "result": result}), flush=True)
"#;
    fs::write(bench.path("blind.py"), blind).unwrap();
    let output = longstep(bench.folder.path())
        .args(["run", "--resume"])
        .arg(bench.path("cut.jsonl"))
        .args([
            "--robot",
            &format!("process:python3 {}", bench.path("blind.py").display()),
            "--live",
        ])
        .stdin(Stdio::null())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(30), "{}", text(&output.stderr));
    assert!(
        text(&output.stderr).contains("does not observe"),
        "{}",
        text(&output.stderr)
    );
    assert_eq!(
        fs::read_to_string(bench.path("cut.jsonl")).unwrap(),
        cut,
        "the log is as it was"
    );
}

/// With `LONGSTEP_SIGNALS=100` this measures: the median of the times is printed.
#[test]
fn a_signal_stops_the_robot_while_a_step_hangs() {
    let bench = Bench::new();
    let count = std::env::var("LONGSTEP_SIGNALS")
        .ok()
        .and_then(|own| own.parse().ok())
        .unwrap_or(3);
    let signals = ["INT", "TERM", "HUP"];
    let mut times: Vec<Duration> = (0..count)
        .map(|number| stopped(&bench, number, signals[number % 3]))
        .collect();
    times.sort_unstable();
    eprintln!(
        "from signal to stop: median {:?}, most {:?}",
        times[times.len() / 2],
        times[times.len() - 1]
    );
}

#[test]
fn real_robot_moves_only_with_live_and_for_one_run_at_a_time() {
    let bench = Bench::new();
    fs::write(bench.path("robot.py"), HANGING.replace("\"simulated\": True, ", "")).unwrap();
    let file = |name: &str| bench.path(name);
    let robot = format!(
        "process:python3 {} {} {}",
        file("robot.py").display(),
        file("performing").display(),
        file("stopped").display()
    );
    let dry = bench.command("dry.jsonl", &robot, &[]).output().unwrap();
    let shown = text(&dry.stdout);
    assert_eq!(dry.status.code(), Some(0), "{}", text(&dry.stderr));
    assert!(
        shown.contains("would send {\"step\":1,\"action\":\"move-hand\""),
        "{shown}"
    );
    assert!(shown.contains("nothing was sent"), "{shown}");
    assert!(!file("performing").exists());
    let resumed = longstep(bench.folder.path())
        .args(["run", "--resume"])
        .arg(bench.path("dry.jsonl"))
        .output()
        .unwrap();
    assert_eq!(resumed.status.code(), Some(30), "{}", text(&resumed.stderr));
    let kept = bench
        .command("kept.jsonl", &robot, &["--save-after", "after.json"])
        .output()
        .unwrap();
    assert_eq!(kept.status.code(), Some(30), "{}", text(&kept.stderr));

    let live = ["--live", "--approve", "never"];
    let first = bench.command("first.jsonl", &robot, &live).spawn().unwrap();
    let begun = Instant::now();
    while !file("performing").exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "the robot got no step");
        thread::sleep(Duration::from_millis(2));
    }
    let second = bench.command("second.jsonl", &robot, &live).output().unwrap();
    assert_eq!(second.status.code(), Some(55), "{}", text(&second.stderr));
    assert!(text(&second.stderr).contains("another program drives the robot `process hanging`"));
    kill(first.id(), "INT");
    assert_eq!(ended(first, Duration::from_secs(60)).status.code(), Some(50));
    // The lock is gone with the first run.
    fs::remove_file(file("performing")).unwrap();
    let third = bench.command("third.jsonl", &robot, &live).spawn().unwrap();
    let begun = Instant::now();
    while !file("performing").exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "the robot got no step");
        thread::sleep(Duration::from_millis(2));
    }
    kill(third.id(), "INT");
    assert_eq!(ended(third, Duration::from_secs(60)).status.code(), Some(50));
}

fn killed_at(bench: &Bench, number: u64) {
    let log = format!("killed-{number}.jsonl");
    let state = bench.path(&format!("state-{number}"));
    let robot = format!("sim:seed={number},pace=3,state={}", state.display());
    let mut command = bench.command(&log, &robot, &["--approve", "never"]);
    let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let mut wait = number.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 33;
    wait %= 120;
    thread::sleep(Duration::from_millis(wait));
    // It may have ended.
    let _ = Command::new("kill")
        .args(["-KILL", &child.id().to_string()])
        .stderr(Stdio::null())
        .status();
    ended(child, Duration::from_secs(60));
    if !bench.path(&log).exists() || bench.events(&log).is_empty() {
        return;
    }
    let before = bench.events(&log);
    let ended_before = before.last().is_some_and(|event| event["event"] == "done");
    let output = longstep(bench.folder.path())
        .args(["run", "--resume"])
        .arg(bench.path(&log))
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let after = bench.events(&log);
    assert_eq!(after[..before.len()], before[..], "no event is lost");
    check_log(&after);
    if ended_before {
        assert_eq!(output.status.code(), Some(30));
    } else {
        assert_eq!(output.status.code(), Some(0), "{number}: {}", text(&output.stderr));
        assert_eq!(after.last().unwrap()["event"], "done");
    }
}

/// With `LONGSTEP_KILLS=200` this kills at as many moments.
#[test]
fn a_killed_run_is_taken_up_again() {
    let bench = Bench::new();
    let count = std::env::var("LONGSTEP_KILLS")
        .ok()
        .and_then(|own| own.parse().ok())
        .unwrap_or(6);
    for number in 0..count {
        killed_at(&bench, number);
    }
}

#[test]
fn resume_rejects_a_file_that_is_no_run_log() {
    let bench = Bench::new();
    let resume = |path: &Path| {
        longstep(bench.folder.path())
            .args(["run", "--resume"])
            .arg(path)
            .output()
            .unwrap()
    };
    for content in [
        "",
        "{}\n",
        "{\"longstep_run\":1,\"robot\":\"sim\",\"domain\":\"household\"}\n",
        "\u{0}\n",
    ] {
        fs::write(bench.path("bad.jsonl"), content).unwrap();
        let output = resume(&bench.path("bad.jsonl"));
        assert_eq!(output.status.code(), Some(30), "{content:?}: {}", text(&output.stderr));
    }
    assert_eq!(resume(&bench.path("none.jsonl")).status.code(), Some(30));
}

#[test]
fn an_error_in_the_goal_has_its_own_hint() {
    let bench = Bench::new();
    for (goal, error, hint) in [
        ("put(spoon, counter)", "`spoon`", "lists the names of an environment"),
        ("polished(butter)", "is not a goal", "lists the goals"),
        ("put(butter, counter) &", "empty part", "write a goal on each side"),
        ("put(3 of butter, counter)", "requires 3 members", ""),
    ] {
        let mut command = longstep(bench.folder.path());
        command.arg("run").arg(bench.path("plan.json")).args(["--goal", goal]);
        command
            .args(["--robot", "sim", "--approve", "never", "--log"])
            .arg(bench.path("no.jsonl"));
        let output = command.output().unwrap();
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(30), "{goal}: {stderr}");
        assert!(stderr.contains(error) && !stderr.contains("teach"), "{goal}: {stderr}");
        match hint {
            "" => assert!(!stderr.contains("hint:"), "{goal}: {stderr}"),
            hint => assert!(stderr.contains(hint), "{goal}: {stderr}"),
        }
    }
}

#[test]
fn step_question_omits_the_full_stop_of_the_sentence() {
    let bench = Bench::new();
    let plan = fs::read_to_string(bench.path("plan.json")).unwrap();
    let mut plan: Value = serde_json::from_str(&plan).unwrap();
    for sentence in plan["task_cohesion"]["step_instructions"].as_array_mut().unwrap() {
        *sentence = Value::from(format!("{}.", sentence.as_str().unwrap()));
    }
    fs::write(bench.path("plan.json"), plan.to_string()).unwrap();
    let mut command = bench.command("stops.jsonl", "sim", &["--approve", "each-step"]);
    let mut child = command.stdin(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(b"y\ny\nn\n").unwrap();
    let output = child.wait_with_output().unwrap();
    let all = text(&output.stderr) + &text(&output.stdout);
    assert!(all.contains("Do this step: ") && !all.contains(".?"), "{all}");
}
