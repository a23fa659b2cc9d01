//! Ollama's own API, and servers that have OpenAI's in its place.

use super::*;

const LINES: &str = r#"{"model": "m", "message": {"role": "assistant", "content": "", "thinking": "Hm."}, "done": false}
{"model": "m", "message": {"role": "assistant", "content": "{\"goal\""}, "done": false}
{"model": "m", "message": {"role": "assistant", "content": ": []}"}, "done": false}
{"model": "m", "message": {"role": "assistant", "content": ""}, "done": true, "done_reason": "stop", "prompt_eval_count": 40, "eval_count": 7}
"#;

fn lines() -> Vec<u8> {
    answer("200 OK", &["content-type: application/x-ndjson"], LINES.as_bytes())
}

fn json_answer(value: &Value) -> Vec<u8> {
    answer(
        "200 OK",
        &["content-type: application/json"],
        value.to_string().as_bytes(),
    )
}

fn paths(server: &TestServer) -> Vec<String> {
    let requests = server.requests();
    let path = |request: &String| request.split(' ').nth(1).unwrap_or_default().to_owned();
    requests.iter().map(path).collect()
}

#[test]
fn ollama_request_asks_for_the_context_size() {
    let loaded = json!({"models": [{"name": "m:latest", "context_length": 4096}]});
    let trained = json!({"model_info": {"qwen2.context_length": 32768}});
    for (before, given, expected) in [
        (vec![], Some(20_000), json!(20_000)),
        (vec![json_answer(&loaded)], None, json!(4096)),
        (
            vec![answer("404 Not Found", &[], b""), json_answer(&trained)],
            None,
            json!(8192),
        ),
        (vec![answer("404 Not Found", &[], b""); 2], None, Value::Null),
    ] {
        let asked = before.len();
        let server = TestServer::new(before.into_iter().chain([lines()]).collect());
        let options = OpenOptions {
            context_tokens: given,
            ..options()
        };
        let reply = model_with(&server, Kind::Ollama, &options)
            .chat(&request(), &mut quiet)
            .unwrap();
        assert_eq!((reply.text.as_str(), reply.finish), ("{\"goal\": []}", Finish::Stop));
        assert_eq!((reply.usage.prompt_tokens, reply.usage.completion_tokens), (40, 7));
        assert_eq!(paths(&server)[asked], "/api/chat");
        let sent = body(&server.requests()[asked]);
        assert_eq!(sent["options"]["num_ctx"], expected);
        assert_eq!(
            (&sent["options"]["num_predict"], &sent["format"]),
            (&json!(50), &json!({"type": "object"}))
        );
    }
}

#[test]
fn a_server_without_ollamas_own_api_is_asked_by_that_of_openai() {
    let options = OpenOptions {
        context_tokens: Some(4096),
        ..options()
    };
    for missing in ["404 Not Found", "405 Method Not Allowed"] {
        let server = TestServer::new(vec![
            answer(missing, &[], b"{\"error\": \"not found\"}"),
            success(),
            success(),
        ]);
        let mut model = model_with(&server, Kind::Ollama, &options);
        for _ in 0..2 {
            assert_eq!(model.chat(&request(), &mut quiet).unwrap().text, "{\"goal\": []}");
        }
        assert_eq!(
            paths(&server),
            ["/api/chat", "/v1/chat/completions", "/v1/chat/completions"]
        );
    }
}

#[test]
fn ollama_chat_rejects_a_truncated_answer() {
    let options = OpenOptions {
        context_tokens: Some(4096),
        ..options()
    };
    let begun: String = LINES.lines().take(2).map(|line| format!("{line}\n")).collect();
    for (rest, expected) in [
        ("", "it ended early"),
        ("{\"error\": \"out of memory\"}\n", "out of memory"),
    ] {
        let server = TestServer::new(vec![answer("200 OK", &[], (begun.clone() + rest).as_bytes())]);
        let error = model_with(&server, Kind::Ollama, &options)
            .chat(&request(), &mut quiet)
            .unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
}
