//! `longstep eval --queue`: one run on several machines.
//!
//! `export "$(scripts/postgres.sh --parent $$)"; cargo test -p longstep-cli --test eval_queue -- --ignored`

#![allow(clippy::unwrap_used, clippy::panic, unreachable_pub)]

mod common;
#[path = "../../longstep-server/tests/support/database.rs"]
mod database;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use common::{Server, goals, question};
use database::Database;
use serde_json::Value;

const SUITE: &str = "name = \"desk\"\nabout = \"Pens.\"\ndomain = \"household\"\n";
const DESK: &str = r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>", "<cup>"],
    "object_states": {"<pen>": "on_something(<desk>)", "<cup>": "on_something(<desk>)"}}"#;

/// The number of cases; the instruction of each names its own.
const CASES: usize = 40;

/// The most that a test waits.
const LONGEST: Duration = Duration::from_secs(120);

/// A folder with a suite of instructions, of which one in three is understood in a wrong way.
fn suite() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    std::fs::create_dir_all(folder.path().join("desk/scenes")).unwrap();
    write("desk/suite.toml", SUITE);
    let case = |number| {
        format!(
            "[[case]]\nid = \"c{number}\"\nscene = \"desk\"\nsays = \"Shelve the pen, number {number}.\"\n\
             goal = \"put(pen, shelf)\"\n"
        )
    };
    write("desk/cases.toml", &(0..CASES).map(case).collect::<String>());
    write("desk/scenes/desk.json", DESK);
    folder
}

/// A model whose answer depends on the instruction alone, and comes after a while.
fn model(pause: Duration) -> Server {
    Server::answering(move |_, request| {
        std::thread::sleep(pause);
        let number = number(&request.to_string());
        if number.is_multiple_of(3) {
            question("Which pen?")
        } else {
            goals(&["put(pen, shelf)"])
        }
    })
}

/// Returns the number of the last case that a request names.
fn number(request: &str) -> usize {
    let (_, rest) = request.rsplit_once("Shelve the pen, number ").unwrap();
    let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
    digits.parse().unwrap()
}

/// Returns how often each case was asked for.
fn asked(server: &Server) -> Vec<usize> {
    let mut asked = vec![0; CASES];
    for body in server.bodies() {
        asked[number(&body.to_string())] += 1;
    }
    asked
}

fn eval(folder: &Path, out: &str, server: &Server, queue: Option<&Database>) -> Command {
    let mut command = common::longstep(folder);
    command
        .current_dir(folder)
        .args(["eval", "desk", "--out", out, "--model", &server.reference()]);
    if let Some(database) = queue {
        command.args(["--queue", &database.address, "--jobs", "2"]);
    }
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    command
}

fn check(child: Child) {
    let output = child.wait_with_output().unwrap();
    let shown = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{shown}");
}

fn results(folder: &Path, out: &str) -> Vec<u8> {
    std::fs::read(folder.join(out).join("results.jsonl")).unwrap()
}

fn eventually(mut is_so: impl FnMut() -> bool) {
    let began = Instant::now();
    while !is_so() {
        assert!(began.elapsed() < LONGEST);
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn two_machines_have_the_bytes_of_one() {
    let (folder, database) = (suite(), Database::new());
    let folder = folder.path();
    let alone = model(Duration::ZERO);
    check(eval(folder, "alone", &alone, None).spawn().unwrap());
    assert_eq!(asked(&alone), vec![1; CASES]);

    // Each has a model of its own.
    let models = [model(Duration::from_millis(30)), model(Duration::from_millis(60))];
    let programs: Vec<Child> = models
        .iter()
        .enumerate()
        .map(|(number, model)| {
            eval(folder, &format!("out{number}"), model, Some(&database))
                .spawn()
                .unwrap()
        })
        .collect();
    programs.into_iter().for_each(check);
    let counts = models.each_ref().map(asked);
    for (one, other) in counts[0].iter().zip(&counts[1]) {
        assert_eq!(one + other, 1);
    }
    for count in &counts {
        assert!(count.iter().sum::<usize>() > CASES / 10, "{counts:?}");
    }
    // Whoever comes later asks no model.
    let late = model(Duration::ZERO);
    check(eval(folder, "late", &late, Some(&database)).spawn().unwrap());
    assert_eq!(asked(&late), vec![0; CASES]);
    for out in ["out0", "out1", "late"] {
        assert_eq!(results(folder, out), results(folder, "alone"), "{out}");
        let summary = common::longstep(folder)
            .current_dir(folder)
            .args(["eval", "report", out])
            .output()
            .unwrap();
        assert!(summary.status.success());
    }
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn units_of_a_killed_program_are_run_by_another_one() {
    let (folder, database) = (suite(), Database::new());
    let folder = folder.path();
    let alone = model(Duration::ZERO);
    check(eval(folder, "alone", &alone, None).spawn().unwrap());

    let (first, second) = (model(Duration::from_millis(100)), model(Duration::from_millis(20)));
    let mut killed = eval(folder, "killed", &first, Some(&database)).spawn().unwrap();
    eventually(|| first.bodies().len() >= 6);
    killed.kill().unwrap();
    killed.wait().unwrap();
    check(eval(folder, "second", &second, Some(&database)).spawn().unwrap());
    let (before, after) = (asked(&first), asked(&second));
    // What it ended was kept; what it was at was run again.
    let again = (0..CASES).filter(|case| before[*case] + after[*case] > 1).count();
    assert!((1..=2).contains(&again), "{before:?} {after:?}");
    assert!(before.iter().zip(&after).all(|(one, other)| one + other > 0));
    // The killed one goes on where its folder ends, and asks nothing.
    check(eval(folder, "killed", &first, Some(&database)).spawn().unwrap());
    assert_eq!(asked(&first), before);
    for out in ["killed", "second"] {
        assert_eq!(results(folder, out), results(folder, "alone"), "{out}");
    }
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn a_folder_that_was_begun_alone_hands_over_what_it_has() {
    let (folder, database) = (suite(), Database::new());
    let folder = folder.path();
    let alone = model(Duration::ZERO);
    check(eval(folder, "alone", &alone, None).spawn().unwrap());
    let whole = results(folder, "alone");

    // A program without a queue was interrupted; a wrong result is in the folder of another one.
    let cut = whole
        .iter()
        .enumerate()
        .filter(|(_, byte)| **byte == b'\n')
        .nth(9)
        .unwrap()
        .0
        + 1;
    let path = |out: &str| -> PathBuf { folder.join(out) };
    for out in ["begun", "other"] {
        std::fs::create_dir(path(out)).unwrap();
        for file in ["run.json", "timings.jsonl"] {
            std::fs::copy(path("alone").join(file), path(out).join(file)).unwrap();
        }
    }
    std::fs::write(path("begun/results.jsonl"), &whole[..cut]).unwrap();
    let first: Value = serde_json::from_slice(whole.split(|byte| *byte == b'\n').next().unwrap()).unwrap();
    let changed = first.to_string().replacen("Which pen?", "Which one?", 1);
    assert_ne!(changed, first.to_string());
    std::fs::write(path("other/results.jsonl"), changed + "\n").unwrap();

    check(eval(folder, "begun", &alone, Some(&database)).spawn().unwrap());
    assert_eq!(asked(&alone)[..10], [1; 10]);
    let late = model(Duration::ZERO);
    check(eval(folder, "late", &late, Some(&database)).spawn().unwrap());
    assert_eq!(asked(&late), vec![0; CASES]);
    assert_eq!(
        (results(folder, "begun"), results(folder, "late")),
        (whole.clone(), whole)
    );

    let refused = eval(folder, "other", &alone, Some(&database)).output().unwrap();
    let shown = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(
        shown.contains("`c0` (wording `plain`, trial 1) has another result in the queue"),
        "{shown}"
    );
    assert!(shown.contains("--out FOLDER"), "{shown}");
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn a_database_that_is_away_for_a_while_is_waited_for() {
    let (folder, database) = (suite(), Database::new());
    let folder = folder.path();
    let alone = model(Duration::ZERO);
    check(eval(folder, "alone", &alone, None).spawn().unwrap());
    let slow = model(Duration::from_millis(50));
    let program = eval(folder, "out", &slow, Some(&database)).spawn().unwrap();
    eventually(|| slow.bodies().len() >= 4);
    database.shut();
    std::thread::sleep(Duration::from_secs(2));
    database.open();
    check(program);
    assert_eq!(results(folder, "out"), results(folder, "alone"));
}

#[test]
fn a_queue_that_is_none_is_an_error_without_its_password() {
    let folder = suite();
    let server = model(Duration::ZERO);
    let mut command = eval(folder.path(), "out", &server, None);
    command.args(["--queue", "postgres://me:hunter2@127.0.0.1:1/x"]);
    let refused = command.output().unwrap();
    let shown = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(40), "{shown}");
    assert!(
        shown.contains("hint: name a PostgreSQL database") && !shown.contains("hunter2"),
        "{shown}"
    );
}
