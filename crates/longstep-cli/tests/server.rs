//! `longstep plan` against a server that speaks OpenAI's dialect: a small one in this file, which checks what it
//! is sent and answers what was recorded.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Command, Output};
use std::thread;

use serde_json::{Value, json};

const KEY: &str = "sk-a-very-secret-key";

/// Serves one answer for each of `answers`, and returns the bodies that were sent. What is asked for as a stream of
/// events is answered so.
fn serve(answers: Vec<(u16, Value)>) -> (String, thread::JoinHandle<Vec<Value>>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}/v1", listener.local_addr().unwrap());
    let server = thread::spawn(move || {
        let mut bodies = Vec::new();
        let mut answers = answers.into_iter();
        let mut next = answers.next();
        while let Some((status, answer)) = &next {
            let (mut stream, _) = listener.accept().unwrap();
            let mut reader = BufReader::new(stream.try_clone().unwrap());
            let mut length = 0;
            let mut method = String::new();
            reader.read_line(&mut method).unwrap();
            loop {
                let mut line = String::new();
                reader.read_line(&mut line).unwrap();
                if let Some(value) = line.to_lowercase().strip_prefix("content-length:") {
                    length = value.trim().parse().unwrap();
                }
                if line == "\r\n" {
                    break;
                }
            }
            // What else servers of this kind can be asked, this one does not know.
            if !method.starts_with("POST /v1/chat/completions") {
                write!(
                    stream,
                    "HTTP/1.1 404 X\r\ncontent-length: 0\r\nconnection: close\r\n\r\n"
                )
                .unwrap();
                continue;
            }
            let mut body = vec![0; length];
            reader.read_exact(&mut body).unwrap();
            let body: Value = serde_json::from_slice(&body).unwrap();
            let text = match (status, &body["stream"]) {
                (200, Value::Bool(true)) => streamed(answer),
                _ => answer.to_string(),
            };
            bodies.push(body);
            write!(
                stream,
                "HTTP/1.1 {status} X\r\ncontent-type: application/json\r\ncontent-length: {}\r\nconnection: close\r\n\r\n{text}",
                text.len()
            )
            .unwrap();
            next = answers.next();
        }
        bodies
    });
    (address, server)
}

/// An answer in three events and the mark at the end.
fn streamed(answer: &Value) -> String {
    let choice = &answer["choices"][0];
    let event = |choices: Value, usage: &Value| {
        json!({"id": answer["id"], "object": "chat.completion.chunk", "created": 0, "model": answer["model"],
               "choices": choices, "usage": usage})
    };
    let events = [
        event(
            json!([{"index": 0, "delta": choice["message"], "finish_reason": null}]),
            &Value::Null,
        ),
        event(
            json!([{"index": 0, "delta": {}, "finish_reason": choice["finish_reason"]}]),
            &Value::Null,
        ),
        event(json!([]), &answer["usage"]),
    ];
    let events: String = events.iter().map(|event| format!("data: {event}\n\n")).collect();
    events + "data: [DONE]\n\n"
}

fn says(content: &str) -> Value {
    json!({
        "id": "chatcmpl-1", "object": "chat.completion", "created": 0, "model": "recorded",
        "choices": [{"index": 0, "finish_reason": "stop", "message": {"role": "assistant", "content": content}}],
        "usage": {"prompt_tokens": 900, "completion_tokens": 12, "total_tokens": 912},
    })
}

fn plan(address: &str, instruction: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_longstep"))
        .args([
            "plan",
            instruction,
            "--env",
            "examples/environments/pantry.json",
            "--json",
        ])
        .args(["--model", &format!("{address}#recorded")])
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
    let (address, server) = serve(vec![(
        200,
        says(r#"{"question": "", "goals": ["put(cereal, counter)"]}"#),
    )]);
    let output = plan(&address, "Put the cereal on the counter");
    let (stdout, stderr) = without_key(&output);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    let answer: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(answer["goal"], json!(["put(<cereal>, <counter>)"]));
    assert_eq!(answer["usage"]["prompt_tokens"], 900);
    let body = &server.join().unwrap()[0];
    assert_eq!(body["model"], "recorded");
    assert_eq!(body["response_format"]["type"], "json_schema");
    let last = body["messages"].as_array().unwrap().last().unwrap()["content"]
        .as_str()
        .unwrap();
    assert!(last.ends_with("Instruction: Put the cereal on the counter"), "{last}");
}

#[test]
fn a_server_s_question_is_passed_on() {
    let (address, server) = serve(vec![(200, says(r#"{"question": "Which thing?", "goals": []}"#))]);
    let output = plan(&address, "do the thing");
    let (stdout, _) = without_key(&output);
    assert_eq!(output.status.code(), Some(13));
    let answer: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(answer["plan"]["question"], "Which thing?");
    server.join().unwrap();
}

#[test]
fn a_server_that_answers_nonsense_is_told_of() {
    let wrong = [
        (
            "Sure! I will put the cereal on the counter.",
            "warning: the server ignored the schema: its answer is not what was asked for\n",
        ),
        (r#"{"question": "", "goals": ["put(unicorn, counter)"]}"#, ""),
        (r#"{"question": "", "goals": ["fly(cereal)"]}"#, ""),
    ];
    for (content, warning) in wrong {
        let (address, server) = serve(vec![(200, says(content))]);
        let output = plan(&address, "Put the cereal on the counter");
        let (stdout, stderr) = without_key(&output);
        assert_eq!((output.status.code(), stdout.as_str()), (Some(40), ""), "{stderr}");
        let told = stderr.strip_prefix(warning).unwrap_or_default();
        assert!(told.starts_with("error: ") && told.contains("hint: "), "{stderr}");
        server.join().unwrap();
    }
}

#[test]
fn a_wrong_key_is_told_without_telling_it() {
    let error =
        json!({"error": {"message": format!("Incorrect API key provided: {KEY}"), "type": "invalid_request_error"}});
    let (address, server) = serve(vec![(401, error)]);
    let output = plan(&address, "Put the cereal on the counter");
    let (_, stderr) = without_key(&output);
    assert_eq!(output.status.code(), Some(40), "{stderr}");
    assert!(
        stderr.contains("401") && stderr.contains("LONGSTEP_API_KEY"),
        "{stderr}"
    );
    server.join().unwrap();
}
