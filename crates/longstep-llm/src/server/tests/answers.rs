//! Answers, and where servers put them.

use super::*;

#[test]
fn chat_distinguishes_the_finish_reasons_of_replies() {
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
fn chat_rejects_responses_without_a_complete_answer() {
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
    ] {
        let answers = vec![answer("200 OK", &[], body); 2];
        let error = ask(answers).0.unwrap_err();
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
fn chat_finds_the_answer_in_each_place_servers_use() {
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

#[test]
fn chat_warns_once_about_an_ignored_schema() {
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
