//! The bodies and heads of requests.

use super::*;

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
fn chat_rejects_unsupported_options_before_sending_a_request() {
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
fn request_sends_the_model_name_unchanged() {
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
