use std::io::{Read, Write};
use std::net::TcpListener;
use std::time::{Duration, Instant};

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

#[test]
fn a_request_is_in_openais_words_and_the_answer_is_read() {
    let (outcome, warnings, requests) = ask(vec![success()]);
    let reply = outcome.unwrap();
    assert_eq!((reply.text.as_str(), reply.finish), ("{\"goal\": []}", Finish::Stop));
    let usage = reply.usage;
    assert_eq!(
        (
            usage.calls,
            usage.prompt_tokens,
            usage.cached_tokens,
            usage.completion_tokens
        ),
        (1, 40, 32, 7)
    );
    assert!(warnings.is_empty());
    let head = requests[0].to_lowercase();
    assert!(head.starts_with("post /v1/chat/completions http/1.1"));
    assert!(head.contains(&format!("authorization: bearer {KEY}")));
    assert!(head.contains("content-type: application/json"));
    let expected = json!({
        "model": "m",
        "messages": [{"role": "system", "content": "Be brief."},
                     {"role": "user", "content": "Put the cup \"down\"."}],
        "stream": true,
        "stream_options": {"include_usage": true},
        "max_completion_tokens": 50,
        "temperature": 0.0,
        "response_format": {"type": "json_schema",
            "json_schema": {"name": "answer", "strict": true, "schema": {"type": "object"}}},
    });
    assert_eq!(body(&requests[0]), expected);
}

#[test]
fn the_ways_to_end_are_told_apart() {
    let refusal = |words: &str| delta(&json!({"refusal": words}), None);
    for (events, text, finish) in [
        (vec![says("{\"go"), ends("length")], "{\"go", Finish::Length),
        (vec![ends("length")], "", Finish::Length),
        (vec![ends("content_filter")], "", Finish::Refused),
        (
            vec![refusal("I will "), refusal("not."), ends("stop")],
            "I will not.",
            Finish::Refused,
        ),
        // A server that sends only the necessary fields.
        (
            vec![json!({"choices": [{"delta": {"content": "hm"}}]})],
            "hm",
            Finish::Stop,
        ),
    ] {
        let reply = ask(vec![stream(&events)]).0.unwrap();
        assert_eq!((reply.text.as_str(), reply.finish), (text, finish));
        assert_eq!((reply.usage.calls, reply.usage.prompt_tokens), (1, 0));
    }
}

#[test]
fn a_key_is_never_shown() {
    let (outcome, _, _) = ask(vec![rejected(
        "401 Unauthorized",
        &format!("Incorrect API key\nprovided: {KEY}."),
    )]);
    let error = outcome.unwrap_err();
    let shown = format!("{error} {error:?} {:?}", error.hint());
    assert!(!shown.contains(KEY) && shown.contains("[key]"), "{shown}");
    assert!(!error.to_string().contains('\n') && error.hint().unwrap().contains("OPENAI_API_KEY"));
    let server = TestServer::new(vec![]);
    let model = model(&server, Kind::OpenAi);
    assert!(!format!("{model:?}").contains(KEY));
}

#[test]
fn errors_are_short_and_have_hints() {
    let html = answer(
        "403 Forbidden",
        &[],
        format!("<html>\n{}", "x ".repeat(5000)).as_bytes(),
    );
    let error = ask(vec![html]).0.unwrap_err();
    assert!(error.to_string().len() < 420, "{error}");
    assert!(error.hint().unwrap().contains("may not"));
    let error = ask(vec![rejected("404 Not Found", "The model `m` does not exist")])
        .0
        .unwrap_err();
    assert!(
        error.to_string().ends_with("status 404: The model `m` does not exist"),
        "{error}"
    );
    assert!(error.hint().unwrap().contains("/v1"));
    // A 400 about something that cannot be omitted.
    let error = ask(vec![rejected("400 Bad Request", "context length exceeded")])
        .0
        .unwrap_err();
    assert!(matches!(error, ModelError::Status { status: 400, .. }), "{error}");
}

#[test]
fn a_busy_server_is_asked_again_when_it_says() {
    let busy = answer("429 Too Many Requests", &["retry-after: 0.05"], b"{}");
    let (outcome, warnings, requests) = ask(vec![busy.clone(), success()]);
    assert!(outcome.is_ok());
    assert_eq!(requests.len(), 2);
    assert!(
        warnings[0].contains("429") && warnings[0].contains("again"),
        "{warnings:?}"
    );
    // Three attempts are the limit.
    let (outcome, _, requests) = ask(vec![busy.clone(), busy.clone(), busy, success()]);
    assert!(matches!(outcome, Err(ModelError::Status { status: 429, .. })));
    assert_eq!(requests.len(), 3);
    // A wait of an hour is too long.
    let (outcome, _, requests) = ask(vec![answer("429 Too Many Requests", &["retry-after: 3600"], b"{}")]);
    assert!(outcome.unwrap_err().hint().unwrap().contains("wait"));
    assert_eq!(requests.len(), 1);
    // A server error, and a connection that is closed without a response.
    let trouble = answer("502 Bad Gateway", &["retry-after: 0"], b"oops");
    assert!(ask(vec![trouble, success()]).0.is_ok());
    assert!(ask(vec![vec![], success()]).0.is_ok());
}

#[test]
fn a_schema_that_is_rejected_is_left_out() {
    let no_schema = rejected(
        "400 Bad Request",
        "Invalid parameter: 'response_format' of type 'json_schema' is not supported",
    );
    let server = TestServer::new(vec![no_schema, success(), success()]);
    let mut model = model(&server, Kind::OpenAi);
    let mut warnings = Vec::new();
    let mut note = |progress: Progress| {
        if let Progress::Warning(warning) = progress {
            warnings.push(warning);
        }
    };
    assert!(model.chat(&request(), &mut note).is_ok());
    // The change persists.
    assert!(model.chat(&request(), &mut note).is_ok());
    assert_eq!(
        warnings,
        ["the server does not support JSON schemas; continuing without one"]
    );
    let requests = server.requests();
    assert!(body(&requests[0]).get("response_format").is_some());
    assert!(body(&requests[1]).get("response_format").is_none());
    assert!(body(&requests[2]).get("response_format").is_none());
}

#[test]
fn limits_and_temperatures_are_asked_for_as_the_server_likes() {
    let (outcome, warnings, requests) = ask(vec![
        rejected(
            "400 Bad Request",
            "Unsupported value: 'temperature' does not support 0 with this model.",
        ),
        rejected(
            "422 Unprocessable Entity",
            "max_completion_tokens: extra fields not permitted",
        ),
        success(),
    ]);
    assert!(outcome.is_ok() && warnings.len() == 1);
    let last = body(&requests[2]);
    assert_eq!(
        (last.get("temperature"), last.get("max_completion_tokens")),
        (None, None)
    );
    assert_eq!(last["max_tokens"], 50);

    let server = TestServer::new(vec![
        rejected(
            "400 Bad Request",
            "'max_tokens' is not supported with this model. Use 'max_completion_tokens' instead.",
        ),
        success(),
    ]);
    assert!(model(&server, Kind::Other).chat(&request(), &mut quiet).is_ok());
    let requests = server.requests();
    assert_eq!(body(&requests[0])["max_tokens"], 50);
    assert_eq!(body(&requests[1])["max_completion_tokens"], 50);

    // If the server rejects both names, the request fails without an endless loop.
    let (outcome, _, requests) = ask(vec![
        rejected("400 Bad Request", "max_completion_tokens is unknown"),
        rejected("400 Bad Request", "max_tokens is unknown"),
    ]);
    assert!(matches!(outcome, Err(ModelError::Status { status: 400, .. })));
    assert_eq!(requests.len(), 2);
}

#[test]
fn an_answer_that_is_no_answer_is_an_error() {
    let events = sse(&[says("{\"goal\""), ends("stop")]);
    let unmarked = events.strip_suffix("data: [DONE]\n\n").unwrap();
    let early = "it ended early";
    let begun = sse(&[says("{\"goal\"")]);
    let begun = begun.strip_suffix("data: [DONE]\n\n").unwrap();
    for (body, expected) in [
        (
            &b"<html>hello</html>"[..],
            "a web page; the address of the API may end in `/v1`",
        ),
        (b"hello", "no stream of events: `hello`"),
        (b"{\"choices\": []}", "no message"),
        (b"data: {\"choices\": [\n\n", "not JSON: EOF"),
        (b"data: [DONE]\n\n", "no content"),
        (b"data: \xff\xfe\n\n", "utf-8"),
        (begun.as_bytes(), early),
        (
            b"data: {\"choices\": [{\"delta\": {\"reasoning\": \"Hm.\"}, \"finish_reason\": \"length\"}]}\n\n",
            "on reasoning",
        ),
    ] {
        let error = ask(vec![answer("200 OK", &[], body)]).0.unwrap_err();
        assert!(matches!(error, ModelError::BadAnswer { .. }), "{error:?}");
        assert!(
            error.to_string().contains(expected) && error.hint().is_some(),
            "{error}"
        );
    }
    let cut = announced("200 OK", &[], begun.len() + 1, begun.as_bytes());
    let (outcome, _, requests) = ask(vec![cut]);
    assert!(outcome.unwrap_err().to_string().contains(early));
    assert_eq!(requests.len(), 1);
    // An answer that says why it ends is whole, however the connection ends.
    for whole in [
        answer("200 OK", &[], unmarked.as_bytes()),
        announced("200 OK", &[], events.len() + 1, unmarked.as_bytes()),
    ] {
        assert_eq!(ask(vec![whole]).0.unwrap().text, "{\"goal\"");
    }
    // An error before the answer is one of the request; an answer without a byte is asked for again.
    let error = b"data: {\"error\": {\"message\": \"out of memory\"}}\n\n";
    let (outcome, _, _) = ask(vec![answer("200 OK", &[], error)]);
    let error = outcome.unwrap_err();
    assert!(matches!(error, ModelError::Status { status: 200, .. }) && error.to_string().contains("out of memory"));
    let (outcome, _, requests) = ask(vec![
        answer("200 OK", &[], b""),
        answer("200 OK", &[], events.as_bytes()),
    ]);
    assert_eq!((outcome.unwrap().text.as_str(), requests.len()), ("{\"goal\"", 2));
}

/// Replies as servers really send them, each with the answer that is meant.
#[test]
fn an_answer_is_found_where_a_server_has_put_it() {
    let object = r#"{"question":"","goals":["put(juice, shelf top)"]}"#;
    let part = |delta: Value| json!({"choices": [{"delta": delta, "finish_reason": null}]}).to_string();
    let end = || json!({"choices": [{"delta": {}, "finish_reason": "stop"}]}).to_string();
    let escaped = object.replace('"', "\\\"");
    let stream = |parts: &[String]| {
        sse(&parts
            .iter()
            .map(|own| serde_json::from_str(own).unwrap())
            .collect::<Vec<Value>>())
    };
    let called = json!({"tool_calls": [{"function": {"name": "answer", "arguments": object}}]});
    for (name, body) in [
        ("plain", stream(&[part(json!({"content": object})), end()])),
        ("thoughts", stream(&[part(json!({"content": format!("<think>So.</think>\n\n{object}")})), end()])),
        ("no thoughts", stream(&[part(json!({"content": format!("<think></think>{object}")})), end()])),
        ("reasoning", stream(&[part(json!({"reasoning_content": object})), end()])),
        ("reasoning twice", stream(&[part(json!({"reasoning": object, "reasoning_content": object})), end()])),
        ("details", stream(&[part(json!({"reasoning_details": [{"text": object}]})), end()])),
        ("call", stream(&[part(called.clone()), end()])),
        ("fence", stream(&[part(json!({"content": format!("```json\n{object}\n```")})), end()])),
        ("words", stream(&[part(json!({"content": format!("Sure! {object} Anything else?")})), end()])),
        ("object", stream(&[part(json!({"content": serde_json::from_str::<Value>(object).unwrap()})), end()])),
        ("message", stream(&[json!({"choices": [{"message": {"content": object}, "finish_reason": "stop"}]}).to_string()])),
        ("both", stream(&[json!({"choices": [{"delta": {"content": object}, "message": {"content": object}, "finish_reason": "stop"}]}).to_string()])),
        ("whole", json!({"choices": [{"message": {"content": object}, "finish_reason": "stop"}]}).to_string()),
        ("blanks before", format!("\n\n{}", json!({"choices": [{"message": {"content": object}}]}))),
        ("half a character", format!("data: {{\"choices\": [{{\"delta\": {{\"reasoning\": \"\\ud83d\"}}}}]}}\n\ndata: {{\"choices\": [{{\"delta\": {{\"content\": \"{escaped}\"}}, \"finish_reason\": \"stop\"}}]}}\n\n")),
        ("order mark", format!("\u{feff}{}", stream(&[part(json!({"content": object})), end()]))),
    ] {
        let (outcome, _, requests) = ask(vec![answer("200 OK", &[], body.as_bytes())]);
        let text = outcome.unwrap_or_else(|error| panic!("{name}: {error}")).text;
        let found = object_text(&text).unwrap_or_else(|| panic!("{name}: {text}"));
        let found: Value = serde_json::from_str(&found).unwrap();
        assert_eq!(found, serde_json::from_str::<Value>(object).unwrap(), "{name}");
        assert_eq!(requests.len(), 1, "{name}");
    }
}

/// Complaints about the request, after which a smaller one has the answer.
#[test]
fn what_a_server_does_not_support_is_left_out() {
    for (status, complaint, changed) in [
        (
            "400 Bad Request",
            r#"{"error": {"message": "Json mode is not supported for this model."}}"#,
            "response_format",
        ),
        (
            "400 Bad Request",
            r#"{"error": {"message": "The provided JSON schema contains features not supported by xgrammar."}}"#,
            "response_format",
        ),
        (
            "400 Bad Request",
            r#"{"error": {"message": "Failed to generate JSON.", "code": "json_validate_failed"}}"#,
            "response_format",
        ),
        (
            "500 Internal Server Error",
            r#"{"error": {"message": "failed to load model vocabulary required for format"}}"#,
            "response_format",
        ),
        ("200 OK", r#"{"error": "failed to parse grammar"}"#, "response_format"),
        (
            "400 Bad Request",
            r#"{"error": {"message": "Provider returned error", "metadata": {"raw": "{\"error\": {\"message\": \"response_format is not available\"}}"}}}"#,
            "response_format",
        ),
        (
            "400 Bad Request",
            r#"{"error": {"message": "\"stream=true\" with structured outputs is currently not supported"}}"#,
            "stream",
        ),
        (
            "400 Bad Request",
            r#"{"error": {"message": "Your organization must be verified to stream this model."}}"#,
            "stream",
        ),
        (
            "400 Bad Request",
            r#"[{"error": {"message": "Developer instruction is not enabled for models/gemma-3-27b-it"}}]"#,
            "messages",
        ),
        (
            "400 Bad Request",
            r#"{"error": {"message": "System role not supported"}}"#,
            "messages",
        ),
        (
            "500 Internal Server Error",
            "Conversation roles must alternate user/assistant/user/assistant/...",
            "messages",
        ),
    ] {
        let (outcome, _, requests) = ask(vec![answer(status, &[], complaint.as_bytes()), success()]);
        assert!(outcome.is_ok(), "{complaint}: {:?}", outcome.err());
        let (first, last) = (body(&requests[0]), body(requests.last().unwrap()));
        assert_ne!(first[changed], last[changed], "{complaint}");
    }
    // The server says that the context is too small, in words that name both limits.
    let (outcome, _, requests) = ask(vec![answer(
        "400 Bad Request",
        &[],
        br#"{"error": {"message": "'max_tokens' or 'max_completion_tokens' is too large: 50. This model's maximum context length is 40 tokens"}}"#,
    )]);
    assert!(outcome.unwrap_err().to_string().contains("maximum context length"));
    assert_eq!(requests.len(), 1);
}

#[test]
fn a_server_that_is_not_there_is_an_error() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    drop(listener);
    let endpoint = Endpoint::new(Kind::Other, &format!("http://user:word@{address}/v1"), "m", None);
    let mut model = ServerModel::new(endpoint, &options()).unwrap();
    let mut warnings = 0;
    let error = model
        .chat(&request(), &mut |progress: Progress| {
            warnings += usize::from(matches!(progress, Progress::Warning(_)))
        })
        .unwrap_err();
    assert!(matches!(error, ModelError::Unreachable { .. }), "{error:?}");
    assert!(
        error
            .to_string()
            .starts_with(&format!("http://{address}/v1 cannot be reached")),
        "{error}"
    );
    assert_eq!(warnings, 2);
    assert!(!error.to_string().contains("word"), "{error}");
}

#[test]
fn a_redirect_does_not_take_the_key_along() {
    let other = TestServer::new(vec![success()]);
    let redirect = answer(
        "307 Temporary Redirect",
        &[&format!("location: {}/v1/chat/completions", other.url)],
        b"",
    );
    let error = ask(vec![redirect]).0.unwrap_err();
    assert!(matches!(error, ModelError::Status { status: 307, .. }), "{error}");
    assert!(other.requests().is_empty());
}

#[test]
fn what_a_server_cannot_do_is_said_before_it_is_asked() {
    let server = TestServer::new(vec![]);
    let mut model = model(&server, Kind::OpenAi);
    let mut begun = request();
    begun.answer_so_far = "{".into();
    assert!(matches!(
        model.chat(&begun, &mut quiet),
        Err(ModelError::Unsupported { .. })
    ));
    let mut grammar = request();
    grammar.constraint = Constraint::Lark("start: \"x\"".into());
    assert!(matches!(
        model.chat(&grammar, &mut quiet),
        Err(ModelError::Unsupported { .. })
    ));
}

#[test]
fn what_is_written_is_told_as_it_comes() {
    let server = TestServer::new(vec![success()]);
    let mut reports = Vec::new();
    let reply = model(&server, Kind::OpenAi).chat(&request(), &mut |progress: Progress| reports.push(progress));
    assert!(reply.is_ok());
    assert_eq!(
        reports,
        [
            Progress::Waiting,
            Progress::Writing { tokens: 1 },
            Progress::Writing { tokens: 2 }
        ]
    );
}

/// Cancels the call after a while.
struct Impatient(Instant);

impl Watch for Impatient {
    fn tell(&mut self, _: Progress) {}

    fn stop(&self) -> bool {
        self.0.elapsed() > Duration::from_millis(150)
    }
}

/// A server that sends this and then nothing, and keeps the connection open.
fn stuck(beginning: &'static [u8]) -> TestServer {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let mut buffer = [0; 4096];
        let _ = stream.read(&mut buffer).unwrap();
        stream.write_all(beginning).unwrap();
        // Until the client hangs up.
        while stream.read(&mut buffer).is_ok_and(|read| read > 0) {}
    });
    TestServer::at(url)
}

const HALF: &[u8] = b"HTTP/1.1 200 OK\r\ncontent-type: text/event-stream\r\n\r\n\
    data: {\"choices\": [{\"delta\": {\"content\": \"{\"}}]}\n\n";

#[test]
fn a_call_that_is_not_wanted_any_more_ends() {
    let busy = answer("503 Service Unavailable", &["retry-after: 30"], b"");
    for server in [stuck(b""), stuck(HALF), TestServer::new(vec![busy])] {
        let mut watch = Impatient(Instant::now());
        let error = model(&server, Kind::OpenAi).chat(&request(), &mut watch).unwrap_err();
        assert!(matches!(error, ModelError::Stopped), "{error}");
    }
}

#[test]
fn a_server_that_falls_silent_is_not_waited_for() {
    let options = OpenOptions {
        silence: Duration::from_millis(100),
        ..options()
    };
    for server in [stuck(b""), stuck(HALF)] {
        let error = model_with(&server, Kind::OpenAi, &options).chat(&request(), &mut quiet);
        let error = error.unwrap_err();
        assert!(matches!(error, ModelError::Silent { .. }), "{error}");
        assert!(error.to_string().ends_with("sent nothing for 0.1 s"), "{error}");
    }
}

#[test]
fn an_ignored_schema_is_told_once() {
    let mut request = request();
    request.constraint = Constraint::JsonSchema(json!({"type": "object", "required": ["goals", "question"]}));
    for (text, heeded) in [
        ("{\"goals\": [], \"question\": \"\"}", true),
        ("{\"goals\": []}", false),
        ("Sure! Here you are.", false),
        ("[1]", false),
    ] {
        let answers = vec![stream(&[says(text), ends("stop")]), stream(&[says(text), ends("stop")])];
        let server = TestServer::new(answers);
        let mut model = model(&server, Kind::OpenAi);
        let mut warnings = Vec::new();
        for _ in 0..2 {
            let reply = model.chat(&request, &mut |progress: Progress| {
                if let Progress::Warning(warning) = progress {
                    warnings.push(warning);
                }
            });
            assert_eq!(reply.unwrap().text, text);
        }
        assert_eq!(warnings.len(), usize::from(!heeded), "{text}");
        assert!(heeded || warnings[0].starts_with("the server ignored the schema"));
    }
}

#[test]
fn sampling_is_asked_for_and_left_out_where_it_is_rejected() {
    let server = TestServer::new(vec![
        rejected("400 Bad Request", "Unknown parameter: 'seed'."),
        rejected("400 Bad Request", "top_p is not supported"),
        success(),
    ]);
    let options = OpenOptions {
        sampling: Sampling {
            temperature: 0.5,
            top_p: Some(0.9),
            seed: Some(7),
        },
        ..options()
    };
    let mut warnings = 0;
    let reply = model_with(&server, Kind::Other, &options).chat(&request(), &mut |progress: Progress| {
        warnings += usize::from(matches!(progress, Progress::Warning(_)));
    });
    assert!(reply.is_ok() && warnings == 2);
    let requests = server.requests();
    let sent = |index: usize| {
        let body: Value = body(&requests[index]);
        ["temperature", "top_p", "seed"].map(|name| body.get(name).cloned())
    };
    assert_eq!(sent(0), [Some(json!(0.5)), Some(json!(0.9)), Some(json!(7))]);
    assert_eq!(sent(1), [Some(json!(0.5)), Some(json!(0.9)), None]);
    assert_eq!(sent(2), [Some(json!(0.5)), None, None]);
}

#[test]
fn a_name_is_sent_as_it_is() {
    for name in ["o3-mini-high", "vendor::model", "a/b#c"] {
        let server = TestServer::new(vec![success()]);
        let endpoint = Endpoint::new(Kind::Other, &format!("{}/v1", server.url), name, None);
        ServerModel::new(endpoint, &options())
            .unwrap()
            .chat(&request(), &mut quiet)
            .unwrap();
        let sent = body(&server.requests()[0]);
        assert_eq!(sent["model"], name);
        assert_eq!(sent.get("reasoning_effort"), None);
    }
}

#[test]
fn servers_are_asked_for_tokens_and_context() {
    let json = |value: Value| {
        answer(
            "200 OK",
            &["content-type: application/json"],
            value.to_string().as_bytes(),
        )
    };
    let missing = || answer("404 Not Found", &[], b"");
    let message = Message::new(Role::User, "one two three");
    // llama.cpp
    let server = TestServer::new(vec![
        json(json!({"tokens": [1, 2]})),
        json(json!({"tokens": [1, 2, 3]})),
        json(json!({"default_generation_settings": {"n_ctx": 4096}})),
    ]);
    let mut llama = model(&server, Kind::Other);
    assert_eq!((llama.message_tokens(&message), llama.message_tokens(&message)), (8, 8));
    let Counting::Estimate(how) = llama.counting() else {
        panic!("the template is not known")
    };
    assert!(how.starts_with("the tokenizer of m on its server"), "{how}");
    assert_eq!(
        (llama.context_tokens(), llama.context_tokens()),
        (Some(4096), Some(4096))
    );
    // vLLM
    let server = TestServer::new(vec![
        missing(),
        json(json!({"data": [{"id": "other", "max_model_len": 1}, {"id": "m", "max_model_len": 2048}]})),
    ]);
    assert_eq!(model(&server, Kind::Other).context_tokens(), Some(2048));
    // Ollama
    let configured =
        json!({"parameters": "stop \"x\"\nnum_ctx    16384", "model_info": {"qwen2.context_length": 32768}});
    let trained = json!({"model_info": {"qwen2.context_length": 32768}});
    let loaded = json!({"models": [{"name": "m:latest", "context_length": 8192}]});
    for (answers, expected) in [
        (vec![missing(), json(configured)], 16384),
        // Ollama loads a model with a small context unless it is told otherwise.
        (vec![missing(), json(trained)], 4096),
        (vec![json(loaded)], 8192),
    ] {
        let server = TestServer::new(answers);
        assert_eq!(model(&server, Kind::Ollama).context_tokens(), Some(expected));
    }
    // What the person says counts before what a server says.
    let server = TestServer::new(vec![json(json!({"default_generation_settings": {"n_ctx": 4096}}))]);
    let given = OpenOptions {
        context_tokens: Some(1234),
        ..options()
    };
    assert_eq!(model_with(&server, Kind::Other, &given).context_tokens(), Some(1234));
    // A server without any of these endpoints.
    let server = TestServer::new(vec![missing(), missing(), missing(), missing()]);
    let given = OpenOptions {
        context_tokens: Some(1234),
        ..options()
    };
    let mut other = model_with(&server, Kind::Other, &given);
    assert_eq!(other.message_tokens(&message), 8);
    assert!(matches!(other.counting(), Counting::Estimate(_)));
    assert_eq!(other.context_tokens(), Some(1234));
    assert!(server.requests().iter().all(|request| request.contains(KEY)));
}
