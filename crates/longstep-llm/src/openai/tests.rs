use longstep::prompt::{Finish, Message, Role};
use serde_json::json;

use super::*;
use crate::test_server::{TestServer, answer};

const KEY: &str = "sk-very-secret-0123456789";

fn request() -> ChatRequest {
    ChatRequest {
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

fn ok(value: &Value) -> Vec<u8> {
    answer(
        "200 OK",
        &["content-type: application/json"],
        value.to_string().as_bytes(),
    )
}

/// An answer as OpenAI gives it, with this choice.
fn completion(choice: &Value) -> Vec<u8> {
    ok(&json!({
        "id": "chatcmpl-1", "object": "chat.completion", "created": 1_760_000_000, "model": "m",
        "choices": [choice],
        "usage": {"prompt_tokens": 40, "completion_tokens": 7, "total_tokens": 47,
                  "prompt_tokens_details": {"cached_tokens": 32, "audio_tokens": 0}},
    }))
}

fn success() -> Vec<u8> {
    completion(&json!({"index": 0, "finish_reason": "stop",
        "message": {"role": "assistant", "content": "{\"goal\": []}", "refusal": null}}))
}

fn rejected(status: &str, message: &str) -> Vec<u8> {
    let body = json!({"error": {"message": message, "type": "invalid_request_error", "code": null}});
    answer(status, &[], body.to_string().as_bytes())
}

fn model(server: &TestServer, dialect: Dialect) -> OpenAiModel {
    OpenAiModel::new(
        "m",
        &format!("{}/v1/", server.url),
        Some(Secret::new(KEY.into())),
        dialect,
    )
}

/// Asks a server with these answers; gives back the outcome, the warnings and the requests.
fn ask(answers: Vec<Vec<u8>>) -> (Result<Reply, ModelError>, Vec<String>, Vec<String>) {
    let server = TestServer::new(answers);
    let mut warnings = Vec::new();
    let outcome = model(&server, Dialect::openai()).chat(&request(), &mut |progress: Progress| {
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
        "max_completion_tokens": 50,
        "temperature": 0,
        "response_format": {"type": "json_schema",
            "json_schema": {"name": "answer", "strict": true, "schema": {"type": "object"}}},
    });
    assert_eq!(body(&requests[0]), expected);
}

#[test]
fn the_ways_to_end_are_told_apart() {
    let choice = |finish: &str, content: Value, refusal: Value| {
        completion(&json!({"index": 0, "finish_reason": finish,
            "message": {"role": "assistant", "content": content, "refusal": refusal}}))
    };
    for (answer, text, finish) in [
        (choice("length", json!("{\"go"), Value::Null), "{\"go", Finish::Length),
        (choice("length", Value::Null, Value::Null), "", Finish::Length),
        (choice("content_filter", Value::Null, Value::Null), "", Finish::Refused),
        (
            choice("stop", Value::Null, json!("I will not.")),
            "I will not.",
            Finish::Refused,
        ),
    ] {
        let reply = ask(vec![answer]).0.unwrap();
        assert_eq!((reply.text.as_str(), reply.finish), (text, finish));
    }
}

#[test]
fn a_server_that_says_little_is_understood() {
    let reply = ask(vec![ok(&json!({"choices": [{"message": {"content": "hm"}}]}))])
        .0
        .unwrap();
    assert_eq!(
        (reply.text.as_str(), reply.usage.prompt_tokens, reply.usage.calls),
        ("hm", 0, 1)
    );
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
    let model = model(&server, Dialect::openai());
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
    // A 400 about something that cannot be left out.
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
    // Three times is enough.
    let (outcome, _, requests) = ask(vec![busy.clone(), busy.clone(), busy, success()]);
    assert!(matches!(outcome, Err(ModelError::Status { status: 429, .. })));
    assert_eq!(requests.len(), 3);
    // Nobody waits for an hour.
    let (outcome, _, requests) = ask(vec![answer("429 Too Many Requests", &["retry-after: 3600"], b"{}")]);
    assert!(outcome.unwrap_err().hint().unwrap().contains("wait"));
    assert_eq!(requests.len(), 1);
    // A server in trouble, and a connection that is closed without an answer.
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
    let mut model = model(&server, Dialect::openai());
    let mut warnings = Vec::new();
    let mut note = |progress: Progress| {
        if let Progress::Warning(warning) = progress {
            warnings.push(warning);
        }
    };
    assert!(model.chat(&request(), &mut note).is_ok());
    // It is remembered.
    assert!(model.chat(&request(), &mut note).is_ok());
    assert_eq!(warnings, ["the server takes no JSON schema; asking without one"]);
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
    assert!(
        model(&server, Dialect::common())
            .chat(&request(), &mut |_: Progress| {})
            .is_ok()
    );
    let requests = server.requests();
    assert_eq!(body(&requests[0])["max_tokens"], 50);
    assert_eq!(body(&requests[1])["max_completion_tokens"], 50);

    // A server that rejects both names gets neither a third nor an endless loop.
    let (outcome, _, requests) = ask(vec![
        rejected("400 Bad Request", "max_completion_tokens is unknown"),
        rejected("400 Bad Request", "max_tokens is unknown"),
    ]);
    assert!(matches!(outcome, Err(ModelError::Status { status: 400, .. })));
    assert_eq!(requests.len(), 2);
}

#[test]
fn an_answer_that_is_no_answer_is_an_error() {
    for (body, expected) in [
        (&b"{\"choices\": ["[..], "EOF"),
        (b"<html>hello</html>", "expected value"),
        (b"{\"choices\": []}", "no choices"),
        (b"{\"object\": \"list\"}", "choices"),
        (b"{\"choices\": [{\"message\": {}}]}", "no content"),
        (b"\xff\xfe", ""),
    ] {
        let error = ask(vec![answer("200 OK", &[], body)]).0.unwrap_err();
        assert!(matches!(error, ModelError::BadAnswer { .. }), "{error:?}");
        assert!(
            error.to_string().contains(expected) && error.hint().is_some(),
            "{error}"
        );
    }
}

#[test]
fn a_server_that_is_not_there_is_an_error() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    drop(listener);
    let mut model = OpenAiModel::new("m", &format!("http://user:word@{address}/v1"), None, Dialect::common());
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
fn only_openais_own_host_is_openai() {
    assert!(is_openai("https://api.openai.com/v1"));
    for other in [
        "http://api.openai.com/v1",
        "https://api.openai.com.example.org/v1",
        "https://example.org/api.openai.com",
        "https://api.openai.com@example.org/v1",
        "nonsense",
    ] {
        assert!(!is_openai(other), "{other}");
    }
}

#[test]
fn what_a_server_cannot_do_is_said_before_it_is_asked() {
    let server = TestServer::new(vec![]);
    let mut model = model(&server, Dialect::openai());
    let mut begun = request();
    begun.answer_so_far = "{".into();
    assert!(matches!(
        model.chat(&begun, &mut |_: Progress| {}),
        Err(ModelError::Unsupported { .. })
    ));
    let mut grammar = request();
    grammar.constraint = Constraint::Lark("start: \"x\"".into());
    assert!(matches!(
        model.chat(&grammar, &mut |_: Progress| {}),
        Err(ModelError::Unsupported { .. })
    ));
}
