//! A streamed answer, assembled from its events; one parser for each dialect.

use longstep::dialogue::{Finish, Reply, Usage, object_text};
use serde_json::Value;

use super::complaint::Complaint;
use super::delta_text::DeltaText;
use super::endpoint::Kind;
use super::event::{ERROR, Event};
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
    /// The server gives up, with this finish reason alone.
    Failed(String),
}

/// Reason why an answer that has ended is no reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NoReply {
    /// Nothing was written.
    Empty,
    /// The model reasoned and did not answer.
    ReasonedOnly {
        /// True if it had no tokens left.
        at_limit: bool,
        /// Number of its tokens; 0 if the server reports none.
        tokens: u64,
    },
}

/// The received part of an answer.
#[derive(Debug)]
pub(super) struct Answer {
    kind: Kind,
    text: DeltaText,
    refusal: String,
    /// The reasoning before the answer, and the arguments of a tool call: the answer of some servers is there.
    reasoning: DeltaText,
    called: String,
    /// Bytes of reasoning that is counted but not kept.
    thoughts: usize,
    /// Bytes of what else is counted but not kept.
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
            text: DeltaText::default(),
            refusal: String::new(),
            reasoning: DeltaText::default(),
            called: String::new(),
            thoughts: 0,
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
        if event.name == ERROR {
            return Err(Unreadable::Complaint(event.data.clone()));
        }
        let value = parsed(&event.data)?;
        let value = unwrapped(value.get(0).unwrap_or(&value));
        let is_failure = value["base_resp"]["status_code"].as_u64() > Some(0) || value["success"] == false;
        if !value["error"].is_null() || is_failure {
            return Err(Unreadable::Complaint(event.data.clone()));
        }
        let reason = value["choices"][0]["finish_reason"].as_str();
        if let Some(reason) = reason.filter(|reason| FAILED.contains(reason)) {
            let complaint = Complaint::of(&value["choices"][0].to_string());
            return Err(if complaint.message.starts_with('{') {
                Unreadable::Failed(reason.to_owned())
            } else {
                Unreadable::Complaint(complaint.message)
            });
        }
        let before = self.written();
        let ended = match self.kind {
            Kind::Anthropic => self.add_anthropic(value),
            Kind::Gemini => self.add_gemini(value),
            Kind::Ollama if value["choices"].is_null() => self.add_ollama(value),
            Kind::OpenAi | Kind::Azure | Kind::Ollama | Kind::Other => {
                self.add_openai(value);
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

    /// True once the server has said why the answer ends; usage may follow.
    pub(super) fn is_finished(&self) -> bool {
        self.finish.is_some()
    }

    /// True before anything was written.
    pub(super) fn is_blank(&self) -> bool {
        self.written() == 0
    }

    /// The reply. `full` means that the text was cut off at its limit.
    pub(super) fn reply(self, full: bool) -> Result<Reply, NoReply> {
        let finish = match self.finish {
            _ if full => Finish::Length,
            Some(finish) => finish,
            None => Finish::Stop,
        };
        let has_reasoned = self.thoughts > 0 || !self.reasoning.is_blank();
        let usage = self.usage;
        let (text, finish) = if !self.refusal.is_empty() {
            (self.refusal, Finish::Refused)
        } else if !self.text.is_blank() {
            (self.text.text(), finish)
        } else if !self.called.trim().is_empty() {
            (self.called, finish)
        } else if full || finish == Finish::Refused {
            (String::new(), finish)
        } else {
            let reasoning = self.reasoning.text();
            match object_text(&reasoning) {
                Some(_) => (reasoning, finish),
                None if has_reasoned => {
                    return Err(NoReply::ReasonedOnly {
                        at_limit: finish == Finish::Length,
                        tokens: usage.completion_tokens,
                    });
                }
                None => (String::new(), finish),
            }
        };
        if text.is_empty() && finish == Finish::Stop {
            return Err(NoReply::Empty);
        }
        Ok(Reply {
            text,
            finish,
            usage,
            likelihood: None,
        })
    }

    fn written(&self) -> usize {
        self.text.length()
            + self.refusal.len()
            + self.reasoning.length()
            + self.called.len()
            + self.thoughts
            + self.aside
    }

    fn add_openai(&mut self, value: &Value) {
        let choice = &value["choices"][0];
        // A server that does not stream sends a message; others send both, the message with all so far.
        // Azure's answers on own data have a list of messages, Cloudflare's own streams a response.
        let deltas = [&choice["delta"], &choice["message"], &choice["messages"][0]["delta"]];
        let delta = deltas
            .into_iter()
            .find(|delta| delta.is_object())
            .unwrap_or(&Value::Null);
        if let Some(text) = value["response"].as_str() {
            self.text.push(text);
        }
        match &delta["content"] {
            Value::String(text) => self.text.push(text),
            // The form of Mistral's reasoning models.
            Value::Array(parts) => parts.iter().for_each(|part| match part["text"].as_str() {
                Some(text) => self.text.push(text),
                None => self.thoughts += length(&part["thinking"]),
            }),
            Value::Null => {}
            // Some servers read the model's text before they send it.
            other => self.text.push(&other.to_string()),
        }
        if let Some(words) = delta["refusal"].as_str() {
            self.refusal.push_str(words);
        }
        // Some servers send the same words under two names.
        let words = ["reasoning_content", "reasoning"].map(|name| delta[name].as_str().unwrap_or_default());
        let details = delta["reasoning_details"].as_array().into_iter().flatten();
        let details: String = details.filter_map(|part| part["text"].as_str()).collect();
        let mut words = words.into_iter().chain([details.as_str()]);
        self.reasoning
            .push(words.find(|words| !words.is_empty()).unwrap_or_default());
        let call = &delta["tool_calls"][0]["function"]["arguments"];
        let call = if call.is_null() {
            &delta["function_call"]["arguments"]
        } else {
            call
        };
        match call {
            Value::Null => self.aside += length(&delta["tool_calls"]),
            Value::String(text) => self.called.push_str(text),
            other => self.called.push_str(&other.to_string()),
        }
        self.finish = finish(&choice["finish_reason"]).or(self.finish);
        let usage = if value["usage"].is_object() {
            &value["usage"]
        } else {
            &choice["usage"]
        };
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
                    self.text.push(text);
                }
                self.thoughts += length(&delta["thinking"]);
                self.aside += length(&delta["partial_json"]);
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

    /// Adds an object of Ollama's own API. Returns true at the end of the answer.
    fn add_ollama(&mut self, value: &Value) -> bool {
        let message = &value["message"];
        self.text.push(message["content"].as_str().unwrap_or_default());
        self.reasoning.push(message["thinking"].as_str().unwrap_or_default());
        let call = &message["tool_calls"][0]["function"]["arguments"];
        if !call.is_null() {
            self.called.push_str(&call.to_string());
        }
        if value["done"] != true {
            return false;
        }
        self.finish = finish(&value["done_reason"]).or(Some(Finish::Stop));
        self.usage.prompt_tokens = tokens(&value["prompt_eval_count"]);
        self.usage.completion_tokens = tokens(&value["eval_count"]);
        true
    }

    /// Returns true at the end of the answer. A finish reason may come with every part.
    fn add_gemini(&mut self, value: &Value) -> bool {
        let candidate = &value["candidates"][0];
        for part in candidate["content"]["parts"].as_array().into_iter().flatten() {
            match part["text"].as_str() {
                Some(text) if part["thought"] == true => self.thoughts += text.len(),
                Some(text) => self.text.push(text),
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
        false
    }
}

/// Finish reasons of servers that give up in the middle of an answer.
const FAILED: [&str; 7] = [
    "error",
    "network_error",
    "insufficient_system_resource",
    "abort",
    "aborted",
    "cancelled",
    "canceled",
];

/// Returns the answer in the envelope that some gateways put around it.
fn unwrapped(value: &Value) -> &Value {
    let has_answer = |inner: &&Value| inner["choices"].is_array() || inner["response"].is_string();
    let mut inner = ["data", "result"].into_iter().map(|name| &value[name]);
    if value["choices"].is_null() {
        inner.find(has_answer).unwrap_or(value)
    } else {
        value
    }
}

/// Reads the data of an event. Half of a pair of UTF-16, which some servers cut apart, becomes a replacement character.
fn parsed(data: &str) -> Result<Value, Unreadable> {
    let error = match serde_json::from_str(data) {
        Ok(value) => return Ok(value),
        Err(error) => error,
    };
    serde_json::from_str(&without_halves(data)).map_err(|_| Unreadable::NoJson(error.to_string()))
}

fn without_halves(data: &str) -> String {
    let unit = |at: usize| {
        let digits = data.get(at..)?.strip_prefix("\\u")?.get(..4)?;
        u16::from_str_radix(digits, 16).ok()
    };
    let (mut text, mut at) = (String::with_capacity(data.len()), 0);
    while let Some(next) = data[at..].find("\\") {
        let escape = at + next;
        text.push_str(&data[at..escape]);
        let (piece, length) = match (unit(escape), unit(escape + 6)) {
            (Some(0xd800..0xdc00), Some(0xdc00..0xe000)) => (&data[escape..escape + 12], 12),
            (Some(0xd800..0xe000), _) => ("\\ufffd", 6),
            _ => {
                let end = data[escape + 1..].chars().next().map_or(1, |own| 1 + own.len_utf8());
                (&data[escape..escape + end], end)
            }
        };
        text.push_str(piece);
        at = escape + length;
    }
    text.push_str(&data[at..]);
    text
}

/// The finish reason in the terms of any dialect.
fn finish(reason: &Value) -> Option<Finish> {
    Some(match reason.as_str()? {
        "length"
        | "max_tokens"
        | "MAX_TOKENS"
        | "max_output_tokens"
        | "incomplete"
        | "model_context_window_exceeded"
        | "model_length" => Finish::Length,
        "content_filter"
        | "content_filtered"
        | "guardrail_intervened"
        | "sensitive"
        | "refusal"
        | "SAFETY"
        | "RECITATION"
        | "BLOCKLIST"
        | "PROHIBITED_CONTENT"
        | "SPII"
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
