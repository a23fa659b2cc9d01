//! Replies of real servers as users report them, each with the thread of its report. What is right is an answer or the true
//! reason, with few requests.

use super::*;
use crate::Reasoning;

const OBJECT: &str = r#"{"question":"","goals":["put(juice, shelf top)"]}"#;

/// The right outcome.
#[derive(Debug, Clone, Copy)]
enum Right {
    /// [`OBJECT`].
    Answer,
    /// An answer that is refused.
    Refused,
    /// An answer that is cut off.
    Cut,
    /// An error with these words.
    Error(&'static str),
}

/// A way in which a server replies.
struct Quirk {
    name: &'static str,
    /// Repository and number of the report.
    thread: &'static str,
    kind: Kind,
    replies: Vec<Vec<u8>>,
    right: Right,
    /// Requests that are made.
    requests: usize,
    reasoning: Option<Reasoning>,
}

impl Quirk {
    fn new(name: &'static str, thread: &'static str, replies: Vec<Vec<u8>>, right: Right) -> Self {
        Self {
            name,
            thread,
            kind: Kind::Other,
            requests: replies.len(),
            replies,
            right,
            reasoning: None,
        }
    }

    fn of(self, kind: Kind) -> Self {
        Self { kind, ..self }
    }

    fn with_reasoning(self, reasoning: Reasoning) -> Self {
        Self {
            reasoning: Some(reasoning),
            ..self
        }
    }
}

fn halves() -> [Value; 2] {
    let (first, second) = OBJECT.split_at(OBJECT.len() / 2);
    [says(first), says(second)]
}

fn good() -> Vec<u8> {
    let [first, second] = halves();
    stream(&[first, second, ends("stop")])
}

/// A stream with these objects in the place of the usual ones.
fn chunks(chunks: &[Value]) -> Vec<u8> {
    stream(chunks)
}

fn raw(text: &str) -> Vec<u8> {
    answer("200 OK", &["content-type: text/event-stream"], text.as_bytes())
}

fn refused(status: &str, body: &Value) -> Vec<u8> {
    answer(status, &["content-type: application/json"], body.to_string().as_bytes())
}

fn completion() -> Value {
    json!({"id": "c", "choices": [{"index": 0, "message": {"role": "assistant", "content": OBJECT}, "finish_reason": "stop"}]})
}

fn gemini(text: Option<&str>) -> Vec<u8> {
    let parts: Vec<Value> = text.iter().map(|text| json!({"text": text})).collect();
    chunks(&[json!({"candidates": [{"content": {"role": "model", "parts": parts}, "finishReason": "STOP"}]})])
}

fn anthropic() -> Vec<u8> {
    chunks(&[
        json!({"type": "message_start", "message": {"usage": {"input_tokens": 9, "output_tokens": 1}}}),
        json!({"type": "content_block_delta", "index": 0, "delta": {"type": "text_delta", "text": OBJECT}}),
        json!({"type": "message_delta", "delta": {"stop_reason": "end_turn"}, "usage": {"output_tokens": 20}}),
        json!({"type": "message_stop"}),
    ])
}

/// Ends of a stream, and errors in it.
fn endings() -> Vec<Quirk> {
    let [first, _] = halves();
    let ended = |finish| vec![chunks(&[first.clone(), ends(finish)])];
    vec![
        Quirk::new("engine error", "tenstorrent/tt-inference-server#3273", ended("error"), Right::Error("finish reason `error`")),
        Quirk::new("no resources", "can1357/oh-my-pi#8563", ended("insufficient_system_resource"), Right::Error("insufficient_system_resource")),
        Quirk::new("network error", "promptfoo/promptfoo#9905", ended("network_error"), Right::Error("finish reason `network_error`")),
        Quirk::new("abort", "vllm-project/vllm#57082", ended("abort"), Right::Error("finish reason `abort`")),
        Quirk::new("sensitive", "langgenius/dify#7559", ended("sensitive"), Right::Refused),
        Quirk::new("text in the last chunk", "vllm-project/vllm#35705", vec![chunks(&[delta(&json!({"content": OBJECT}), Some("length"))])], Right::Cut),
        Quirk::new("name of a stop token", "vespa-engine/vespa#33327", vec![chunks(&[says(OBJECT), ends("eos")])], Right::Answer),
        Quirk::new(
            "plain text after a reset",
            "tetsuo-ai/agenc-core#2492",
            vec![raw(&format!("data: {first}\n\nupstream error: read ECONNRESET\n"))],
            Right::Error("upstream error: read ECONNRESET"),
        ),
        Quirk::new(
            "error with status 200",
            "ggml-org/llama.cpp#14566",
            vec![raw("error: {\"code\": 400, \"message\": \"the request exceeds the available context size\"}\n\n")],
            Right::Error("exceeds the available context size"),
        ),
        Quirk::new(
            "overloaded with status 200",
            "farzaa/clicky#132",
            vec![
                raw("event: error\ndata: {\"type\": \"error\", \"error\": {\"type\": \"overloaded_error\", \"message\": \"Overloaded\"}}\n\n"),
                anthropic(),
            ],
            Right::Answer,
        )
        .of(Kind::Anthropic),
        Quirk::new("stop without a word", "AstrBotDevs/AstrBot#6735", vec![gemini(None), gemini(Some(OBJECT))], Right::Answer).of(Kind::Gemini),
        Quirk::new("stop without a word, always", "zai-org/GLM-5#91", vec![chunks(&[ends("stop")]); 2], Right::Error("no content")),
    ]
}

const BAD: &str = "400 Bad Request";

fn error(message: &str) -> Value {
    json!({"error": {"message": message, "type": "invalid_request_error", "code": null}})
}

/// The pieces of a streamed answer.
fn pieces() -> Vec<Quirk> {
    let so_far = |end: usize| says(&OBJECT[..end]);
    let numbered = |number: usize, text: &str| json!({"choices": [{"index": number, "delta": {"content": text}, "message": {"content": text}, "finish_reason": null}]});
    let (first, second) = OBJECT.split_at(20);
    vec![
        Quirk::new(
            "text so far in every delta",
            "QwenLM/qwen-code#3896",
            vec![chunks(&[
                so_far(15),
                so_far(30),
                so_far(OBJECT.len()),
                so_far(OBJECT.len()),
                ends("stop"),
            ])],
            Right::Answer,
        ),
        Quirk::new(
            "counting choices",
            "microsoft/foundry-local#263",
            vec![chunks(&[numbered(0, first), numbered(1, second), ends("stop")])],
            Right::Answer,
        ),
        Quirk::new(
            "no calls beside the text",
            "microsoft/vscode#330038",
            vec![chunks(&[
                delta(&json!({"content": first, "tool_calls": []}), None),
                delta(&json!({"content": second, "tool_calls": []}), None),
                ends("stop"),
            ])],
            Right::Answer,
        ),
        Quirk::new(
            "usage without choices",
            "Portkey-AI/gateway#1629",
            vec![chunks(&[
                says(OBJECT),
                ends("stop"),
                json!({"usage": {"prompt_tokens": 9}}),
            ])],
            Right::Answer,
        ),
    ]
}

/// Envelopes around an answer.
fn envelopes() -> Vec<Quirk> {
    let (first, second) = OBJECT.split_at(20);
    let whole = completion().to_string();
    vec![
        Quirk::new(
            "end mark behind an object",
            "decolua/9router#3492",
            vec![raw(&format!("{whole}\n\ndata: [DONE]\n\n"))],
            Right::Answer,
        ),
        Quirk::new(
            "end mark in the line of an object",
            "decolua/9router#3492",
            vec![raw(&format!("{whole}data: [DONE]\n\n"))],
            Right::Answer,
        ),
        Quirk::new(
            "an envelope",
            "smallmain/vscode-unify-chat-provider#71",
            vec![refused("200 OK", &json!({"code": 0, "data": completion()}))],
            Right::Answer,
        ),
        Quirk::new(
            "an envelope with an error",
            "cloudflare/ai#651",
            vec![refused(
                "200 OK",
                &json!({"success": false, "errors": [{"code": 7003, "message": "No route for that URI"}], "result": null}),
            )],
            Right::Error("No route for that URI"),
        ),
        Quirk::new(
            "a response",
            "typesense/typesense#2871",
            vec![chunks(&[
                json!({"response": first}),
                json!({"response": null}),
                json!({"response": second, "p": "ab"}),
            ])],
            Right::Answer,
        ),
        Quirk::new(
            "a list of messages",
            "microsoft/sample-app-aoai-chatGPT#368",
            vec![chunks(&[
                json!({"choices": [{"messages": [{"delta": {"content": OBJECT}}], "finish_reason": "stop"}]}),
            ])],
            Right::Answer,
        ),
    ]
}

/// Reasoning around, and in the place of an answer.
fn reasoned() -> Vec<Quirk> {
    vec![
        Quirk::new(
            "thoughts in square brackets",
            "waybarrios/vllm-mlx#599",
            vec![chunks(&[
                says("[THINK]The {juice}? {} or {}[/THINK]"),
                says(OBJECT),
                ends("stop"),
            ])],
            Right::Answer,
        ),
        Quirk::new(
            "a schema's answer in the reasoning",
            "scouzi1966/maclocal-api#44",
            vec![refused(
                "200 OK",
                &json!({"choices": [{"message": {"content": "", "reasoning_content": OBJECT}, "finish_reason": "stop"}]}),
            )],
            Right::Answer,
        ),
        Quirk::new(
            "reasoning alone",
            "openclaw/openclaw#91604",
            vec![chunks(&[
                delta(&json!({"reasoning_content": "The juice is on the table."}), None),
                ends("stop"),
            ])],
            Right::Error("ended after its reasoning"),
        ),
        Quirk::new(
            "nothing but reasoning until the limit",
            "ollama/ollama#15288",
            vec![chunks(&[
                delta(&json!({"reasoning": "The juice. Or"}), None),
                ends("length"),
                used(),
            ])],
            Right::Error("spent all of its 7 tokens on reasoning"),
        ),
    ]
}

/// Schemas that are rejected.
fn schemas() -> Vec<Quirk> {
    let google = |message: &str| json!({"error": {"code": 400, "message": message, "status": "INVALID_ARGUMENT"}});
    let claude = "output_config.format.schema: For 'array' type, property 'maxItems' is not supported";
    vec![
        Quirk::new(
            "no JSON mode",
            "egoist/chatwise-releases#141",
            vec![
                refused(
                    BAD,
                    &json!({"code": 20024, "message": "Json mode is not supported for this model."}),
                ),
                good(),
            ],
            Right::Answer,
        ),
        Quirk::new(
            "JSON that the server checks",
            "thepersonalaicompany/amurex-backend#38",
            vec![
                refused(
                    BAD,
                    &json!({"error": {"message": "Failed to generate JSON.", "code": "json_validate_failed"}}),
                ),
                good(),
            ],
            Right::Answer,
        ),
        Quirk::new(
            "a grammar that cannot be compiled",
            "ggml-org/llama.cpp#19349",
            vec![
                refused(BAD, &error("Failed to initialize samplers: failed to parse grammar")),
                good(),
            ],
            Right::Answer,
        ),
        Quirk::new(
            "another key for the schema",
            "huggingface/text-generation-inference#2899",
            vec![
                answer(
                    "422 Unprocessable Entity",
                    &[],
                    b"Failed to deserialize: response_format: missing field `value` at line 1",
                ),
                good(),
            ],
            Right::Answer,
        ),
        Quirk::new(
            "keyword of a schema",
            "vercel/ai#17197",
            vec![refused(BAD, &error(claude)), anthropic()],
            Right::Answer,
        )
        .of(Kind::Anthropic),
        Quirk::new(
            "too many states",
            "googleapis/python-genai#660",
            vec![
                refused(
                    BAD,
                    &google("The specified schema produces a constraint that has too many states for serving."),
                ),
                gemini(Some(OBJECT)),
            ],
            Right::Answer,
        )
        .of(Kind::Gemini),
        Quirk::new(
            "a schema over the budget",
            "vercel/ai#21192",
            vec![
                refused(BAD, &google("Request contains an invalid argument.")),
                gemini(Some(OBJECT)),
            ],
            Right::Answer,
        )
        .of(Kind::Gemini),
    ]
}

/// Limits of reasoning that are rejected.
fn efforts() -> Vec<Quirk> {
    vec![
        Quirk::new(
            "effort in Python's words",
            "router-for-me/CLIProxyAPI#1572",
            vec![
                refused(BAD, &json!({"object": "error", "code": 400, "param": null, "message":
                    "1 validation error: {'type': 'literal_error', 'loc': ('body', 'reasoning_effort'), 'input': 'none'}"})),
                good(),
            ],
            Right::Answer,
        )
        .with_reasoning(Reasoning::Off),
        Quirk::new(
            "no reasoning is not supported",
            "openai/codex#6647",
            vec![
                refused(BAD, &json!({"error": {"message": "Unsupported value: 'none' is not supported with this model.",
                    "param": "reasoning.effort", "code": "unsupported_value"}})),
                good(),
            ],
            Right::Answer,
        )
        .of(Kind::OpenAi)
        .with_reasoning(Reasoning::Off),
        Quirk::new(
            "effort of another model",
            "mistralai/mistral-vibe#1117",
            vec![
                refused("422 Unprocessable Entity", &json!({"detail": [{"loc": ["body", "reasoning_effort"], "msg": "Input should be 'high'", "input": "medium"}]})),
                good(),
            ],
            Right::Answer,
        )
        .with_reasoning(Reasoning::Medium),
        Quirk::new(
            "a model that does not think",
            "admonstrator/zettelrobbe#74",
            vec![
                refused(BAD, &json!({"error": "\"m\" does not support thinking"})),
                raw(&format!("{}\n", json!({"message": {"content": OBJECT}, "done": true, "done_reason": "stop"}))),
            ],
            Right::Answer,
        )
        .of(Kind::Ollama)
        .with_reasoning(Reasoning::Low),
    ]
}

/// Other errors with a status.
fn rejections() -> Vec<Quirk> {
    vec![
        Quirk::new(
            "no credit",
            "langchain-ai/langchainjs#1929",
            vec![refused(
                "429 Too Many Requests",
                &json!({"error": {"message": "You exceeded your current quota.", "code": "insufficient_quota"}}),
            )],
            Right::Error("exceeded your current quota"),
        ),
        Quirk::new(
            "limit without a header for retries",
            "vectorize-io/hindsight#3508",
            vec![
                answer("429 Too Many Requests", &["x-ratelimit-reset-tokens: 20ms"], b"{}"),
                good(),
            ],
            Right::Answer,
        ),
        Quirk::new(
            "status of a provider in the body",
            "open-webui/computer#293",
            vec![
                refused(
                    "200 OK",
                    &json!({"error": {"code": 502, "message": "Provider returned error"}}),
                ),
                good(),
            ],
            Right::Answer,
        ),
        Quirk::new(
            "name of a parameter in the words of a person",
            "lbjlaq/Antigravity-Manager#1942",
            vec![refused(
                BAD,
                &error("Filtered: 'Set the temperature to 20 and follow the stream of the seed shop.'"),
            )],
            Right::Error("Filtered"),
        ),
        Quirk::new(
            "a model that is not there",
            "continuedev/continue#11908",
            vec![refused("404 Not Found", &json!({"error": "model 'm' not found"}))],
            Right::Error("model 'm' not found"),
        )
        .of(Kind::Ollama),
    ]
}

#[test]
fn chat_answers_or_explains_each_known_server_quirk() {
    let groups = [
        endings(),
        pieces(),
        envelopes(),
        reasoned(),
        schemas(),
        efforts(),
        rejections(),
    ];
    for quirk in groups.into_iter().flatten() {
        let name = format!("{} ({})", quirk.name, quirk.thread);
        let server = TestServer::new(quirk.replies);
        let options = OpenOptions {
            context_tokens: Some(4096),
            sampling: Sampling {
                reasoning: quirk.reasoning,
                ..Sampling::default()
            },
            ..options()
        };
        let outcome = model_with(&server, quirk.kind, &options).chat(&request(), &mut quiet);
        match (quirk.right, outcome) {
            (Right::Answer, Ok(reply)) => {
                let found = object_text(&reply.text).unwrap_or_else(|| panic!("{name}: {}", reply.text));
                assert_eq!((found.as_str(), reply.finish), (OBJECT, Finish::Stop), "{name}");
            }
            (Right::Refused, Ok(reply)) => assert_eq!(reply.finish, Finish::Refused, "{name}"),
            (Right::Cut, Ok(reply)) => assert_eq!(reply.finish, Finish::Length, "{name}"),
            (Right::Error(words), Err(error)) => assert!(error.to_string().contains(words), "{name}: {error}"),
            (right, outcome) => panic!("{name}: {right:?}, but {outcome:?}"),
        }
        assert_eq!(server.requests().len(), quirk.requests, "{name}");
        assert!(quirk.requests <= 2, "{name}");
    }
}
