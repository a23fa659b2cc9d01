//! Streamed answers in the dialects of Anthropic and Gemini, from an answer in OpenAI's.

use serde_json::{Value, json};

/// The dialect of a request for a reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dialect {
    OpenAi,
    Anthropic,
    Gemini,
}

impl Dialect {
    /// Returns the dialect of a request line; none for other requests, such as one for the size of the context.
    pub(super) fn of(line: &str) -> Option<Self> {
        let path = line.strip_prefix("POST ")?.split(' ').next()?;
        match path {
            "/v1/chat/completions" => Some(Self::OpenAi),
            "/v1/messages" => Some(Self::Anthropic),
            _ if path.starts_with("/v1beta/models/") && path.ends_with(":streamGenerateContent?alt=sse") => {
                Some(Self::Gemini)
            }
            _ => None,
        }
    }

    /// Returns the events of an answer whose message and end are those of a chat completion.
    pub(super) fn streamed(self, completion: &Value) -> String {
        let choice = &completion["choices"][0];
        let text = choice["message"]["content"].as_str().unwrap_or_default();
        let is_refused = choice["message"]["refusal"].is_string();
        let finish = choice["finish_reason"].as_str().unwrap_or_default();
        // In two parts, as a stream has them.
        let middle = (0..=text.len() / 2)
            .rev()
            .find(|at| text.is_char_boundary(*at))
            .unwrap_or(0);
        let (first, second) = text.split_at(middle);
        let named = |name: &str, event: &Value| format!("event: {name}\ndata: {event}\n\n");
        match self {
            Self::OpenAi => super::streamed(completion),
            Self::Anthropic => {
                let reason = match finish {
                    _ if is_refused => "refusal",
                    "length" => "max_tokens",
                    _ => "end_turn",
                };
                let delta = |text: &str| json!({"type": "content_block_delta", "index": 0, "delta": {"type": "text_delta", "text": text}});
                let begun = json!({"type": "message", "id": "msg_1", "role": "assistant", "model": completion["model"],
                    "content": [], "stop_reason": null, "usage": {"input_tokens": 900, "output_tokens": 1}});
                let block = json!({"type": "text", "text": ""});
                [
                    named("message_start", &json!({"type": "message_start", "message": begun})),
                    named("content_block_start", &json!({"type": "content_block_start", "index": 0, "content_block": block})),
                    named("content_block_delta", &delta(first)),
                    named("content_block_delta", &delta(second)),
                    named("content_block_stop", &json!({"type": "content_block_stop", "index": 0})),
                    named(
                        "message_delta",
                        &json!({"type": "message_delta", "delta": {"stop_reason": reason}, "usage": {"output_tokens": 12}}),
                    ),
                    named("message_stop", &json!({"type": "message_stop"})),
                ]
                .concat()
            }
            Self::Gemini => {
                let reason = match finish {
                    _ if is_refused => "SAFETY",
                    "length" => "MAX_TOKENS",
                    _ => "STOP",
                };
                let usage = json!({"promptTokenCount": 900, "candidatesTokenCount": 12, "totalTokenCount": 912});
                let content = |text: &str| json!({"role": "model", "parts": [{"text": text}]});
                let last = if is_refused {
                    json!({"index": 0, "finishReason": reason})
                } else {
                    json!({"index": 0, "finishReason": reason, "content": content(second)})
                };
                let parts = [json!({"index": 0, "content": content(first)}), last];
                let event =
                    |part: &Value| format!("data: {}\n\n", json!({"candidates": [part], "usageMetadata": usage}));
                parts.iter().map(event).collect()
            }
        }
    }
}
