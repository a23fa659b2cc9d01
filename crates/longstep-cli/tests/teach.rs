//! The program teaches a plan from recordings, and runs it with what was taught.
#![allow(clippy::disallowed_macros, clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::fs;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::{Output, Stdio};

use common::drawer::{ENV, GOAL, recording};
use common::longstep;
use serde_json::Value;
use tempfile::TempDir;

/// A folder with the plan for [`GOAL`]: move the hand, grasp, slide, release.
struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        let bench = Self(TempDir::new().unwrap());
        bench.write("env.json", ENV);
        let output = bench.longstep(
            &["solve", "--goal", GOAL, "--env", "env.json", "--save", "plan.json"],
            "",
        );
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Runs the program with names of files in the folder made whole.
    fn longstep(&self, words: &[&str], input: &str) -> Output {
        let whole = |word: &&str| {
            if word.contains('.') && !word.contains([':', ' ']) {
                self.path(word).display().to_string()
            } else {
                (*word).to_owned()
            }
        };
        let mut child = longstep(self.0.path())
            .args(words.iter().map(whole))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // A command that reads no input may have ended.
        let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
        child.wait_with_output().unwrap()
    }

    fn teach(&self, more: &[&str]) -> Output {
        self.longstep(&[&["teach", "plan.json", "-o", "skills.json"], more].concat(), "")
    }

    fn skills(&self) -> Value {
        serde_json::from_str(&fs::read_to_string(self.path("skills.json")).unwrap()).unwrap()
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn a_taught_plan_runs_and_an_untaught_one_says_what_is_missing() {
    let bench = Bench::new();
    bench.write("demo.csv", &recording(&[1, 2, 3, 4], 1.0, true));
    let run = [
        "run",
        "plan.json",
        "--domain",
        "household-taught",
        "--robot",
        "sim",
        "--approve",
        "never",
        "--log",
    ];
    let untaught = bench.longstep(&[&run[..], &["none.jsonl"]].concat(), "");
    assert_eq!(untaught.status.code(), Some(30));
    let error = text(&untaught.stderr);
    assert!(
        error.contains("step 1 `move_hand(<drawer_handle>)` has no `first_position` (point)"),
        "{error}"
    );
    assert!(
        error.contains("hint: nothing has moved; `longstep teach PLAN.json --demo FILE` writes the values"),
        "{error}"
    );
    assert!(!bench.path("none.jsonl").exists());

    let taught = bench.teach(&["--demo", "demo.csv"]);
    assert_eq!(
        taught.status.code(),
        Some(0),
        "{}{}",
        text(&taught.stdout),
        text(&taught.stderr)
    );
    let shown = text(&taught.stdout);
    assert!(shown.contains("Step 3: slide the drawer handle to open\n"), "{shown}");
    assert!(shown.contains("  displacement (0.000, -0.250, 0.000) ± "), "{shown}");
    let skills = bench.skills();
    assert_eq!(skills["grasp"][0]["values"]["grasp_type"], "hook");
    assert_eq!(skills["grasp"][0]["values"]["upper_arm_first"], "place_low");
    let source = skills["open-by-slide"][0]["taught"]["displacement"]["source"]
        .as_str()
        .unwrap();
    assert!(source.contains("demo.csv, 3.03 to 4.50 s, right hand"), "{source}");

    let run = bench.longstep(&[&run[..], &["run.jsonl", "--skills", "skills.json"]].concat(), "");
    assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
}

#[test]
fn recordings_can_be_cut_in_other_ways() {
    let bench = Bench::new();
    bench.write("whole.csv", &recording(&[1, 2, 3, 4], 1.0, false));
    let files = ["one.csv", "two.csv", "three.csv", "four.csv"];
    for (index, name) in files.iter().enumerate() {
        bench.write(name, &recording(&[index + 1], 1.0, false));
    }
    let times = [
        "--demo",
        "whole.csv",
        "--segments",
        "1:0-1.5,2:1.52-3.01,3:3.02-4.51,4:4.52-6.1",
    ];
    for more in [&times[..], &[&["--demo"], &files[..]].concat()] {
        let output = bench.teach(&[more, &["--json"]].concat());
        let answer: Value = serde_json::from_str(&text(&output.stdout)).unwrap();
        assert_eq!(answer["complete"], true, "{more:?}: {answer:#}");
        assert_eq!(answer["skills"], bench.skills());
        let way = answer["skills"]["open-by-slide"][0]["values"]["displacement"][1]
            .as_f64()
            .unwrap();
        assert!((way + 0.25).abs() < 0.01, "{way}");
    }
}

/// A spreadsheet writes the recording with decimal commas and with times since the epoch.
#[test]
fn a_spreadsheet_teaches_the_same_and_its_notes_are_shown() {
    let bench = Bench::new();
    let whole = recording(&[1, 2, 3, 4], 1.0, false);
    let later = |line: &str| {
        let (time, rest) = line.split_once(',').unwrap();
        let time: f64 = time.parse().unwrap();
        let commas = format!("{:.4};{}", time + 1.7e9, rest.replace(',', ";")).replace('.', ",");
        commas + "\n"
    };
    let mut lines = whole.lines();
    let mut table = format!("\u{feff}{}\n", lines.next().unwrap().replace(',', ";"));
    table.extend(lines.map(later));
    bench.write("table.csv", &table);
    let times = "1:0-1.5,2:1.52-3.01,3:3.02-4.51,4:4.52-6.1";
    let output = bench.teach(&["--demo", "table.csv", "--segments", times]);
    let shown = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{shown}");
    let way = bench.skills()["open-by-slide"][0]["values"]["displacement"][1]
        .as_f64()
        .unwrap();
    assert!((way + 0.25).abs() < 0.01, "{way}");
    assert!(shown.contains("table.csv: numbers have decimal commas"), "{shown}");
    assert!(
        shown.contains("times are seconds since the epoch; the first frame is at 0 s"),
        "{shown}"
    );
    let output = bench.teach(&["--demo", "table.csv", "--segments", times, "--json"]);
    let answer: Value = serde_json::from_str(&text(&output.stdout)).unwrap();
    assert_eq!(answer["notes"].as_array().unwrap().len(), 2, "{answer:#}");
}

#[test]
fn teach_errors_name_the_mistake_and_the_next_step() {
    let bench = Bench::new();
    let whole = recording(&[1, 2, 3, 4], 1.0, true);
    for (name, text) in [
        ("demo.csv", whole.clone()),
        ("short.csv", recording(&[1, 2, 3, 4], 0.05, true)),
        ("three.csv", recording(&[1, 2, 4], 1.0, true)),
        ("plain.csv", whole.replace(",hook,", ",,")),
        ("broken.csv", whole.replace("t,hand", "t,arm")),
        ("demo.bag", whole.clone()),
        ("empty.json", "[]".to_owned()),
        ("positions.json", r#"{"<drawer_handle>": [1, 1, 1]}"#.to_owned()),
        ("others.json", r#"{"<cup>": [1, 1, 1]}"#.to_owned()),
        ("places.json", r#"{"<drawer_handle>": [1, 1]}"#.to_owned()),
    ] {
        bench.write(name, &text);
    }
    for (more, code, expected) in [
        (
            &["--demo", "short.csv"][..],
            10,
            "missing: step 3 `open_by_slide(<drawer_handle>)`: the hand moves 1.",
        ),
        (
            &["--demo", "three.csv"],
            10,
            "missing: step 3 `open_by_slide(<drawer_handle>)`: no recording shows it; show it",
        ),
        (
            &["--demo", "plain.csv"],
            10,
            "missing: step 2 `grasp_object(<drawer_handle>)`: `grasp_type` needs a column `grasp`",
        ),
        (
            &["--demo", "demo.csv", "--hand", "left"],
            10,
            "shown with the right hand, but the demonstration is with the left one",
        ),
        (
            &["--demo", "demo.csv", "--positions", "positions.json"],
            10,
            "from where the world says",
        ),
        (
            &["--demo", "demo.csv", "three.csv"],
            10,
            "2 recordings for 4 steps; give one for each step",
        ),
        (
            &["--demo", "broken.csv"],
            30,
            "broken.csv: unknown column `arm`; rename it",
        ),
        (
            &["--demo", "demo.bag"],
            30,
            "hint: a recording is a .csv, .json, .jsonl or .mcap file",
        ),
        (&["--demo", "none.csv"], 30, "cannot read"),
        (&["--demo", "empty.json"], 30, "empty.json: no frames"),
        (
            &["--demo", "demo.csv", "--positions", "places.json"],
            30,
            "hint: write an object of positions",
        ),
        (
            &["--demo", "demo.csv", "--positions", "others.json"],
            30,
            "--positions: the world has no `<cup>`",
        ),
        (
            &["--demo", "demo.csv", "--segments", "1:2"],
            30,
            "`1:2` is no time of a step; write STEP:FROM-TO in seconds",
        ),
        (
            &["--demo", "demo.csv", "--segments", "9:0-1"],
            30,
            "the plan has 4 steps, and no step 9",
        ),
        (
            &["--demo", "demo.csv", "--domain", "household"],
            30,
            "the domain `household` declares no parameters that a person teaches",
        ),
    ] {
        let output = bench.teach(more);
        let error = text(&output.stderr);
        assert!(error.contains(expected), "{more:?}: {error}");
        assert_eq!(output.status.code(), Some(code), "{more:?}: {error}");
    }
    let mut plan: Value = serde_json::from_str(&fs::read_to_string(bench.path("plan.json")).unwrap()).unwrap();
    plan["task_cohesion"]["task_sequence"].as_array_mut().unwrap().remove(1);
    plan["task_cohesion"]
        .as_object_mut()
        .unwrap()
        .remove("step_instructions");
    bench.write("invalid.json", &plan.to_string());
    let output = bench.longstep(&["teach", "invalid.json", "--demo", "demo.csv", "-o", "other.json"], "");
    assert_eq!(output.status.code(), Some(10), "{}", text(&output.stderr));
    assert!(
        text(&output.stdout).contains("only a verified plan is taught"),
        "{}",
        text(&output.stdout)
    );
    assert!(!bench.path("other.json").exists());
}

#[test]
fn teach_asks_for_the_recording_of_each_step_in_turn() {
    let bench = Bench::new();
    for step in 1..=4 {
        bench.write(&format!("step{step}.csv"), &recording(&[step], 1.0, false));
    }
    bench.write("short.csv", &recording(&[3], 0.05, false));
    let name = |name: &str| bench.path(name).display().to_string();
    let lines = [
        name("step1.csv"),
        name("nothing.csv"),
        name("step2.csv"),
        name("short.csv"),
        "back".to_owned(),
        name("step2.csv"),
        String::new(),
        name("step3.csv"),
        name("step4.csv"),
    ];
    let input = lines.join("\n");
    let output = bench.longstep(&["teach", "plan.json", "-o", "skills.json"], &input);
    let asked = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{asked}");
    let questions: Vec<&str> = asked
        .lines()
        .filter(|line| line.starts_with("Show step ") && line.contains(": "))
        .collect();
    assert_eq!(
        questions,
        [
            "Show step 1: move the hand to the drawer handle",
            "Show step 2: grasp the drawer handle",
            "Show step 2: grasp the drawer handle",
            "Show step 3: slide the drawer handle to open",
            "Show step 3: slide the drawer handle to open",
            "Show step 2: grasp the drawer handle",
            "Show step 3: slide the drawer handle to open",
            "Show step 4: release the drawer handle",
        ]
    );
    assert!(
        asked.contains("the hand moves 1.2 cm; show at least 3 cm\nShow step 3 again."),
        "{asked}"
    );
    assert_eq!(bench.skills().as_object().unwrap().len(), 4);

    // The end of the input ends the lesson; what was shown is kept.
    let output = bench.longstep(
        &["teach", "plan.json", "-o", "skills.json"],
        &format!("{}\nskip\nquit\n", name("step1.csv")),
    );
    assert_eq!(output.status.code(), Some(10));
    assert_eq!(bench.skills().as_object().unwrap().len(), 1);
    assert!(
        text(&output.stdout).contains("values are missing"),
        "{}",
        text(&output.stdout)
    );
}
