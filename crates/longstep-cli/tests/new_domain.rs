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
fn nothing_is_written_for_what_is_not_supported() {
    let home = home();
    let text = LAMPS.replacen("(:action switch-on", "(:derived (p) (powered)) (:action switch-on", 1);
    std::fs::write(home.path().join("axioms.pddl"), text).unwrap();
    std::fs::write(home.path().join("answers.toml"), "name = \"x\"\nkinds = []").unwrap();
    for (arguments, place) in [
        (&["new", "mine", "--pddl", "axioms.pddl"][..], "axioms.pddl:3:"),
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
fn questions_make_a_domain_and_keep_the_answers() {
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

#[test]
fn a_trial_says_what_was_understood_and_whether_it_is_right() {
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
