//! `longstep eval`: suites, runs that go on, refusals.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;
use std::process::{Command, Output};

const SUITE: &str = "name = \"desk\"\nabout = \"A pen and a cup.\"\ndomain = \"household\"\n";
const CASES: &str = r#"[[case]]
id = "pen"
scene = "desk"
says = "The pen belongs on the shelf."
goal = "put(pen, shelf)"
tags = ["easy"]

[[case]]
id = "comb"
scene = "desk"
says = "Put the comb on the shelf."
expect = "question"
"#;
const DESK: &str = r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>", "<cup>"],
    "object_states": {"<pen>": "on_something(<desk>)", "<cup>": "on_something(<desk>)"}}"#;
const REPLIES: &str = r#"[{"case": "pen", "reply": {"goal": "put(pen, shelf)", "left_out": [], "question": ""}},
    {"case": "comb", "reply": {"goal": "put(cup, shelf)", "left_out": [], "question": ""}},
    {"case": "comb", "trial": 2, "reply": {"goal": "", "left_out": [], "question": "Which comb?"}},
    {"case": "pen", "trial": 2, "reply": "I would rather not."}]"#;

/// A folder with a suite and replies for it.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    std::fs::create_dir_all(folder.path().join("desk/scenes")).unwrap();
    write("desk/suite.toml", SUITE);
    write("desk/cases.toml", CASES);
    write("desk/scenes/desk.json", DESK);
    write("replies.json", REPLIES);
    folder
}

fn longstep(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_longstep"));
    command
        .current_dir(folder)
        .env_remove("LONGSTEP_CORPUS")
        .args(arguments);
    command.output().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

const RUN: [&str; 6] = ["eval", "desk", "--replies", "replies.json", "--out", "run"];

#[test]
fn eval_keeps_results_and_resumes_an_incomplete_run() {
    let folder = folder();
    let output = longstep(folder.path(), &RUN);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let results = std::fs::read(folder.path().join("run/results.jsonl")).unwrap();
    assert_eq!(results.iter().filter(|byte| **byte == b'\n').count(), 4);
    let page = std::fs::read_to_string(folder.path().join("run/report.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") || page.starts_with("<!doctype html>"));
    assert!(folder.path().join("run/report.md").exists());

    // Nothing is left to do: the replies are not looked at again.
    let again = longstep(folder.path(), &RUN);
    assert_eq!(again.status.code(), Some(0));
    assert_eq!(std::fs::read(folder.path().join("run/results.jsonl")).unwrap(), results);
    assert_eq!(stderr(&again).lines().next(), Some("Resuming after 4 of 4"));

    // Cut off in the middle of a line.
    std::fs::write(folder.path().join("run/results.jsonl"), &results[..results.len() - 30]).unwrap();
    let resumed = longstep(folder.path(), &RUN);
    assert_eq!(resumed.status.code(), Some(0));
    assert_eq!(std::fs::read(folder.path().join("run/results.jsonl")).unwrap(), results);

    // Of a run of its own, the report is written anew, and it is compared with another.
    let report = longstep(folder.path(), &["eval", "report", "run"]);
    assert_eq!(report.status.code(), Some(0));
    assert!(stdout(&report).contains("recorded replies"), "{}", stdout(&report));
    let compared = longstep(folder.path(), &["eval", "compare", "run", "run", "--html", "both.html"]);
    assert_eq!(compared.status.code(), Some(0), "{}", stderr(&compared));
    assert!(folder.path().join("both.html").exists());
}

#[test]
fn eval_json_reports_the_measures_of_a_run() {
    let folder = folder();
    let output = longstep(folder.path(), &[&RUN[..], &["--json"]].concat());
    let object: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    let summary = &object["summary"];
    // Of the pen, the first trial; of the comb, the question.
    assert_eq!(summary["correct"], serde_json::json!({"hits": 2, "of": 4}));
    assert_eq!(summary["executable"], serde_json::json!({"hits": 1, "of": 2}));
    assert_eq!(object["run"]["trials"], 2);
}

#[track_caller]
fn check_refused(folder: &Path, arguments: &[&str], expected: &str) {
    let output = longstep(folder, arguments);
    assert_eq!((output.status.code(), stderr(&output).trim()), (Some(30), expected));
    assert!(!folder.join("run").exists(), "something was written");
}

#[test]
fn eval_rejects_an_invalid_run_and_writes_nothing() {
    let folder = folder();
    let path = folder.path();
    check_refused(
        path,
        &["eval", "kitchn"],
        "error: there is no suite `kitchn`\nhint: did you mean `kitchen`?",
    );
    check_refused(
        path,
        &["eval", "paper"],
        "error: the suite `paper` needs the paper's recordings, which are not part of longstep\n\
         hint: pass their folder with `--corpus FOLDER`",
    );
    check_refused(
        path,
        &["eval", "desk", "--jobs", "2", "--out", "run"],
        "error: an embedded model answers one request at a time\nhint: omit `--jobs`, which is for servers",
    );
    check_refused(
        path,
        &[&RUN[..], &["--tag", "hard"]].concat(),
        "error: no case of the suite matches the given tags, ids and wordings\n\
         hint: `longstep eval list` lists the suites; the tags are in their .toml files",
    );
    check_refused(
        path,
        &[&RUN[..], &["--rename", "Put=PutSurface"]].concat(),
        "error: no action of the domain is called `Put`\nhint: `longstep domain show DOMAIN` lists the actions",
    );
    std::fs::write(
        path.join("desk/cases.toml"),
        CASES.replace("put(pen", "put(pin").replace("comb\"", "pen\""),
    )
    .unwrap();
    check_refused(
        path,
        &RUN,
        "error: desk/cases.toml:5:8: `put(pin, shelf)`: `pin` in `put(pin, shelf)` is nothing in the environment; did you mean `pen`?\n\
         error: desk/cases.toml:9:6: the id `pen` is taken by the case at desk/cases.toml:2\n\
         hint: give each case an id of its own",
    );
}

#[test]
fn another_run_in_the_folder_is_kept() {
    let folder = folder();
    longstep(folder.path(), &RUN);
    let before = std::fs::read(folder.path().join("run/results.jsonl")).unwrap();
    let output = longstep(folder.path(), &[&RUN[..], &["--rounds", "1"]].concat());
    assert_eq!(output.status.code(), Some(30));
    let told = stderr(&output);
    assert!(told.contains("run contains another run: settings was"), "{told}");
    assert!(told.contains("hint: use another folder"), "{told}");
    assert_eq!(std::fs::read(folder.path().join("run/results.jsonl")).unwrap(), before);
}

#[test]
fn the_shipped_suites_are_listed() {
    let folder = folder();
    let list = stdout(&longstep(folder.path(), &["eval", "list"]));
    let names: Vec<&str> = list.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(
        names,
        [
            "branching",
            "household",
            "kitchen",
            "long",
            "two-arms",
            "unsaid",
            "unsaid-arms",
            "unsaid-rooms"
        ]
    );
}

/// The paper's two tables from its recordings: seventy cells, and fourteen numbers of rounds.
#[test]
#[ignore = "needs LONGSTEP_CORPUS"]
fn the_paper_s_tables_come_out_of_its_recordings() {
    let corpus = std::env::var("LONGSTEP_CORPUS").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let output = longstep(
        folder.path(),
        &["eval", "paper", "--recorded", "--corpus", &corpus, "--out", "run"],
    );
    let told = stdout(&output);
    assert!(told.contains("70 of 70 cells agree"), "{told}");
    assert!(told.contains("14 of 14 entries agree"), "{told}");
}

/// The answers of a strong model that saw nothing but the requests (`lab/understanding/README.md`).
#[test]
fn recorded_answers_of_a_strong_model_are_right() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lab/understanding");
    for (suite, replies, right, of) in [
        ("test/care", "test-care", 34, 34),
        ("test/home", "test-home", 34, 34),
        ("test/laboratory", "test-laboratory", 34, 34),
        ("test/warehouse", "test-warehouse", 32, 34),
        ("test/workshop", "test-workshop", 34, 34),
        ("sealed/farm/suite-full", "sealed-farm-suite-full", 85, 86),
        ("sealed/hotel/suite-full", "sealed-hotel-suite-full", 85, 86),
    ] {
        let out = tempfile::tempdir().unwrap();
        let (replies, run) = (format!("recorded/{replies}.json"), out.path().join("run"));
        let arguments = [
            "eval",
            suite,
            "--replies",
            &replies,
            "--json",
            "--out",
            run.to_str().unwrap(),
        ];
        let output = longstep(&root, &arguments);
        let object: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
        let correct = &object["summary"]["correct"];
        assert_eq!(correct, &serde_json::json!({"hits": right, "of": of}), "{suite}");
    }
}
