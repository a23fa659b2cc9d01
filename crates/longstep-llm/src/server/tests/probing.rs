//! Requests for the size of the context and for token counts.

use super::*;

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
    let loaded = json!({"models": [{"name": "m:latest", "context_length": 2048}]});
    for (answers, expected) in [
        (vec![missing(), json(configured)], 16384),
        // Ollama loads a model with a small context unless it is told otherwise.
        (vec![missing(), json(trained)], 8192),
        (vec![json(loaded)], 2048),
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
