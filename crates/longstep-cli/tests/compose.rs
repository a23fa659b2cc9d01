//! `longstep compose`, with a script and with a small server in place of a model.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::path::Path;

use common::{Answer, Ran, Server, longstep, root, run};
use serde_json::{Value, json};

const STORED: &str = "examples/stored";
const LARDER: &str = "examples/environments/larder.json";
const WHERE: [&str; 6] = ["--plans", STORED, "--env", LARDER, "--domain", "household-checks"];

fn compose(home: &Path, more: &[&str]) -> Ran {
    run(longstep(home).arg("compose").args(more).args(WHERE), "")
}

/// Runs a script, and tells the exit code, the status and what is wrong.
#[track_caller]
fn check(script: &str, expected: (i32, &str, &str)) {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("composition.py");
    std::fs::write(&path, script).unwrap();
    let ran = compose(
        home.path(),
        &["--script", path.to_str().unwrap(), "--no-repair", "--json"],
    );
    let answer: Value = serde_json::from_str(&ran.stdout).unwrap_or_default();
    let wrong = match answer["violations"][0]["message"].as_str() {
        Some(message) => message,
        None => ran.stderr.lines().next().unwrap_or_default(),
    };
    let status = answer["status"].as_str().unwrap_or_default();
    assert_eq!(
        (ran.code, status, &wrong[..wrong.len().min(expected.2.len())]),
        expected,
        "{}",
        ran.stderr
    );
}

#[test]
fn compose_verifies_a_script_or_gives_the_reason() {
    let cream = std::fs::read_to_string(root().join(STORED).join("cream.py")).unwrap();
    check(&cream, (0, "verified", ""));
    check("take_cream()\nshelve_cream()", (0, "verified", ""));
    check("shelve_cream()", (10, "invalid", "step 1: move_object() needs that"));
    check(
        "take_cram()",
        (
            10,
            "invalid",
            "there is no stored plan `take_cram`; did you mean `take_cream`?",
        ),
    );
    check("question: Which cream?", (13, "question", ""));
    check("import robot", (30, "", "error: "));
}

#[test]
fn a_model_s_composition_is_verified_saved_and_can_be_checked_again() {
    let tree = json!([
        {"call": "take_cream()"}, {"call": "check_best_by_date(cream)"},
        {"if": {"call": "expired(cream)"}, "then": [{"call": "drop_cream()"}], "else": [{"call": "shelve_cream()"}]},
    ]);
    let reply = json!({"task_tree": tree, "question": ""}).to_string();
    let server = Server::giving(vec![Answer::Says(reply)]);
    let home = tempfile::tempdir().unwrap();
    let saved = home.path().join("saved.json");
    let wish = "Look at the cream: if it is past its date, bin it, else shelve it";
    let ran = compose(
        home.path(),
        &[wish, "--model", &server.reference(), "--save", saved.to_str().unwrap()],
    );
    assert_eq!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
    assert!(ran.stdout.starts_with("Composition\n"), "{}", ran.stdout);
    let asked = &server.bodies()[0];
    let schema = asked["response_format"]["json_schema"]["schema"].to_string();
    assert!(
        schema.contains("drop_cream()") && schema.contains("expired(cream)"),
        "{asked}"
    );
    let mut verify = longstep(home.path());
    verify.arg("verify").arg(&saved).args(["--domain", "household-checks"]);
    let again = run(&mut verify, "");
    assert_eq!(again.code, 0, "{}{}", again.stdout, again.stderr);
}

#[test]
fn names_that_mean_two_things_and_folders_without_plans_are_refused() {
    let home = tempfile::tempdir().unwrap();
    let script = root().join(STORED).join("cream.py");
    let script = script.to_str().unwrap();
    let plan = std::fs::read_to_string(root().join(STORED).join("take_cream.json")).unwrap();
    for (name, told) in [
        ("take cream.json", "error: two stored plans are called `take_cream`"),
        (
            "move_hand.json",
            "error: a stored plan is called `move_hand`, and so is an action of the domain",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(name), &plan).unwrap();
        let more = ["--plans", folder.path().to_str().unwrap(), "--script", script];
        let ran = compose(home.path(), &more);
        assert_eq!((ran.code, ran.stderr.lines().next()), (30, Some(told)));
    }
    let empty = tempfile::tempdir().unwrap();
    let mut command = longstep(home.path());
    command
        .args(["compose", "--script", script, "--env", LARDER, "--plans"])
        .arg(empty.path());
    let ran = run(&mut command, "");
    assert!(
        ran.code == 30 && ran.stderr.contains("there are no stored plans to combine"),
        "{}",
        ran.stderr
    );
}
