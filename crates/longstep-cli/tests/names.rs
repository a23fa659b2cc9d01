//! Derivations of a domain from an environment, and suites that cannot be passed.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use common::{longstep, root, run};

const ENVIRONMENT: &str = r#"{"assets": ["<desk>", "<Trash_Bin>"], "objects": ["<pen>", "<buket>", "<fridge_handle>"],
    "object_states": {"<pen>": "on_something(<desk>)"}, "names": {"<pen>": "Bic"}}"#;

#[test]
fn a_domain_shows_an_environment_with_the_origin_of_each_fact() {
    let home = tempfile::tempdir().unwrap();
    let env = home.path().join("env.json");
    std::fs::write(&env, ENVIRONMENT).unwrap();
    let show = |command: &str| {
        let mut program = longstep(home.path());
        program.args(["domain", command, "household", "--env", env.to_str().unwrap()]);
        run(program.current_dir(root()), "")
    };
    let shown = show("show");
    assert_eq!(shown.code, 0, "{}", shown.stderr);
    for line in [
        "<Trash_Bin>  trash bin (asset)",
        "  things can be put into the trash bin  (derived, domain.toml:",
        "`<Trash_Bin>` matches the name `bin`)",
        "<pen>  Bic (item)",
        "  Bic is on the desk  (given)",
    ] {
        assert!(shown.stdout.contains(line), "{line}\n{}", shown.stdout);
    }
    let checked = show("check");
    assert_eq!(checked.code, 0, "{}", checked.stderr);
    for line in [
        "env.json:1:60: [near-miss] `<buket>` almost matches the name `bucket` of a derivation",
        "[idle-derivation] no entity has a name of this derivation: basket, box, crate, bag, bucket",
    ] {
        assert!(
            (checked.stdout.clone() + &checked.stderr).contains(line),
            "{line}\n{}{}",
            checked.stdout,
            checked.stderr
        );
    }
}

#[test]
fn a_suite_with_an_unreachable_goal_is_refused() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join("desk");
    std::fs::create_dir_all(folder.join("scenes")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write(
        "suite.toml",
        "name = \"desk\"\nabout = \"A pen.\"\ndomain = \"household\"\n",
    );
    write("scenes/desk.json", ENVIRONMENT);
    let case =
        |goal: &str| format!("[[case]]\nid = \"pen\"\nscene = \"desk\"\nsays = \"Bin it.\"\ngoal = \"{goal}\"\n");
    let check = |replies: &[&str]| {
        let mut program = longstep(home.path());
        program.arg("eval").arg(&folder).args(replies);
        run(program.current_dir(root()), "")
    };
    write("cases.toml", &case("put(Bic, trash bin)"));
    let reachable = check(&["--check"]);
    assert_eq!(reachable.stdout, "desk: the expected goals of 1 case can be reached\n");
    let twice = case("on_something(Bic, Bic)") + &case("on_something(Bic, Bic)").replace("\"pen\"", "\"again\"");
    write("cases.toml", &twice);
    std::fs::write(home.path().join("replies.json"), "[]").unwrap();
    let replies = home.path().join("replies.json");
    for arguments in [&["--check"][..], &["--replies", replies.to_str().unwrap()]] {
        let refused = check(arguments);
        assert_eq!(refused.code, 30, "{}", refused.stdout);
        for expected in [
            "\ncase `again`, instruction 1 (Bin it.): its goal cannot be reached",
            "error: 2 expected goals of desk cannot be reached",
        ] {
            assert!(refused.stderr.contains(expected), "{}", refused.stderr);
        }
    }
}

/// A level of one is not reached in steps of two, and no bound says so.
#[test]
fn eval_check_reports_where_the_search_gave_up() {
    let home = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(home.path().join(name), text).unwrap();
    write(
        "tanks.pddl",
        "(define (domain tanks) (:requirements :typing :numeric-fluents) (:types tank)
            (:predicates (there ?t - tank) (full ?t - tank)) (:functions (level ?t - tank))
            (:action pump :parameters (?t - tank) :precondition (there ?t) :effect (increase (level ?t) 2))
            (:action drain :parameters (?t - tank) :precondition (there ?t) :effect (decrease (level ?t) 2))
            (:action cap :parameters (?t - tank) :precondition (and (there ?t) (= (level ?t) 1)) :effect (full ?t)))",
    );
    write(
        "problem.pddl",
        "(define (problem two) (:domain tanks) (:objects even odd - tank)
            (:init (there even) (= (level even) 0) (there odd) (= (level odd) 1)) (:goal (full odd)))",
    );
    std::fs::create_dir_all(home.path().join("suite/scenes")).unwrap();
    let mut new = longstep(home.path());
    new.args([
        "domain",
        "new",
        "suite/tanks",
        "--pddl",
        "tanks.pddl",
        "--problem",
        "problem.pddl",
    ]);
    let created = run(new.current_dir(home.path()), "");
    assert_eq!(created.code, 0, "{}", created.stderr);
    write(
        "suite/suite.toml",
        "name = \"tanks\"\nabout = \"Tanks.\"\ndomain = \"tanks\"\n",
    );
    let scene = home.path().join("suite/scenes/tanks.json");
    std::fs::copy(home.path().join("suite/tanks/environment.json"), scene).unwrap();
    let case = |tank: &str| {
        format!("[[case]]\nid = \"{tank}\"\nscene = \"tanks\"\nsays = \"Cap it.\"\ngoal = \"full({tank})\"\n")
    };
    write("suite/cases.toml", &(case("even") + &case("odd")));
    let mut check = longstep(home.path());
    let checked = run(check.args(["eval", "suite", "--check"]).current_dir(home.path()), "");
    assert_eq!(checked.code, 12, "{}", checked.stderr);
    assert_eq!(
        checked.stdout,
        "tanks: no expected goal of 2 cases is known to be out of reach; the search gave up for 1 instruction\n"
    );
    assert!(
        checked
            .stderr
            .contains("warning: case `even`, instruction 1 (Cap it.): its goal was not reached")
    );
}
