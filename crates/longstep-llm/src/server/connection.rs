//! One try: a request out, the streamed answer in. genai does the talking; this is its blocking side.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use genai::chat::{
    ChatOptions, ChatRequest as GenaiRequest, ChatStreamEvent, StopReason, StreamEnd, Usage as GenaiUsage,
};
use genai::webc::StreamTimeout;
use genai::{Client, Error as GenaiError};
use longstep::prompt::{Finish, Reply, Usage};
use serde_json::Value;
use tokio_stream::StreamExt;

use super::endpoint::{Endpoint, Kind};
use super::retry::retry_after;
use crate::{ModelError, Progress, Watch};

/// How often whoever waits is asked whether it still does.
pub(super) const TICK: Duration = Duration::from_millis(50);

/// The longest time that a connection may take to be made.
const CONNECT: Duration = Duration::from_secs(10);

/// The way to a server.
#[derive(Debug)]
pub(super) struct Connection {
    genai: Client,
    /// The same client under genai, for questions beside the chat.
    pub(super) http: reqwest::Client,
    /// How long a server may say nothing.
    silence: Duration,
}

/// How a try failed.
#[derive(Debug)]
pub(super) enum Failure {
    /// The server answered with an error; the message is on one line and without the key.
    Rejected {
        status: u16,
        message: String,
        /// How long it asks to wait.
        wait: Option<Duration>,
    },
    /// Trying again cannot help, or must not.
    Final(ModelError),
    /// The connection failed before anything was answered.
    Unreachable(ModelError),
}

impl Connection {
    pub(super) fn new(silence: Duration) -> Result<Self, String> {
        // A program that has chosen its cryptography already keeps it.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let http = reqwest::Client::builder()
            .connect_timeout(CONNECT)
            // A key is for the host that it was given for.
            .redirect(reqwest::redirect::Policy::none())
            // Between calls nobody would notice that a server hung up.
            .pool_max_idle_per_host(0)
            .user_agent(concat!("longstep/", env!("CARGO_PKG_VERSION")))
            .build()
            .map_err(|error| root(&error))?;
        let genai = Client::builder()
            .with_reqwest(http.clone())
            .build()
            .map_err(|error| error.to_string())?;
        Ok(Self { genai, http, silence })
    }

    /// Runs to the end, on this thread alone. What is still under way afterwards (a connection, a name being looked up)
    /// is let go.
    pub(super) fn wait<T>(work: impl Future<Output = T>) -> std::io::Result<T> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let outcome = runtime.block_on(work);
        runtime.shutdown_background();
        Ok(outcome)
    }

    /// Sends a request and reads the answer as it comes.
    pub(super) fn ask(
        &self,
        endpoint: &Endpoint,
        request: GenaiRequest,
        options: ChatOptions,
        watch: &mut dyn Watch,
    ) -> Result<Reply, Failure> {
        let work = self.stream(endpoint, request, options, watch);
        Self::wait(work).unwrap_or_else(|error| Err(Failure::Final(unreachable(endpoint, &error.to_string()))))
    }

    async fn stream(
        &self,
        endpoint: &Endpoint,
        request: GenaiRequest,
        options: ChatOptions,
        watch: &mut dyn Watch,
    ) -> Result<Reply, Failure> {
        let refusal = Arc::new(Mutex::new(String::new()));
        let heard = Arc::clone(&refusal);
        let options = options
            .with_stream_header_timeout(self.silence)
            .with_stream_read_timeout(self.silence)
            // genai leaves refusals out of its events.
            .with_raw_frame_fn(move |_, frame| {
                if frame.data.contains("\"refusal\"")
                    && let Some(frame) = frame.json()
                    && let Some(words) = frame.pointer("/choices/0/delta/refusal").and_then(Value::as_str)
                {
                    heard.lock().unwrap_or_else(PoisonError::into_inner).push_str(words);
                }
            });
        let failed = |error: GenaiError, begun: bool| self.failure(endpoint, &error, begun);
        let answer = self
            .genai
            .exec_chat_stream(endpoint.target(), request, Some(&options))
            .await
            .map_err(|error| failed(error, false))?;
        let mut events = answer.stream;
        let (mut text, mut tokens) = (String::new(), 0);
        loop {
            let event = match tokio::time::timeout(TICK, events.next()).await {
                _ if watch.stop() => return Err(Failure::Final(ModelError::Stopped)),
                Err(_) => continue,
                Ok(None) => break,
                Ok(Some(event)) => event.map_err(|error| failed(error, tokens > 0))?,
            };
            match event {
                ChatStreamEvent::Chunk(chunk) => text.push_str(&chunk.content),
                ChatStreamEvent::ReasoningChunk(_) => {}
                // Gemini has no mark at the end but the reason for it, and genai makes up an end without one.
                ChatStreamEvent::End(end) if endpoint.kind == Kind::Gemini && end.captured_stop_reason.is_none() => {
                    break;
                }
                ChatStreamEvent::End(end) => {
                    let refusal = refusal.lock().unwrap_or_else(PoisonError::into_inner).clone();
                    return reply(text, &refusal, &end).map_err(|reason| Failure::Final(bad(endpoint, reason)));
                }
                _ => continue,
            }
            // A piece is a token with most servers, and a few with others.
            tokens += 1;
            watch.tell(Progress::Writing { tokens });
        }
        Err(Failure::Final(bad(endpoint, BROKEN_OFF)))
    }

    fn failure(&self, endpoint: &Endpoint, error: &GenaiError, begun: bool) -> Failure {
        let source = match error {
            GenaiError::WebStream { error, .. } => error.as_ref(),
            GenaiError::StreamParse { serde_error, .. } => {
                let reason = endpoint.one_line(&serde_error.to_string());
                return Failure::Final(bad(endpoint, &format!("a part of it is no JSON: {reason}")));
            }
            GenaiError::ChatResponse { body, .. } => {
                let message = endpoint.one_line(&complaint(&body.to_string()));
                return Failure::Final(bad(endpoint, &format!("{BROKEN_OFF}: {message}")));
            }
            other => other,
        };
        if let Some(GenaiError::HttpError {
            status, body, headers, ..
        }) = source.downcast_ref()
        {
            return Failure::Rejected {
                status: status.as_u16(),
                message: endpoint.one_line(&complaint(body)),
                wait: headers.get(reqwest::header::RETRY_AFTER).and_then(retry_after),
            };
        }
        if source.is::<StreamTimeout>() {
            return Failure::Final(ModelError::Silent {
                server: endpoint.server.clone(),
                seconds: self.silence.as_secs_f64(),
            });
        }
        let reason = endpoint.one_line(&root(source));
        match source.downcast_ref::<reqwest::Error>() {
            Some(error) if !begun && !error.is_body() && !error.is_decode() => {
                Failure::Unreachable(unreachable(endpoint, &reason))
            }
            Some(_) => Failure::Final(bad(endpoint, &format!("{BROKEN_OFF}: {reason}"))),
            None => Failure::Final(bad(endpoint, &reason)),
        }
    }
}

const BROKEN_OFF: &str = "it broke off before its end";

fn bad(endpoint: &Endpoint, reason: &str) -> ModelError {
    ModelError::BadAnswer {
        server: endpoint.server.clone(),
        reason: reason.to_owned(),
    }
}

fn unreachable(endpoint: &Endpoint, reason: &str) -> ModelError {
    ModelError::Unreachable {
        server: endpoint.server.clone(),
        reason: reason.to_owned(),
    }
}

/// What is at the bottom of an error: what is above it names the address, which may have a password in it.
fn root(error: &(dyn std::error::Error + 'static)) -> String {
    let mut deepest = error;
    while let Some(source) = deepest.source() {
        deepest = source;
    }
    deepest.to_string()
}

/// The sentence in a server's complaint, or all of it.
fn complaint(body: &str) -> String {
    let value: Option<Value> = serde_json::from_str(body).ok();
    let message = value.as_ref().and_then(|value| {
        let error = value.get("error").unwrap_or(value);
        let text = error.get("message").or(error.get("detail")).unwrap_or(error);
        text.as_str()
    });
    message.unwrap_or(body).to_owned()
}

fn reply(text: String, refusal: &str, end: &StreamEnd) -> Result<Reply, &'static str> {
    let usage = end.captured_usage.as_ref().map_or_else(Usage::default, usage);
    let finish = match &end.captured_stop_reason {
        Some(StopReason::MaxTokens(_)) => Finish::Length,
        Some(StopReason::ContentFilter(_)) => Finish::Refused,
        _ => Finish::Stop,
    };
    let (text, finish) = match refusal {
        "" => (text, finish),
        words => (words.to_owned(), Finish::Refused),
    };
    if text.is_empty() && finish == Finish::Stop {
        return Err("its message has no content");
    }
    let usage = Usage { calls: 1, ..usage };
    Ok(Reply { text, finish, usage })
}

fn usage(told: &GenaiUsage) -> Usage {
    let count = |tokens: Option<i32>| tokens.and_then(|tokens| u64::try_from(tokens).ok()).unwrap_or(0);
    let details = told.prompt_tokens_details.as_ref();
    Usage {
        calls: 1,
        prompt_tokens: count(told.prompt_tokens),
        cached_tokens: count(details.and_then(|details| details.cached_tokens)),
        completion_tokens: count(told.completion_tokens),
    }
}
