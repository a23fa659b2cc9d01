//! A streamed answer, assembled from its events; one parser for each dialect.

use longstep::dialogue::{Finish, Reply, Usage};
use serde_json::Value;

use super::endpoint::Kind;
use super::event::Event;
use super::limit::TOKENS;

/// Effect of an event on the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Effect {
    /// Nothing was added.
    Nothing,
    /// Text or reasoning was added.
    Written,
    /// The answer is complete.
    End,
    /// The text is longer than the request allows.
    Full,
}

/// Reason why an event cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Unreadable {
    NoJson(String),
    /// The server reports an error in the middle of its answer, with the data of the event.
    Complaint(String),
}

/// The received part of an answer.
#[derive(Debug)]
pub(super) struct Answer {
    kind: Kind,
    text: String,
    refusal: String,
    /// Bytes of reasoning and tool calls, which are counted but not kept.
    aside: usize,
    /// Limit of bytes for text, reasoning and tool calls.
    most: usize,
    finish: Option<Finish>,
    usage: Usage,
}

impl Answer {
    pub(super) fn new(kind: Kind, most: usize) -> Self {
        Self {
            kind,
            text: String::new(),
            refusal: String::new(),
            aside: 0,
            most,
            finish: None,
            usage: Usage {
                calls: 1,
                ..Usage::default()
            },
        }
    }

    /// Adds an event.
    pub(super) fn add(&mut self, event: &Event) -> Result<Effect, Unreadable> {
        if event.data == "[DONE]" {
            return Ok(Effect::End);
        }
        let value: Value = serde_json::from_str(&event.data).map_err(|error| Unreadable::NoJson(error.to_string()))?;
        if !value["error"].is_null() || (self.kind == Kind::Anthropic && event.name == "error") {
            return Err(Unreadable::Complaint(event.data.clone()));
        }
        let before = self.written();
        let ended = match self.kind {
            Kind::Anthropic => self.add_anthropic(&value),
            Kind::Gemini => self.add_gemini(&value),
            Kind::OpenAi | Kind::Azure | Kind::Ollama | Kind::Other => {
                self.add_openai(&value);
                false
            }
        };
        Ok(if self.written() > self.most {
            Effect::Full
        } else if ended {
            Effect::End
        } else if self.written() > before {
            Effect::Written
        } else {
            Effect::Nothing
        })
    }

    /// The reply. `full` means that the text was cut off at its limit.
    pub(super) fn reply(self, full: bool) -> Result<Reply, &'static str> {
        let finish = match self.finish {
            _ if full => Finish::Length,
            Some(finish) => finish,
            None => Finish::Stop,
        };
        let (text, finish) = if self.refusal.is_empty() {
            (self.text, finish)
        } else {
            (self.refusal, Finish::Refused)
        };
        if text.is_empty() && finish == Finish::Stop {
            return Err("its message has no content");
        }
        let usage = self.usage;
        Ok(Reply {
            text,
            finish,
            usage,
            likelihood: None,
        })
    }

    fn written(&self) -> usize {
        self.text.len() + self.refusal.len() + self.aside
    }

    fn add_openai(&mut self, value: &Value) {
        let choice = &value["choices"][0];
        let delta = &choice["delta"];
        match &delta["content"] {
            Value::String(text) => self.text.push_str(text),
            // The form of Mistral's reasoning models.
            Value::Array(parts) => parts.iter().for_each(|part| match part["text"].as_str() {
                Some(text) => self.text.push_str(text),
                None => self.aside += length(&part["thinking"]),
            }),
            _ => {}
        }
        if let Some(words) = delta["refusal"].as_str() {
            self.refusal.push_str(words);
        }
        let reasoning = ["reasoning_content", "reasoning", "tool_calls"];
        self.aside += reasoning.iter().map(|name| length(&delta[*name])).sum::<usize>();
        self.finish = finish(&choice["finish_reason"]).or(self.finish);
        let usage = &value["usage"];
        if usage.is_object() {
            self.usage.prompt_tokens = tokens(&usage["prompt_tokens"]);
            self.usage.cached_tokens = tokens(&usage["prompt_tokens_details"]["cached_tokens"]);
            self.usage.completion_tokens = tokens(&usage["completion_tokens"]);
        }
    }

    /// Returns true at the end of the answer.
    fn add_anthropic(&mut self, value: &Value) -> bool {
        match value["type"].as_str().unwrap_or_default() {
            "message_start" => self.add_anthropic_usage(&value["message"]["usage"]),
            "content_block_delta" => {
                let delta = &value["delta"];
                if let Some(text) = delta["text"].as_str() {
                    self.text.push_str(text);
                }
                self.aside += length(&delta["thinking"]) + length(&delta["partial_json"]);
            }
            "message_delta" => {
                self.finish = finish(&value["delta"]["stop_reason"]).or(self.finish);
                self.add_anthropic_usage(&value["usage"]);
            }
            "message_stop" => return true,
            _ => {}
        }
        false
    }

    /// Anthropic counts cached tokens separately from input tokens, and later events repeat only some of the numbers.
    fn add_anthropic_usage(&mut self, usage: &Value) {
        if usage["input_tokens"].is_number() {
            let cached = tokens(&usage["cache_read_input_tokens"]);
            self.usage.cached_tokens = cached;
            self.usage.prompt_tokens =
                tokens(&usage["input_tokens"]) + tokens(&usage["cache_creation_input_tokens"]) + cached;
        }
        if usage["output_tokens"].is_number() {
            self.usage.completion_tokens = tokens(&usage["output_tokens"]);
        }
    }

    /// Returns true at the end of the answer, which only the finish reason marks.
    fn add_gemini(&mut self, value: &Value) -> bool {
        let candidate = &value["candidates"][0];
        for part in candidate["content"]["parts"].as_array().into_iter().flatten() {
            match part["text"].as_str() {
                Some(text) if part["thought"] == true => self.aside += text.len(),
                Some(text) => self.text.push_str(text),
                None => self.aside += length(part),
            }
        }
        let usage = &value["usageMetadata"];
        if usage.is_object() {
            self.usage.prompt_tokens = tokens(&usage["promptTokenCount"]) + tokens(&usage["toolUsePromptTokenCount"]);
            self.usage.cached_tokens = tokens(&usage["cachedContentTokenCount"]);
            self.usage.completion_tokens =
                tokens(&usage["candidatesTokenCount"]) + tokens(&usage["thoughtsTokenCount"]);
        }
        // A blocked prompt gets no candidate.
        if value["promptFeedback"]["blockReason"].is_string() {
            self.finish = Some(Finish::Refused);
            return true;
        }
        self.finish = finish(&candidate["finishReason"]).or(self.finish);
        candidate["finishReason"].is_string()
    }
}

/// The finish reason in the terms of any dialect.
fn finish(reason: &Value) -> Option<Finish> {
    Some(match reason.as_str()? {
        "length" | "max_tokens" | "MAX_TOKENS" | "incomplete" | "model_context_window_exceeded" | "model_length" => {
            Finish::Length
        }
        "content_filter" | "refusal" | "SAFETY" | "RECITATION" | "BLOCKLIST" | "PROHIBITED_CONTENT" | "SPII"
        | "LANGUAGE" => Finish::Refused,
        _ => Finish::Stop,
    })
}

/// A number of tokens; 0 if it is missing or implausible.
fn tokens(value: &Value) -> u64 {
    value.as_u64().filter(|tokens| *tokens <= TOKENS).unwrap_or(0)
}

/// Bytes of all strings in a value.
fn length(value: &Value) -> usize {
    match value {
        Value::String(text) => text.len(),
        Value::Array(values) => values.iter().map(length).sum(),
        Value::Object(fields) => fields.values().map(length).sum(),
        Value::Null | Value::Bool(_) | Value::Number(_) => 0,
    }
}
