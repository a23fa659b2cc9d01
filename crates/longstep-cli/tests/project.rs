//! The project file, the domain of a plan file, and errors as JSON.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::path::Path;
use std::process::Command;

use common::{Ran, longstep, run};
use serde_json::Value;

const GOAL: &str = "bring(parcel, desk)";

/// A home folder with a project: a robot of its own, its environment, and a folder below.
fn project(home: &Path) {
    let folder = home.join("project");
    std::fs::create_dir(&folder).unwrap();
    let made = run(
        longstep(home)
            .args(["domain", "new", "--starter"])
            .arg(folder.join("porter")),
        "",
    );
    assert_eq!(made.code, 0, "{}", made.stderr);
    std::fs::create_dir(folder.join("below")).unwrap();
    let text = "domain = \"porter\"\nenvironment = \"porter/environment.json\"\nrobot = \"sim\"\n";
    std::fs::write(folder.join("longstep.toml"), text).unwrap();
}

fn inside(home: &Path, folder: &str) -> Command {
    let mut command = longstep(home);
    command.current_dir(home.join(folder)).env_remove("LONGSTEP_DOMAIN");
    command
}

fn ok(command: &mut Command) -> Ran {
    let ran = run(command, "");
    assert_eq!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
    ran
}

#[test]
fn a_project_file_is_the_default_of_the_options() {
    let home = tempfile::tempdir().unwrap();
    project(home.path());
    for folder in ["project", "project/below"] {
        let solved = ok(inside(home.path(), folder).args(["solve", "--goal", GOAL, "--save", "plan.json"]));
        assert!(solved.stdout.contains("Verified: 4 steps"), "{}", solved.stdout);
        // It is said to a person alone.
        assert!(!solved.stderr.contains("longstep.toml"), "{}", solved.stderr);
        ok(inside(home.path(), folder).args(["verify", "plan.json"]));
        ok(inside(home.path(), folder).args(["run", "plan.json", "--approve", "never"]));
    }
    // An option and a variable come first.
    let option = run(
        inside(home.path(), "project").args(["solve", "--goal", GOAL, "--domain", "household"]),
        "",
    );
    let mut named = inside(home.path(), "project");
    let variable = run(
        named
            .env("LONGSTEP_DOMAIN", "household")
            .args(["solve", "--goal", GOAL]),
        "",
    );
    for ran in [option, variable] {
        assert_eq!(ran.code, 30, "{}", ran.stdout);
        assert!(ran.stderr.contains("`household`"), "{}", ran.stderr);
    }
    // Without a file nothing is assumed.
    let bare = run(inside(home.path(), ".").args(["solve", "--goal", GOAL]), "");
    assert_eq!(bare.code, 2, "{}", bare.stdout);
    assert!(bare.stderr.contains("no environment is given"), "{}", bare.stderr);
}

#[test]
fn a_mistake_in_a_project_file_is_an_error_where_the_file_is_needed() {
    let home = tempfile::tempdir().unwrap();
    project(home.path());
    let file = home.path().join("project/longstep.toml");
    std::fs::write(&file, "domain = \"porter\"\nenviroment = \"porter/environment.json\"\n").unwrap();
    let solved = run(inside(home.path(), "project").args(["solve", "--goal", GOAL]), "");
    assert_eq!(solved.code, 30);
    assert!(
        solved.stderr.contains("longstep.toml:2:1: unknown key `enviroment`"),
        "{}",
        solved.stderr
    );
    assert!(
        solved.stderr.contains("did you mean `environment`?"),
        "{}",
        solved.stderr
    );
    ok(inside(home.path(), "project").args(["domain", "list"]));
}

#[test]
fn saved_plan_records_its_domain_and_rejects_another() {
    let home = tempfile::tempdir().unwrap();
    project(home.path());
    let plan = home.path().join("project/plan.json");
    ok(inside(home.path(), "project").args(["solve", "--goal", GOAL, "--save", "plan.json"]));
    let saved: Value = serde_json::from_str(&std::fs::read_to_string(&plan).unwrap()).unwrap();
    assert_eq!(saved["domain"]["name"], "porter");
    for command in ["verify", "repair"] {
        let wrong = run(
            inside(home.path(), "project").args([command, "plan.json", "--domain", "household"]),
            "",
        );
        assert_eq!(wrong.code, 30);
        let expected = "error: plan.json is a plan for the domain `porter`, and not for `household`\n\
                        hint: name the folder of the domain `porter` with `--domain FOLDER`\n";
        assert_eq!(wrong.stderr, expected);
    }
    // A plan that was saved by an older program does not say so, and its actions do.
    let mut old = saved.clone();
    old.as_object_mut().unwrap().remove("domain");
    std::fs::write(&plan, old.to_string()).unwrap();
    ok(inside(home.path(), "project").args(["verify", "plan.json"]));
    let wrong = run(
        inside(home.path(), "project").args(["verify", "plan.json", "--domain", "household"]),
        "",
    );
    assert_eq!(
        wrong.stderr.lines().next().unwrap(),
        "error: plan.json is no plan for the domain `household`, which has none of its actions"
    );
    // A domain that has changed is mentioned, and the verdict is about the domain as it is.
    std::fs::write(&plan, saved.to_string()).unwrap();
    let words = home.path().join("project/porter/domain.toml");
    let changed = std::fs::read_to_string(&words).unwrap() + "\n# changed\n";
    std::fs::write(&words, changed).unwrap();
    let verified = ok(inside(home.path(), "project").args(["verify", "plan.json"]));
    let note = "the domain `porter` has changed since the plan was saved";
    assert!(verified.stdout.contains(note), "{}", verified.stdout);
}

#[test]
fn a_plan_is_valid_in_another_domain_with_the_same_actions() {
    let home = tempfile::tempdir().unwrap();
    let plan = home.path().join("plan.json");
    let goal = "put(butter, counter) & closed(fridge)";
    ok(longstep(home.path())
        .args(["solve", "--goal", goal, "--env", common::PANTRY, "--save"])
        .arg(&plan));
    ok(longstep(home.path())
        .args(["verify", "--domain", "household-taught"])
        .arg(&plan));
}

/// Returns the object of an error, which fits the published schema.
fn error_of(ran: &Ran) -> Value {
    let object: Value = serde_json::from_str(&ran.stdout).unwrap_or_else(|error| panic!("{error}: {}", ran.stdout));
    let keys: Vec<&String> = object.as_object().unwrap().keys().collect();
    assert_eq!(keys, ["error"]);
    let error = object["error"].clone();
    let schema = include_str!("../../../schemas/error.schema.json");
    let schema: Value = serde_json::from_str(schema).unwrap();
    let known = schema["properties"]["error"]["properties"].as_object().unwrap();
    assert!(
        error.as_object().unwrap().keys().all(|key| known.contains_key(key)),
        "{error}"
    );
    for key in schema["properties"]["error"]["required"].as_array().unwrap() {
        assert!(error.get(key.as_str().unwrap()).is_some(), "{error}");
    }
    for finding in error["findings"].as_array().into_iter().flatten() {
        for key in schema["$defs"]["finding"]["required"].as_array().unwrap() {
            assert!(finding.get(key.as_str().unwrap()).is_some(), "{error}");
        }
    }
    assert_eq!(error["code"], ran.code);
    error
}

#[test]
fn errors_are_json_objects_where_the_result_is_json() {
    let home = tempfile::tempdir().unwrap();
    let broken = home.path().join("broken.json");
    std::fs::write(
        &broken,
        r#"{"assets": ["<a>"], "asset_states": {"<a>": "flying()", "<b>": "x()"}}"#,
    )
    .unwrap();
    let broken = broken.to_str().unwrap();
    for (arguments, code, message) in [
        (&["verify", "nowhere.json", "--json"][..], 30, "nowhere.json"),
        (
            &["solve", "--goal", "a()", "--env", broken, "--json"],
            30,
            "broken.json",
        ),
        (&["solve", "--goal", "a()", "--env", common::PANTRY, "--json"], 30, "a"),
        (&["solve", "--json"], 2, "required arguments"),
        (&["run", "nowhere", "--robot", "sim", "--json"], 30, "nowhere"),
        (&["plan", "x", "--json"], 2, "no environment is given"),
    ] {
        let ran = run(longstep(home.path()).args(arguments), "");
        assert_eq!(ran.code, code, "{arguments:?}: {}{}", ran.stdout, ran.stderr);
        let error = error_of(&ran);
        assert!(error["message"].as_str().unwrap().contains(message), "{error}");
        assert!(ran.stderr.starts_with("error: "), "{arguments:?}: {}", ran.stderr);
    }
    let ran = run(
        longstep(home.path()).args(["solve", "--goal", "a()", "--env", broken, "--json"]),
        "",
    );
    let findings = error_of(&ran)["findings"].clone();
    assert!(findings[0]["line"] == 1 && findings[0]["file"] == broken, "{findings}");
}

#[test]
fn error_with_several_reasons_has_one_line_for_each() {
    let home = tempfile::tempdir().unwrap();
    let plan = home.path().join("plan.json");
    let goal = "put(butter, counter)";
    let taught = ["--domain", "household-taught"];
    let mut solve = longstep(home.path());
    ok(solve
        .args(["solve", "--goal", goal, "--env", common::PANTRY])
        .args(taught)
        .arg("--save")
        .arg(&plan));
    let mut command = longstep(home.path());
    let ran = run(command.arg("run").arg(&plan).args(taught).args(["--robot", "sim"]), "");
    assert_eq!(ran.code, 30, "{}", ran.stdout);
    let errors = ran.stderr.lines().filter(|line| line.starts_with("error: ")).count();
    assert!(!ran.stderr.contains("\\n"), "{}", ran.stderr);
    // Of a hundred the first twenty are printed.
    assert_eq!(errors, 20, "{}", ran.stderr);
    assert!(ran.stderr.contains("and 84 more\n"), "{}", ran.stderr);
    assert_eq!(
        ran.stderr.lines().filter(|line| line.starts_with("hint: ")).count(),
        1,
        "{}",
        ran.stderr
    );
    let mut command = longstep(home.path());
    let ran = run(
        command
            .arg("run")
            .arg(&plan)
            .args(taught)
            .args(["--robot", "sim", "--json"]),
        "",
    );
    assert_eq!(error_of(&ran)["findings"].as_array().unwrap().len(), errors + 84);
}
