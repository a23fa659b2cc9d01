//! Replays of conversations with servers (`tests/cassettes/*.json`). Every request must equal the recorded one,
//! including its body and key. The responses follow each server's documentation; only those of `llama_cpp_python*.json`
//! were recorded from a running server.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use longstep::dialogue::{ChatRequest, Constraint, Finish, Message, Role, Task};
use serde::Deserialize;
use serde_json::{Value, json};

use super::ServerModel;
use crate::test_server::{TestServer, announced, answer};
use crate::{ChatModel, OpenOptions, Progress, Sampling};

/// A file of `tests/cassettes`. `{server}` stands for the address of the test server.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Cassette {
    /// Purpose of the test.
    #[expect(dead_code, reason = "for whoever reads the file")]
    about: String,
    /// The reference of the model.
    model: String,
    environment: BTreeMap<String, String>,
    #[serde(default)]
    seed: Option<u64>,
    exchanges: Vec<Exchange>,
    outcome: Outcome,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Exchange {
    /// Method and path.
    request: String,
    /// Required headers, including the one with the key; `null` for a header that must be absent.
    #[serde(default)]
    headers: BTreeMap<String, Option<String>>,
    body: Value,
    status: String,
    #[serde(default)]
    answer_headers: Vec<String>,
    /// The lines of the answer, joined with line feeds.
    answer: Vec<String>,
    /// True if the connection ends before the answer does.
    #[serde(default)]
    cut: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Outcome {
    #[serde(default)]
    text: String,
    /// `Stop`, `Length`, `Refused`, or a part of the error.
    finish: String,
    /// Tokens of the prompt, cached tokens, and tokens of the answer.
    #[serde(default)]
    usage: [u64; 3],
    /// The beginnings of the expected warnings.
    #[serde(default)]
    warnings: Vec<String>,
    #[serde(default)]
    at_least_seconds: f64,
}

fn request() -> ChatRequest {
    ChatRequest {
        task: Task::Other,
        messages: vec![
            Message::new(Role::System, "Write what the person wants as JSON."),
            Message::new(Role::User, "Put the cup on the shelf."),
            Message::new(Role::Assistant, r#"{"goals": ["put(cup, shelf)"]}"#),
            Message::new(Role::User, "Close the \"blue\" door."),
        ],
        fixed: 3,
        answer_so_far: String::new(),
        constraint: Constraint::JsonSchema(json!({
            "type": "object",
            "properties": {"goals": {"type": "array", "items": {"type": "string"}}},
            "required": ["goals"],
            "additionalProperties": false
        })),
        max_tokens: 64,
    }
}

/// The difference between a request and the recorded one, if there is one.
fn wrong(exchange: &Exchange, request: &str) -> Option<String> {
    let (head, body) = request.split_once("\r\n\r\n")?;
    let mut lines = head.lines();
    let first = lines.next()?.trim_end_matches(" HTTP/1.1");
    if first != exchange.request {
        return Some(format!("asked {first}, recorded {}", exchange.request));
    }
    let sent: BTreeMap<String, &str> = lines
        .filter_map(|line| line.split_once(": "))
        .map(|(name, value)| (name.to_lowercase(), value))
        .collect();
    for (name, value) in &exchange.headers {
        let found = sent.get(name).copied();
        if found != value.as_deref() {
            return Some(format!("{name}: asked with {found:?}, recorded {value:?}"));
        }
    }
    let body: Value = match body {
        "" => Value::Null,
        body => serde_json::from_str(body).ok()?,
    };
    (body != exchange.body).then(|| format!("asked {body:#}\nrecorded {:#}", exchange.body))
}

fn play(path: &Path) {
    let name = path.display();
    let text = std::fs::read_to_string(path).unwrap();
    let cassette: Cassette = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
    let complaints = Arc::new(Mutex::new(Vec::new()));
    let noted = Arc::clone(&complaints);
    let exchanges = cassette.exchanges;
    let count = exchanges.len();
    let server = TestServer::answering(count, move |number, request| {
        let exchange = &exchanges[number];
        if let Some(complaint) = wrong(exchange, request) {
            noted.lock().unwrap().push(complaint);
            return answer("500 Not Recorded", &["retry-after: 3600"], b"");
        }
        let headers: Vec<&str> = exchange.answer_headers.iter().map(String::as_str).collect();
        let body = exchange.answer.join("\n");
        let length = body.len() + usize::from(exchange.cut);
        announced(&exchange.status, &headers, length, body.as_bytes())
    });
    let here = |text: &String| text.replace("{server}", &server.url);
    let variable = |name: &str| cassette.environment.get(name).map(here);
    let options = OpenOptions {
        sampling: Sampling {
            seed: cassette.seed,
            ..Sampling::default()
        },
        ..OpenOptions::new("unused".into())
    };
    let reference = here(&cassette.model).parse().unwrap();
    let mut model = ServerModel::open_with(&reference, &options, &variable)
        .unwrap()
        .unwrap();
    let mut warnings = Vec::new();
    let began = Instant::now();
    let outcome = model.chat(&request(), &mut |progress: Progress| {
        if let Progress::Warning(warning) = progress {
            warnings.push(warning);
        }
    });
    let seconds = began.elapsed().as_secs_f64();
    assert_eq!(*complaints.lock().unwrap(), [""; 0], "{name}");
    let expected = cassette.outcome;
    match outcome {
        Ok(reply) => {
            let finish = match reply.finish {
                Finish::Stop => "Stop",
                Finish::Length => "Length",
                Finish::Refused => "Refused",
            };
            let usage = [
                reply.usage.prompt_tokens,
                reply.usage.cached_tokens,
                reply.usage.completion_tokens,
            ];
            let (text, ending) = (expected.text.as_str(), expected.finish.as_str());
            assert_eq!(
                (reply.text.as_str(), finish, usage),
                (text, ending, expected.usage),
                "{name}"
            );
        }
        Err(error) => assert!(error.to_string().contains(&expected.finish), "{name}: {error}"),
    }
    assert_eq!(warnings.len(), expected.warnings.len(), "{name}: {warnings:?}");
    for (warning, expected) in warnings.iter().zip(&expected.warnings) {
        assert!(warning.contains(expected.as_str()), "{name}: {warning}");
    }
    assert!(seconds >= expected.at_least_seconds, "{name}: {seconds}");
    assert_eq!(server.requests().len(), count, "{name}");
    let shown = format!("{warnings:?} {model:?}");
    assert!(cassette.environment.iter().all(|(name, value)| {
        !(name.ends_with("_KEY") || name.ends_with("_TOKEN")) || !shown.contains(value.as_str())
    }));
}

#[test]
fn every_server_is_asked_as_recorded() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cassettes");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = files.collect();
    files.sort();
    assert!(files.len() >= 12);
    files.iter().for_each(|path| play(path));
}
