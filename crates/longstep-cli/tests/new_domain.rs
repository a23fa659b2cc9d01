//! `longstep domain new` and `longstep domain try`: from answers, from PDDL, and with a model that is a small server.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::path::Path;

use common::{Ran, Server, goals, longstep, question, run};
use serde_json::Value;

const LAMPS: &str = "(define (domain lamps) (:requirements :strips :negative-preconditions)
  (:predicates (lamp ?x) (lit ?x) (powered))
  (:action switch-on :parameters (?x) :precondition (and (lamp ?x) (powered) (not (lit ?x))) :effect (lit ?x))
  (:action switch-off :parameters (?x) :precondition (and (lamp ?x) (lit ?x)) :effect (not (lit ?x))))";

const EVENING: &str = "(define (problem evening) (:domain lamps) (:objects hall porch)
  (:init (lamp hall) (lamp porch) (powered) (lit hall)) (:goal (lit porch)))";

fn domain(home: &Path, arguments: &[&str], input: &str) -> Ran {
    run(longstep(home).current_dir(home).arg("domain").args(arguments), input)
}

/// A home with the PDDL files.
fn home() -> tempfile::TempDir {
    let home = tempfile::tempdir().unwrap();
    std::fs::write(home.path().join("lamps.pddl"), LAMPS).unwrap();
    std::fs::write(home.path().join("evening.pddl"), EVENING).unwrap();
    home
}

#[test]
fn pddl_of_any_origin_becomes_a_domain_that_passes() {
    let home = home();
    let new = ["new", "mine", "--pddl", "lamps.pddl", "--problem", "evening.pddl"];
    let ran = domain(home.path(), &new, "");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let ran = domain(home.path(), &["check", "mine", "--env", "mine/environment.json"], "");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    assert!(ran.stdout.contains("actions: 2, goals: 2"), "{}", ran.stdout);
    assert_eq!(
        std::fs::read_to_string(home.path().join("mine/domain.pddl")).unwrap(),
        LAMPS
    );
}

#[test]
fn findings_and_their_hints_stand_on_lines_of_their_own() {
    let home = home();
    let counter = "(define (domain c) (:functions (n)) (:action add :parameters () :effect (increase (n) 1)))";
    std::fs::write(home.path().join("counter.pddl"), counter).unwrap();
    let ran = domain(home.path(), &["new", "mine", "--pddl", "counter.pddl"], "");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let mut lines = ran.stdout.lines();
    assert!(
        lines.next().unwrap().starts_with("note: counter.pddl: no goal"),
        "{}",
        ran.stdout
    );
    assert!(
        lines.next().unwrap().starts_with("hint: give a problem"),
        "{}",
        ran.stdout
    );
    assert!(!ran.stdout.contains("\\n"), "{}", ran.stdout);
}

#[test]
fn nothing_is_written_for_what_is_not_supported() {
    let home = home();
    let text = LAMPS.replacen("(:action switch-on", "(:process heat) (:action switch-on", 1);
    std::fs::write(home.path().join("process.pddl"), text).unwrap();
    std::fs::write(home.path().join("answers.toml"), "name = \"x\"\nkinds = []").unwrap();
    for (arguments, place) in [
        (&["new", "mine", "--pddl", "process.pddl"][..], "process.pddl:3:"),
        (&["new", "mine", "--from", "answers.toml"], "answers.toml:2:1"),
        (&["new", "mine", "--pddl", "absent.pddl"], "absent.pddl"),
    ] {
        let ran = domain(home.path(), arguments, "");
        assert_eq!(ran.code, 30, "{}", ran.stderr);
        assert!(ran.stderr.contains(place), "{}", ran.stderr);
        assert!(!home.path().join("mine").exists());
    }
}

#[test]
fn domain_new_with_questions_keeps_the_answers() {
    let home = home();
    let input = "porter\nbox\nshelf\npick up a box\nthe box is on a shelf; the porter holds no box\n\
                 the porter holds the box\n\nput a box on a shelf\nthe porter holds the box\nthe box is on the shelf\n\n\n";
    let ran = domain(home.path(), &["new", "mine", "--ask"], input);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let answers = std::fs::read_to_string(home.path().join("mine/answers.toml")).unwrap();
    assert!(answers.contains("no_longer = [\"the box is on a shelf\"]"), "{answers}");
    let ran = domain(home.path(), &["new", "again", "--from", "mine/answers.toml"], "");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let text = |folder: &str, file: &str| std::fs::read_to_string(home.path().join(folder).join(file)).unwrap();
    for file in ["domain.pddl", "domain.toml", "environment.json", "prompt/examples.toml"] {
        assert_eq!(text("mine", file), text("again", file), "{file}");
    }
}

/// Answers of a person who makes mistakes: a robot without its article, a state in other words, a plural, a step back.
const MISTAKES: &str = "porter\nbox, crate\nshelf\ndrive to a shelf\n\nporter is at the shelf\n\npick up boxes\n\
                        pick up a box\nthe porter is at the shelf; the box is on the shelf; the porter holds no box\n\
                        the porter holds the box\n\nput a box on a shelf\nthe porter is at the shelf\nback\n\
                        the porter is at the shelf; the porter is holding the box\nyes\nthe box is on the shelf\n\n\nyes\n\
                        red box, blue box\nleft shelf, right shelf\n\nyes\n";

#[test]
fn mistakes_in_the_answers_are_mended_before_anything_is_written() {
    let home = home();
    let ran = domain(home.path(), &["new", "mine", "--ask"], MISTAKES);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    for said in [
        "\"boxes\" is more than one box",
        "Is \"the porter is holding the box\" the same as \"the porter holds the box\"?",
        "No action is about: crate.",
        "at the start: the porter is at the left shelf; the red box is on the left shelf; the blue box is on the right shelf",
    ] {
        assert!(ran.stderr.contains(said), "{said}\n{}", ran.stderr);
    }
    let check = ["check", "mine", "--env", "mine/environment.json", "--strict"];
    let ran = domain(home.path(), &check, "");
    assert_eq!(
        (ran.code, ran.stdout.contains("no warnings")),
        (0, true),
        "{}",
        ran.stdout
    );
    let solve = [
        "solve",
        "--goal",
        "on(red box, right shelf)",
        "--domain",
        "mine",
        "--env",
        "mine/environment.json",
    ];
    let ran = run(longstep(home.path()).current_dir(home.path()).args(solve), "");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
}

#[test]
fn a_mistake_at_the_end_of_the_input_is_an_error() {
    let home = home();
    let ran = domain(home.path(), &["new", "mine", "--ask"], "porter\nbox\nshelf\nsing\n");
    assert_eq!(ran.code, 30, "{}", ran.stderr);
    assert!(ran.stderr.contains("the input ends after a mistake"), "{}", ran.stderr);
    assert!(!home.path().join("mine").exists());
}

/// In a terminal, which `script` makes: the answers are kept, private, and offered at the next start.
#[cfg(target_os = "linux")]
#[test]
fn answers_are_kept_when_a_terminal_goes_away() {
    use std::os::unix::fs::PermissionsExt;
    let home = home();
    let typed = |lines: &str| {
        let program = env!("CARGO_BIN_EXE_longstep");
        let line = format!("exec {program} domain new mine");
        let mut script = std::process::Command::new("script");
        script.args(["--quiet", "--return", "--command", &line, "/dev/null"]);
        script
            .current_dir(home.path())
            .env("LONGSTEP_SESSIONS", home.path().join("state/sessions"));
        run(&mut script, lines)
    };
    let lines: Vec<&str> = MISTAKES.lines().collect();
    let (first, second) = lines.split_at(9);
    let ran = typed(&(first.join("\n") + "\n"));
    assert!(ran.stdout.contains("the answers are kept"), "{}", ran.stdout);
    let kept = home.path().join("state/new-domain.json");
    assert_eq!(std::fs::metadata(&kept).unwrap().permissions().mode() & 0o777, 0o600);
    let ran = typed(&format!("yes\n{}\n", second.join("\n")));
    assert!(ran.stdout.contains("answers for `mine` are kept"), "{}", ran.stdout);
    assert!(ran.stdout.contains("Created the domain mine"), "{}", ran.stdout);
    assert!(!kept.exists());
}

#[test]
fn domain_try_shows_each_goal_and_whether_it_is_right() {
    let home = home();
    let new = ["new", "mine", "--pddl", "lamps.pddl", "--problem", "evening.pddl"];
    assert_eq!(domain(home.path(), &new, "").code, 0);
    let server = Server::answering(|number, _| match number {
        0 => question("Which lamp?"),
        _ => goals(&["lit(porch)"]),
    });
    let ran = domain(
        home.path(),
        &["try", "mine", "--json", "--model", &server.reference()],
        "",
    );
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let trial: Value = serde_json::from_str(&ran.stdout).unwrap();
    let tried = trial["instructions"].as_array().unwrap();
    assert_eq!(tried[0]["status"], "question");
    assert_eq!(tried[0]["right"], false);
    for one in &tried[1..] {
        let same = one["goal"] == one["understood_goal"];
        assert_eq!(one["right"], same, "{one}");
    }
    assert_eq!(trial["of"], tried.len());
}

#[test]
fn a_trial_without_a_model_shows_its_instructions() {
    let home = home();
    let new = ["new", "mine", "--pddl", "lamps.pddl", "--problem", "evening.pddl"];
    assert_eq!(domain(home.path(), &new, "").code, 0);
    let ran = domain(home.path(), &["try", "mine", "--model", "absent.gguf"], "");
    assert_eq!(ran.code, 40, "{}", ran.stderr);
    assert!(ran.stdout.contains("There is no model"), "{}", ran.stdout);
    assert!(ran.stdout.contains("meant"), "{}", ran.stdout);
    assert_eq!(
        ran.stdout,
        domain(home.path(), &["try", "mine", "--model", "absent.gguf"], "").stdout
    );
}
