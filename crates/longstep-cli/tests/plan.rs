//! `longstep plan` in both strategies, with a small server in place of a model.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use common::{Answer, PANTRY, Page, Ran, Server, goals, longstep, run, seen};
use serde_json::{Value, json};

macro_rules! snapshot {
    ($name:expr, $text:expr) => {
        insta::with_settings!({filters => vec![
            (r"\d+\.\d+ m?s\b", "[time]"),
            (r"/tmp/\.tmp[^/ ,)`]*", "[home]"),
            (r"http://127.0.0.1:\d+", "[server]"),
        ]}, {
            insta::assert_snapshot!($name, $text);
        });
    };
}

const INSTRUCTION: &str = "Put the cereal on the counter";

const MOVE: [&str; 6] = [
    "move_hand()",
    "grasp_object()",
    "detach_from_plane()",
    "move_object()",
    "attach_to_plane()",
    "release_object()",
];

fn paper_plan(calls: &[&str]) -> Answer {
    let explanations: Vec<String> = calls.iter().map(|_| "with the cereal".to_owned()).collect();
    let plan = json!({
        "task_cohesion": {"task_sequence": calls, "step_instructions": explanations, "object_name": "<cereal>"},
        "environment_after": {"assets": ["<counter>"], "objects": ["<cereal>"],
            "object_states": {"<cereal>": "on_something(<counter>)"}},
        "instruction_summary": "", "question": "",
    });
    Answer::Says(plan.to_string())
}

fn arguments<'a>(reference: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["plan", INSTRUCTION, "--env", PANTRY, "--model", reference], more].concat()
}

fn planned(server: &Server, more: &[&str]) -> Ran {
    let home = tempfile::tempdir().unwrap();
    let reference = server.reference();
    run(longstep(home.path()).args(arguments(&reference, more)), "")
}

fn plan_seen(server: &Server, more: &[&str]) -> String {
    let home = tempfile::tempdir().unwrap();
    let reference = server.reference();
    seen(longstep(home.path()).args(arguments(&reference, more)), "")
}

#[test]
fn a_plan_of_the_model_is_repaired_or_goes_back_to_it() {
    let mut page = Page::default();
    let short = || paper_plan(&MOVE[1..]);
    let server = Server::giving(vec![short()]);
    page.add("plan_direct_repaired", plan_seen(&server, &["--strategy", "direct"]));
    assert_eq!(server.bodies().len(), 1);

    // Without repair, the second request holds the verifier's words.
    for (flag, second, code) in [
        ("--no-repair", paper_plan(&MOVE), 0),
        ("--no-repair", short(), 10),
        ("--feedback-first", paper_plan(&MOVE), 0),
        ("--feedback-first", short(), 0),
    ] {
        let server = Server::giving(vec![short(), second]);
        let ran = planned(&server, &["--strategy", "direct", flag, "--rounds", "1", "--json"]);
        assert_eq!(ran.code, code, "{flag}: {}{}", ran.stdout, ran.stderr);
        let bodies = server.bodies();
        assert_eq!(bodies.len(), 2);
        let messages = bodies[1]["messages"].as_array().unwrap();
        let told = messages.last().unwrap()["content"].as_str().unwrap();
        assert!(
            told.contains("grasp_object() needs that the hand is at <cereal>"),
            "{told}"
        );
        assert_eq!(messages.len(), bodies[0]["messages"].as_array().unwrap().len() + 2);
        let answer: Value = serde_json::from_str(&ran.stdout).unwrap();
        assert_eq!(answer["usage"]["rounds"], 1);
        assert_eq!(answer["usage"]["calls"], 2);
    }
    let server = Server::giving(vec![short(), short()]);
    page.add(
        "plan_direct_not_repaired",
        plan_seen(&server, &["--strategy", "direct", "--no-repair", "--rounds", "1"]),
    );
    assert_eq!(server.bodies().len(), 2);
    snapshot!("direct", page.text());
}

#[test]
fn a_prompt_is_explained_and_not_sent() {
    let mut page = Page::default();
    for strategy in ["goal", "direct"] {
        let server = Server::giving(vec![]);
        let ran = planned(&server, &["--strategy", strategy, "--explain-prompt"]);
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        assert_eq!(server.bodies(), Vec::<Value>::new(), "{strategy}");
        assert!(ran.stdout.contains(INSTRUCTION));
        let (table, _) = ran.stdout.split_once("\n\n").unwrap();
        page.add(strategy, table);
    }
    snapshot!("explained", page.text());
}

#[test]
fn prompt_folder_replaces_parts_of_the_prompt() {
    let mut page = Page::default();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_str().unwrap();
    std::fs::write(
        folder.path().join("role.md"),
        "You are the quartermaster of a lighthouse.",
    )
    .unwrap();
    let server = Server::giving(vec![paper_plan(&MOVE)]);
    let more = ["--strategy", "direct", "--prompt", path];
    let ran = planned(&server, &more);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let first = &server.bodies()[0]["messages"][0]["content"];
    assert_eq!(first, "You are the quartermaster of a lighthouse.");
    std::fs::rename(folder.path().join("role.md"), folder.path().join("rolle.md")).unwrap();
    page.add("prompt_misspelt", plan_seen(&server, &more));
    std::fs::rename(folder.path().join("rolle.md"), folder.path().join("role.md")).unwrap();
    std::fs::write(folder.path().join("role.md"), "You are {{ nobody }}.").unwrap();
    page.add("prompt_broken", plan_seen(&server, &more));
    page.add("prompt_missing", plan_seen(&server, &["--prompt", "no/such/folder"]));
    assert_eq!(server.bodies().len(), 1);
    snapshot!("prompts", page.text());
}

#[test]
fn plan_replays_recorded_replies_without_a_server() {
    let home = tempfile::tempdir().unwrap();
    let file = home.path().join("recorded.jsonl");
    let file = file.to_str().unwrap();
    let replay = format!("replay:{file}");
    for (strategy, answer) in [
        ("goal", goals(&["put(cereal, counter)"])),
        ("direct", paper_plan(&MOVE[1..])),
    ] {
        let _ = std::fs::remove_file(file);
        let server = Server::giving(vec![answer]);
        let reference = server.reference();
        let first = arguments(&reference, &["--strategy", strategy, "--record", file]);
        let first = run(longstep(home.path()).args(first), "");
        assert_eq!(first.code, 0, "{}", first.stderr);
        let second = run(
            longstep(home.path()).args(arguments(&replay, &["--strategy", strategy])),
            "",
        );
        let timeless = |text: &str| {
            let lines = text.lines().map(|line| line.split(" (").next().unwrap_or_default());
            lines.collect::<Vec<_>>().join("\n")
        };
        assert_eq!(timeless(&first.stdout), timeless(&second.stdout), "{}", second.stderr);
        assert_eq!((second.code, server.bodies().len()), (0, 1));
    }
}

#[test]
fn a_server_without_an_answer_costs_one_error() {
    let server = Server::giving(vec![Answer::HangUp, Answer::HangUp, Answer::HangUp]);
    let ran = planned(&server, &[]);
    assert_eq!((ran.code, ran.stdout.as_str()), (40, ""));
    assert_eq!(ran.stderr.matches("error: ").count(), 1, "{}", ran.stderr);
}
