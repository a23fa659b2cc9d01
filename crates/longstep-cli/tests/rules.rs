//! Order and prohibitions on the command line, in rule files and in a conversation.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use common::{PANTRY, Ran, Server, goals, longstep, run};
use serde_json::Value;

fn solve(goal: &str, rules: Option<&str>) -> (i32, Value, String) {
    let home = tempfile::tempdir().unwrap();
    let mut command = longstep(home.path());
    command.args(["solve", "--env", PANTRY, "--json", "--goal", goal]);
    if let Some(rules) = rules {
        let file = home.path().join("robot.rules");
        std::fs::write(&file, rules).unwrap();
        command.arg("--rules").arg(file);
    }
    let Ran { code, stdout, stderr } = run(&mut command, "");
    (code, serde_json::from_str(&stdout).unwrap_or_default(), stderr)
}

#[test]
fn solve_achieves_and_lists_goals_in_order() {
    let goal = "put(cereal, counter) then put(juice, counter) & never put(butter, floor)";
    let (code, answer, stderr) = solve(goal, None);
    assert_eq!(code, 0, "{stderr}");
    let goals = [
        "put(<cereal>, <counter>)",
        "then put(<juice>, <counter>)",
        "never put(<butter>, <floor>)",
    ];
    assert_eq!(answer["goal"], serde_json::json!(goals));
    let steps = answer["steps"].as_array().unwrap();
    let first = |thing: &str| {
        let of = |step: &Value| step["implicit"].to_string().contains(thing);
        steps.iter().position(of).unwrap()
    };
    assert!(first("<cereal>") < first("<juice>"), "{steps:?}");
}

#[test]
fn rules_of_a_file_bind_every_plan() {
    let goal = "put(butter, counter)";
    for (rules, code) in [
        ("# nothing yet\n\n", 0),
        ("untouched(juice)  # it is not ours\n", 0),
        ("never opened(fridge)\n", 11),
        ("untouched(juice)\nuntouched(butter)\n", 11),
        ("always closed(fridge)\n", 11),
    ] {
        let (found, answer, stderr) = solve(goal, Some(rules));
        assert_eq!(found, code, "{rules}: {stderr} {answer}");
    }
}

#[test]
fn a_plan_that_breaks_a_rule_is_refused_with_its_words() {
    let home = tempfile::tempdir().unwrap();
    let (plan, rules) = (home.path().join("plan.json"), home.path().join("robot.rules"));
    let mut save = longstep(home.path());
    save.args(["solve", "--env", PANTRY, "--goal", "put(butter, counter)", "--save"])
        .arg(&plan);
    assert_eq!(run(&mut save, "").code, 0);
    std::fs::write(&rules, "untouched(butter)\n").unwrap();
    let mut verify = longstep(home.path());
    verify.args(["verify", "--json", "--rules"]).arg(&rules).arg(&plan);
    let ran = run(&mut verify, "");
    assert_eq!(ran.code, 10, "{}", ran.stderr);
    let answer: Value = serde_json::from_str(&ran.stdout).unwrap();
    let violation = &answer["violations"][0];
    assert_eq!(violation["kind"], "prohibited");
    assert!(
        violation["message"].as_str().unwrap().contains("`untouched(<butter>)`"),
        "{violation}"
    );
    let mut repair = longstep(home.path());
    repair.args(["repair", "--json", "--rules"]).arg(&rules).arg(&plan);
    let ran = run(&mut repair, "");
    assert_eq!(ran.code, 11, "{}{}", ran.stdout, ran.stderr);
}

#[test]
fn rules_file_errors_name_the_line_of_an_invalid_rule() {
    for (rules, expected) in [
        ("untouched(juice)\nnever opened(freezer)\n", "robot.rules:2: `freezer`"),
        (
            "put(juice, counter)\n",
            "robot.rules:1: `put(juice, counter)` is a goal and no rule",
        ),
        (
            "never touch the juice\n",
            "robot.rules:1: `touch the juice` is not a goal",
        ),
    ] {
        let (code, _, stderr) = solve("put(cereal, counter)", Some(rules));
        assert_eq!(code, 30, "{stderr}");
        assert!(stderr.contains(expected) && stderr.contains("hint:"), "{stderr}");
    }
}

#[test]
fn a_conversation_keeps_its_rules() {
    let home = tempfile::tempdir().unwrap();
    let session = home.path().join("session");
    let server = Server::giving(vec![goals(&["put(juice, counter)"]), goals(&["put(juice, counter)"])]);
    let reference = server.reference();
    let mut chat = longstep(home.path());
    chat.args(["chat", "--env", PANTRY, "--model", &reference, "--session"])
        .arg(&session);
    let lines =
        "/rules untouched(juice)\n/rules never opened(fridge)\n/rules\n/rules lift 2\nPut the juice on the counter\n";
    let ran = run(&mut chat, lines);
    for expected in ["1. untouched(<juice>)", "2. never opened(<fridge>)"] {
        assert!(ran.stdout.contains(expected), "{}{}", ran.stdout, ran.stderr);
    }
    assert!(ran.stderr.contains("Lifted: never opened(<fridge>)"), "{}", ran.stderr);
    assert!(!ran.stdout.contains("Verified"), "{}", ran.stdout);
    let mut resume = longstep(home.path());
    resume.args(["chat", "--model", &reference, "--resume"]).arg(&session);
    let ran = run(&mut resume, "/rules\n/rules lift 1\nPut the juice on the counter\n");
    assert!(
        ran.stdout.contains("1. untouched(<juice>)"),
        "{}{}",
        ran.stdout,
        ran.stderr
    );
    assert!(ran.stdout.contains("Verified"), "{}{}", ran.stdout, ran.stderr);
}

#[test]
fn a_byte_order_mark_is_no_part_of_a_file() {
    let home = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = home.path().join(name);
        std::fs::write(&path, format!("\u{feff}{text}")).unwrap();
        path.display().to_string()
    };
    let environment = std::fs::read_to_string(common::root().join(PANTRY)).unwrap();
    let env = write("env.json", &environment);
    let rules = write("robot.rules", "untouched(juice)\n");
    let plan = home.path().join("plan.json").display().to_string();
    let solve = [
        "solve",
        "--env",
        &env,
        "--rules",
        &rules,
        "--goal",
        "put(butter, counter)",
        "--save",
        &plan,
    ];
    let ran = run(longstep(home.path()).args(solve), "");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let saved = std::fs::read_to_string(&plan).unwrap();
    let plan = write("marked.json", &saved);
    let script = write("plan.py", "pass\n");
    let boxes = std::fs::read_to_string(common::root().join("examples/see/shelf.boxes.json")).unwrap();
    let boxes = write("boxes.json", &boxes);
    let pddl = "(define (domain lamps) (:predicates (lit ?lamp)) (:action light :parameters (?lamp) :precondition (not (lit ?lamp)) \
                :effect (lit ?lamp)))";
    let pddl = write("lamps.pddl", pddl);
    let folder = home.path().join("lamps").display().to_string();
    for (arguments, code) in [
        (vec!["verify", &plan, "--rules", &rules], 0),
        (vec!["verify", &script, "--env", &env], 0),
        (vec!["see", &boxes, "--json"], 0),
        (vec!["domain", "new", &folder, "--pddl", &pddl], 0),
    ] {
        let ran = run(longstep(home.path()).args(&arguments), "");
        assert_eq!(ran.code, code, "{arguments:?}: {}{}", ran.stdout, ran.stderr);
    }
    // An editor saves the files of a domain with the mark, too.
    for file in ["domain.pddl", "domain.toml", "prompt/examples.toml", "environment.json"] {
        let text = std::fs::read_to_string(home.path().join("lamps").join(file)).unwrap();
        write(&format!("lamps/{file}"), text.trim_start_matches('\u{feff}'));
    }
    let env = home.path().join("lamps/environment.json").display().to_string();
    let ran = run(
        longstep(home.path()).args(["domain", "check", &folder, "--env", &env]),
        "",
    );
    assert_eq!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
}

#[test]
fn many_rules_that_prevent_a_plan_are_counted_and_stated_once() {
    let each = ["juice", "cloth", "butter", "cereal"];
    let rules: String = (0..600)
        .map(|index| format!("never put({}, any thing)\n", each[index % 4]))
        .collect();
    let (code, answer, stderr) = solve("put(juice, shelf top) & put(butter, shelf top)", Some(&rules));
    assert_eq!(code, 11, "{stderr}");
    let notes = answer["notes"].to_string();
    assert!(notes.len() < 1_000 && notes.contains(" more"), "{notes}");
}
