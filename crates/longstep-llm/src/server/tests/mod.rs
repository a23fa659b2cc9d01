//! Conversations with test servers, by subject.

mod answers;
mod failures;
mod ollama;
mod omitted;
mod probing;
mod quirks;
mod requests;
mod stopping;

use longstep::dialogue::{Finish, Message, Role, Task};
use serde_json::{Value, json};

use super::endpoint::Kind;
use super::secret::Secret;
use super::*;
use crate::test_server::{TestServer, announced, answer};

const KEY: &str = "sk-very-secret-0123456789";

fn request() -> ChatRequest {
    ChatRequest {
        task: Task::Other,
        messages: vec![
            Message::new(Role::System, "Be brief."),
            Message::new(Role::User, "Put the cup \"down\"."),
        ],
        fixed: 1,
        answer_so_far: String::new(),
        constraint: Constraint::JsonSchema(json!({"type": "object"})),
        max_tokens: 50,
    }
}

/// A response that streams these events and the end mark.
fn stream(events: &[Value]) -> Vec<u8> {
    answer("200 OK", &["content-type: text/event-stream"], sse(events).as_bytes())
}

fn sse(events: &[Value]) -> String {
    let events: String = events.iter().map(|event| format!("data: {event}\n\n")).collect();
    events + "data: [DONE]\n\n"
}

/// A stream event with this delta.
fn delta(delta: &Value, finish: Option<&str>) -> Value {
    json!({"id": "chatcmpl-1", "object": "chat.completion.chunk", "created": 1_760_000_000, "model": "m",
           "choices": [{"index": 0, "delta": delta, "finish_reason": finish}]})
}

fn says(text: &str) -> Value {
    delta(&json!({"content": text}), None)
}

fn ends(finish: &str) -> Value {
    delta(&json!({}), Some(finish))
}

fn used() -> Value {
    json!({"choices": [], "usage": {"prompt_tokens": 40, "completion_tokens": 7, "total_tokens": 47,
           "prompt_tokens_details": {"cached_tokens": 32, "audio_tokens": 0}}})
}

fn success() -> Vec<u8> {
    stream(&[
        delta(&json!({"role": "assistant", "content": "", "refusal": null}), None),
        says("{\"goal\""),
        says(": []}"),
        ends("stop"),
        used(),
    ])
}

fn rejected(status: &str, message: &str) -> Vec<u8> {
    let body = json!({"error": {"message": message, "type": "invalid_request_error", "code": null}});
    answer(status, &[], body.to_string().as_bytes())
}

fn options() -> OpenOptions {
    OpenOptions::new("unused".into())
}

fn model_with(server: &TestServer, kind: Kind, options: &OpenOptions) -> ServerModel {
    let key = Secret::bearer(KEY.into());
    let endpoint = Endpoint::new(kind, &format!("{}/v1/", server.url), "m", Some(key));
    ServerModel::new(endpoint, options).unwrap()
}

fn model(server: &TestServer, kind: Kind) -> ServerModel {
    model_with(server, kind, &options())
}

fn quiet(_: Progress) {}

/// Sends a request to a server with these responses; returns the outcome, the warnings and the requests.
fn ask(answers: Vec<Vec<u8>>) -> (Result<Reply, ModelError>, Vec<String>, Vec<String>) {
    let server = TestServer::new(answers);
    let mut warnings = Vec::new();
    let outcome = model(&server, Kind::OpenAi).chat(&request(), &mut |progress: Progress| {
        if let Progress::Warning(warning) = progress {
            warnings.push(warning);
        }
    });
    (outcome, warnings, server.requests())
}

fn body(request: &str) -> Value {
    serde_json::from_str(request.split_once("\r\n\r\n").unwrap().1).unwrap()
}
