//! `longstep plan` against a server that speaks OpenAI's dialect: a small one in this process, which answers what was
//! recorded.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::path::Path;
use std::process::{Command, Output};

use common::{Answer, Server};
use serde_json::{Value, json};

const KEY: &str = "sk-a-very-secret-key";

/// A model that says this.
fn says(text: &str) -> Answer {
    Answer::Says(text.to_owned())
}

fn plan(server: &Server, instruction: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_longstep"))
        .args([
            "plan",
            instruction,
            "--env",
            "examples/environments/pantry.json",
            "--json",
        ])
        .args(["--model", &server.reference()])
        .env("LONGSTEP_API_KEY", KEY)
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))
        .output()
        .unwrap()
}

fn without_key(output: &Output) -> (String, String) {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    let (stdout, stderr) = (text(&output.stdout), text(&output.stderr));
    assert!(!stdout.contains(KEY) && !stderr.contains(KEY));
    (stdout, stderr)
}

#[test]
fn a_server_s_goals_become_a_plan() {
    let server = Server::giving(vec![says(
        r#"{"goal": "put(cereal, counter)", "left_out": [], "question": ""}"#,
    )]);
    let output = plan(&server, "Put the cereal on the counter");
    let (stdout, stderr) = without_key(&output);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    let answer: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(answer["goal"], json!(["put(<cereal>, <counter>)"]));
    assert_eq!(answer["usage"]["prompt_tokens"], 900);
    let body = &server.bodies()[0];
    assert_eq!(body["model"], "recorded");
    assert_eq!(body["response_format"]["type"], "json_schema");
    let last = body["messages"].as_array().unwrap().last().unwrap()["content"]
        .as_str()
        .unwrap();
    assert!(last.ends_with("Instruction: Put the cereal on the counter"), "{last}");
}

#[test]
fn a_server_s_question_is_passed_on() {
    let server = Server::giving(vec![says(
        r#"{"goal": "", "left_out": [], "question": "Which thing?"}"#,
    )]);
    let output = plan(&server, "do the thing");
    let (stdout, _) = without_key(&output);
    assert_eq!(output.status.code(), Some(13));
    let answer: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(answer["plan"]["question"], "Which thing?");
}

#[test]
fn plan_reports_a_server_whose_replies_are_unreadable() {
    let content = "Sure! I will put the cereal on the counter.";
    let server = Server::giving(vec![says(content), says(content)]);
    let output = plan(&server, "Put the cereal on the counter");
    let (stdout, stderr) = without_key(&output);
    assert_eq!(server.bodies().len(), 2);
    let error: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(
        (output.status.code(), error["error"]["code"].as_i64()),
        (Some(40), Some(40)),
        "{stderr}"
    );
    let warning = "warning: the server ignored the schema: its answer has another form\n";
    let told = stderr.strip_prefix(warning).unwrap_or_default();
    assert!(told.starts_with("error: ") && told.contains("hint: "), "{stderr}");
}

/// A goal that it repeats after it was told that there is no such thing is a question.
#[test]
fn plan_asks_a_question_if_an_invalid_goal_is_repeated() {
    for (goal, expected) in [
        ("put(unicorn, counter)", "`unicorn`"),
        ("fly(cereal)", "`fly(cereal)` is not a goal"),
    ] {
        let content = json!({"goal": goal, "left_out": [], "question": ""}).to_string();
        let server = Server::giving(vec![says(&content), says(&content)]);
        let output = plan(&server, "Put the cereal on the counter");
        let (stdout, stderr) = without_key(&output);
        assert_eq!(server.bodies().len(), 2);
        let answer: Value = serde_json::from_str(&stdout).unwrap();
        assert_eq!(output.status.code(), Some(13), "{stderr}");
        let question = answer["plan"]["question"].as_str().unwrap();
        assert!(question.contains(expected), "{question}");
    }
}

#[test]
fn plan_returns_the_error_of_an_invalid_goal_to_the_model() {
    let right = r#"{"goal": "put(cereal, counter)", "left_out": [], "question": ""}"#;
    let wrong = r#"{"goal": "put(unicorn, counter)", "left_out": [], "question": ""}"#;
    let server = Server::giving(vec![says(wrong), says(right)]);
    let output = plan(&server, "Put the cereal on the counter");
    let (stdout, stderr) = without_key(&output);
    assert!(
        output.status.success() && stdout.contains("put(<cereal>, <counter>)"),
        "{stderr}"
    );
    let asked = server.bodies()[1]["messages"].as_array().unwrap().clone();
    let [.., own, complaint] = &asked[..] else {
        panic!("{asked:?}")
    };
    assert_eq!(
        (own["role"].as_str(), own["content"].as_str()),
        (Some("assistant"), Some(wrong))
    );
    assert!(
        complaint["content"].as_str().unwrap().contains("`unicorn`"),
        "{complaint}"
    );
}

#[test]
fn wrong_key_error_does_not_reveal_the_key() {
    let error =
        json!({"error": {"message": format!("Incorrect API key provided: {KEY}"), "type": "invalid_request_error"}});
    let server = Server::giving(vec![Answer::Status(401, error)]);
    let output = plan(&server, "Put the cereal on the counter");
    let (_, stderr) = without_key(&output);
    assert_eq!(output.status.code(), Some(40), "{stderr}");
    assert!(
        stderr.contains("401") && stderr.contains("LONGSTEP_API_KEY"),
        "{stderr}"
    );
}
