//! Drives the built program with a real model: `LONGSTEP_TEST_MODEL` is a `.gguf` file. The small model of the
//! catalogue is good enough for these.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::path::Path;
use std::process::Command;
use std::sync::Mutex;

use serde_json::Value;

/// One model at a time: two would fight for the cores.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

fn plan(instruction: &str, environment: &str, domain: &str) -> (i32, Value) {
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let model = std::env::var("LONGSTEP_TEST_MODEL").expect("LONGSTEP_TEST_MODEL names a .gguf file");
    let output = Command::new(env!("CARGO_BIN_EXE_longstep"))
        .args([
            "plan",
            instruction,
            "--env",
            environment,
            "--domain",
            domain,
            "--model",
            &model,
        ])
        .args(["--threads", "1", "--json"])
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    let answer = serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {stderr}"));
    (output.status.code().unwrap(), answer)
}

const PANTRY: &str = "examples/environments/pantry.json";

#[test]
#[ignore = "needs LONGSTEP_TEST_MODEL"]
fn an_instruction_becomes_a_verified_plan() {
    let (code, answer) = plan("Put the juice on top of the shelf", PANTRY, "household");
    assert_eq!((code, &answer["status"]), (0, &Value::from("verified")), "{answer}");
    let after = &answer["plan"]["environment_after"]["object_states"];
    assert_eq!(after["<juice>"], "on_something(<shelf_top>)");
    assert!(answer["usage"]["completion_tokens"].as_u64().unwrap() > 0);
}

/// From words to a changed world: the simulated robot performs the plan.
#[test]
#[ignore = "needs LONGSTEP_TEST_MODEL"]
fn an_instruction_moves_a_robot() {
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let model = std::env::var("LONGSTEP_TEST_MODEL").expect("LONGSTEP_TEST_MODEL names a .gguf file");
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_longstep"))
        .args([
            "run",
            "Put the juice on top of the shelf",
            "--env",
            PANTRY,
            "--model",
            &model,
        ])
        .args([
            "--threads",
            "1",
            "--robot",
            "sim",
            "--approve",
            "never",
            "--json",
            "--log",
        ])
        .arg(folder.path().join("run.jsonl"))
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    let stdout = String::from_utf8(output.stdout).unwrap();
    let last: Value = serde_json::from_str(stdout.lines().last().unwrap()).unwrap();
    assert_eq!(last["event"], "done", "{stderr}");
    assert_eq!(
        last["environment"]["object_states"]["<juice>"],
        "on_something(<shelf_top>)"
    );
}

#[test]
#[ignore = "needs LONGSTEP_TEST_MODEL"]
fn plan_reaches_a_goal_in_the_virtualhome_domain() {
    let (code, answer) = plan("Switch the lamp on", "examples/environments/flat.json", "virtualhome");
    assert_eq!(
        (code, &answer["goal"]),
        (0, &serde_json::json!(["on(<tablelamp_4>)"])),
        "{answer}"
    );
}

#[test]
#[ignore = "needs LONGSTEP_TEST_MODEL"]
fn plan_asks_a_question_about_an_unclear_instruction() {
    for instruction in ["do the thing", "fetch the banana"] {
        let (code, answer) = plan(instruction, PANTRY, "household");
        assert_eq!((code, &answer["status"]), (13, &Value::from("question")), "{answer}");
        assert!(answer["plan"]["question"].as_str().unwrap().len() > 8, "{answer}");
        assert_eq!(answer["steps"], serde_json::json!([]));
    }
}
