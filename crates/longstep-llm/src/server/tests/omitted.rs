//! Parameters that servers reject.

use super::*;

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

/// Complaints about the request, after which a smaller one has the answer.
#[test]
fn chat_retries_without_features_that_the_server_rejects() {
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
            r#"{"error": {"message": "Your organization must be verified to stream this model.", "param": "stream"}}"#,
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
            ..Sampling::default()
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
