//! Teach and run in MuJoCo: a recording with noise gives back the scene's hinge and drawer, and the taught plan opens both.
//!
//! `LONGSTEP_MUJOCO=$(scripts/robots/mujoco.sh) cargo test -p longstep-cli --test mujoco_teach -- --ignored --nocapture`
#![cfg(unix)]
#![allow(clippy::disallowed_macros, clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::fs;
use std::path::Path;
use std::process::Output;

use common::longstep;
use common::talk::Talk;
use serde_json::Value;
use tempfile::TempDir;

const ENV: &str = r#"{"assets": ["<floor>", "<table>", "<fridge>", "<drawer>"],
    "asset_states": {"<fridge>": "on_something(<floor>)", "<drawer>": "on_something(<floor>)", "<table>": "on_something(<floor>)"},
    "objects": ["<fridge_handle>", "<drawer_handle>"],
    "object_states": {"<fridge_handle>": "closed()", "<drawer_handle>": "closed()"}}"#;
const GOAL: &str = "opened(fridge) & opened(drawer)";
/// The hinge of the fridge in the scene: its side, its front and the middle of its door (scene.py).
const HINGE: [f64; 3] = [1.05, -0.262, 0.575];
/// The distance of the handle from the hinge: 0.44 m along the door and 0.06 m in front of it.
const RADIUS: f64 = 0.444;
/// The openings to which the robot moves them by itself: shares of 110 degrees and of 0.3 m.
const ANGLE: f64 = 0.72 * 110.0;
const WAY: f64 = 0.95 * 0.3;

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        let bench = Self(TempDir::new().unwrap());
        fs::write(bench.file("env.json"), ENV).unwrap();
        let solved = bench.longstep(&[
            "solve",
            "--goal",
            GOAL,
            "--env",
            &bench.file("env.json"),
            "--save",
            &bench.file("plan.json"),
        ]);
        assert_eq!(solved.status.code(), Some(0), "{}", text(&solved.stderr));
        bench
    }

    fn file(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }

    fn longstep(&self, words: &[&str]) -> Output {
        longstep(self.0.path()).args(words).output().unwrap()
    }

    fn run(&self, domain: &str, log: &str, robot: &str, more: &[&str]) -> Output {
        let python = std::env::var("LONGSTEP_MUJOCO").unwrap();
        let program = root().join("examples/robots/mujoco/robot.py").display().to_string();
        let robot = format!("process:{python} {program} {robot}");
        let (plan, log) = (self.file("plan.json"), self.file(log));
        let words = [
            "run",
            &plan,
            "--domain",
            domain,
            "--robot",
            &robot,
            "--approve",
            "never",
            "--log",
            &log,
        ];
        self.longstep(&[&words[..], more].concat())
    }
}

fn vector(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|axis| value[axis].as_f64().unwrap())
}

fn distance(one: [f64; 3], other: [f64; 3]) -> f64 {
    (0..3).map(|axis| (one[axis] - other[axis]).powi(2)).sum::<f64>().sqrt()
}

#[test]
#[ignore = "needs LONGSTEP_MUJOCO, the Python that scripts/robots/mujoco.sh prints"]
fn a_taught_plan_opens_the_door_and_the_drawer() {
    let bench = Bench::new();
    let domain = root().join("examples/robots/mujoco/domain").display().to_string();
    let untaught = bench.run(&domain, "untaught.jsonl", "", &[]);
    assert_eq!(untaught.status.code(), Some(30), "{}", text(&untaught.stderr));
    let error = text(&untaught.stderr);
    assert!(
        error.contains("`open_by_rotate(<fridge_handle>)` has no `axis` (direction)"),
        "{error}"
    );
    assert!(!Path::new(&bench.file("untaught.jsonl")).exists());

    for seed in 1..=10 {
        let (demo, skills) = (
            bench.file(&format!("demo{seed}.csv")),
            bench.file(&format!("skills{seed}.json")),
        );
        let record = format!("--record {demo} --noise 0.005 --seed {seed}");
        let shown = bench.run("household", &format!("shown{seed}.jsonl"), &record, &[]);
        assert_eq!(shown.status.code(), Some(0), "{}", text(&shown.stderr));
        let taught = bench.longstep(&[
            "teach",
            &bench.file("plan.json"),
            "--domain",
            &domain,
            "--demo",
            &demo,
            "-o",
            &skills,
        ]);
        assert_eq!(
            taught.status.code(),
            Some(0),
            "{}{}",
            text(&taught.stdout),
            text(&taught.stderr)
        );

        let values: Value = serde_json::from_str(&fs::read_to_string(&skills).unwrap()).unwrap();
        let turn = &values["open-by-rotate"][0]["values"];
        let axis = vector(&turn["axis"]);
        let tilt = axis[2].abs().min(1.0).acos().to_degrees();
        let centre = distance(vector(&turn["centre"]), HINGE);
        let radius = turn["radius"].as_f64().unwrap() - RADIUS;
        let angle = turn["angle"].as_f64().unwrap().abs().to_degrees() - ANGLE;
        let slide = distance(
            vector(&values["open-by-slide"][0]["values"]["displacement"]),
            [0.0, -WAY, 0.0],
        );
        println!(
            "seed {seed}: axis {tilt:.2} degrees, centre {centre:.4} m, radius {radius:+.4} m, angle {angle:+.2} degrees, displacement {slide:.4} m"
        );
        assert!(tilt < 3.0 && centre < 0.03 && radius.abs() < 0.03 && angle.abs() < 5.0 && slide < 0.025);

        let run = bench.run(
            &domain,
            &format!("run{seed}.jsonl"),
            "",
            &["--skills", &skills, "--json"],
        );
        assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
        let events = text(&run.stdout);
        let last: Value = serde_json::from_str(events.lines().last().unwrap()).unwrap();
        assert_eq!(last["event"], "done");
        for handle in ["<fridge_handle>", "<drawer_handle>"] {
            assert_eq!(last["environment"]["object_states"][handle], "open()", "{last}");
        }
    }
}

/// The simulated hand as a hand tracker: each step is recorded live, and the taught plan opens both.
#[test]
#[ignore = "needs LONGSTEP_MUJOCO, the Python that scripts/robots/mujoco.sh prints"]
fn a_plan_is_taught_live_by_the_simulated_hand() {
    let bench = Bench::new();
    let python = std::env::var("LONGSTEP_MUJOCO").unwrap();
    let tracker = root().join("examples/robots/mujoco/tracker.py").display().to_string();
    let (plan, log) = (bench.file("plan.json"), bench.file("simulated.jsonl"));
    let (skills, shown) = (bench.file("skills.json"), bench.file("shown"));
    let run = ["run", &plan, "--robot", "sim", "--approve", "never", "--log", &log];
    assert_eq!(bench.longstep(&run).status.code(), Some(0));
    let recorder = format!("{python} {tracker} {log} --noise 0.005 --speed 4 --shown {shown}");
    let mut command = longstep(bench.0.path());
    let domain = root().join("examples/robots/mujoco/domain").display().to_string();
    command.args([
        "teach",
        &plan,
        "--domain",
        &domain,
        "-o",
        &skills,
        "--recorder",
        &recorder,
    ]);
    let mut talk = Talk::start(&mut command);
    // The robot finds its other ways by itself.
    for question in ["turn the fridge handle to open", "slide the drawer handle to open"] {
        talk.until(question);
        talk.say("");
        talk.until("Recording.");
        let begun = std::time::Instant::now();
        while !Path::new(&shown).exists() {
            assert!(begun.elapsed().as_secs() < 120, "the step is not shown");
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        fs::remove_file(&shown).unwrap();
        talk.say("");
        talk.until("Saved ");
    }
    let (code, errors, results) = talk.finish();
    assert_eq!(code, 0, "{errors}");
    println!("{results}");

    let values: Value = serde_json::from_str(&fs::read_to_string(&skills).unwrap()).unwrap();
    let turn = &values["open-by-rotate"][0]["values"];
    let radius = turn["radius"].as_f64().unwrap() - RADIUS;
    let angle = turn["angle"].as_f64().unwrap().abs().to_degrees() - ANGLE;
    let centre = distance(vector(&turn["centre"]), HINGE);
    let way = vector(&values["open-by-slide"][0]["values"]["displacement"]);
    let slide = distance(way, [0.0, -WAY, 0.0]);
    println!("centre {centre:.4} m, radius {radius:+.4} m, angle {angle:+.2} degrees, displacement {slide:.4} m");
    assert!(centre < 0.03 && radius.abs() < 0.03 && angle.abs() < 5.0 && slide < 0.025);
    let run = bench.run(&domain, "run.jsonl", "", &["--skills", &skills]);
    assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
}
