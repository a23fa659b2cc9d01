//! One attempt: sends a request and reads the streamed answer, with a limit on every part of it.

use std::time::{Duration, Instant};

use longstep::dialogue::{ChatRequest, Reply};
use reqwest::header::RETRY_AFTER;
use reqwest::{RequestBuilder, Response};
use serde_json::Value;

use super::answer::{Answer, Effect, Unreadable};
use super::dialect::Dialect;
use super::endpoint::Endpoint;
use super::event::{Broken, Event, EventReader};
use super::failure::Failure;
use super::limit::{self, COMPLAINT_BYTES, COMPLAINT_TIME};
use super::retry::{retry_after, wait_in_body};
use crate::call::{self, Call, GivenUp, root};
use crate::{AnswerLimit, ModelError, Progress, Sampling, StopFlag};

/// An HTTP client for one server.
#[derive(Debug)]
pub(super) struct Connection {
    http: reqwest::Client,
    /// Longest time in which the server may send nothing.
    silence: Duration,
    /// Time limit for one call, including all retries.
    pub(super) timeout: Duration,
    pub(super) stop: StopFlag,
}

/// The content of a chat request.
pub(super) struct Outgoing<'a> {
    pub(super) endpoint: &'a Endpoint,
    pub(super) dialect: Dialect,
    pub(super) request: &'a ChatRequest,
    pub(super) sampling: &'a Sampling,
}

/// A reply. `cut` is true if it was cut off because the server exceeded the limit.
pub(super) struct Received {
    pub(super) reply: Reply,
    pub(super) cut: bool,
}

impl Connection {
    pub(super) fn new(silence: Duration, timeout: Duration, stop: StopFlag) -> Result<Self, String> {
        // No redirects: the key must not go to another host.
        let http = call::client(0)?;
        Ok(Self {
            http,
            silence,
            timeout,
            stop,
        })
    }

    /// Sends a request and reads the streamed answer.
    pub(super) fn ask(
        &self,
        outgoing: &Outgoing<'_>,
        call: &Call<'_>,
        tell: &mut dyn FnMut(Progress),
    ) -> Result<Received, Failure> {
        let endpoint = outgoing.endpoint;
        call::run(self.stream(outgoing, call, tell))
            .unwrap_or_else(|error| Err(Failure::Final(unreachable(endpoint, &error.to_string()))))
    }

    /// Sends a request besides the chat. Returns the body if the status is a success, in time and within the limit.
    pub(super) fn question(&self, request: impl FnOnce(&reqwest::Client) -> RequestBuilder) -> Option<Vec<u8>> {
        let stopped = || self.stop.is_set();
        let call = Call::new(limit::QUESTION_TIME, &stopped);
        let request = request(&self.http);
        let work = async {
            let time = limit::QUESTION_TIME;
            let mut response = call.wait(time, request.send()).await.ok()?.ok()?;
            if !response.status().is_success() {
                return None;
            }
            let mut body = Vec::new();
            while let Some(part) = call.wait(time, response.chunk()).await.ok()?.ok()? {
                if body.len() + part.len() > limit::QUESTION_BYTES {
                    return None;
                }
                body.extend_from_slice(&part);
            }
            Some(body)
        };
        call::run(work).ok().flatten()
    }

    async fn stream(
        &self,
        outgoing: &Outgoing<'_>,
        call: &Call<'_>,
        tell: &mut dyn FnMut(Progress),
    ) -> Result<Received, Failure> {
        let Outgoing {
            endpoint,
            dialect,
            request,
            sampling,
        } = outgoing;
        let mut post = self.http.post(endpoint.chat_url());
        for (name, value) in endpoint.chat_headers() {
            post = post.header(name, value);
        }
        let post = post.json(&dialect.body(&endpoint.model, request, sampling));
        let sent = call.wait(self.silence, post.send()).await;
        let mut response = sent
            .map_err(|reason| self.given_up(reason, endpoint, call))?
            .map_err(|error| no_answer(endpoint, &error))?;
        if !response.status().is_success() {
            return Err(self.rejected(response, endpoint, call).await);
        }
        let mut incoming = Incoming::new(endpoint, request.max_tokens);
        let mut finished: Option<Instant> = None;
        loop {
            // After the reason why the answer ends, only usage follows. Some servers then send signs of life for ever.
            let patience = finished.map_or(self.silence, |since| {
                limit::AFTER_FINISH.saturating_sub(since.elapsed())
            });
            let part = match call.wait(patience, response.chunk()).await {
                Err(GivenUp::Late) if finished.is_some() => return incoming.received(),
                part => part.map_err(|reason| self.given_up(reason, endpoint, call))?,
            };
            let part = match part {
                // The answer is whole, however the connection ends.
                Err(_) if finished.is_some() => return incoming.received(),
                part => part.map_err(|error| Failure::Final(broken_off(endpoint, &error)))?,
            };
            if incoming.add(part.as_deref(), tell)? {
                return incoming.received();
            }
            if part.is_none() {
                return incoming.ended();
            }
            if incoming.answer.is_finished() {
                finished.get_or_insert_with(Instant::now);
            }
        }
    }

    /// Reads the beginning of an error response. If the body is slow or endless, the error with its status is still
    /// reported.
    async fn rejected(&self, mut response: Response, endpoint: &Endpoint, call: &Call<'_>) -> Failure {
        let status = response.status().as_u16();
        let wait = response.headers().get(RETRY_AFTER).and_then(retry_after);
        let stopped = || call.stopped();
        let reading = Call::new(COMPLAINT_TIME.min(call.left()), &stopped);
        let mut body = Vec::new();
        while body.len() < COMPLAINT_BYTES {
            match reading.wait(self.silence, response.chunk()).await {
                Ok(Ok(Some(part))) => body.extend_from_slice(&part),
                Err(GivenUp::Stopped) => return Failure::Final(ModelError::Stopped),
                Ok(Ok(None) | Err(_)) | Err(GivenUp::Late | GivenUp::TimedOut) => break,
            }
        }
        if body.len() >= COMPLAINT_BYTES {
            // The last bytes may be the beginning of the key, which redaction would not recognize.
            body.truncate(COMPLAINT_BYTES - KEY_BYTES);
        }
        let body = String::from_utf8_lossy(&body);
        Failure::Rejected {
            status,
            message: endpoint.one_line(&complaint(&body)),
            wait: wait.or_else(|| wait_in_body(&body)),
            body: body.into_owned(),
        }
    }

    fn given_up(&self, reason: GivenUp, endpoint: &Endpoint, call: &Call<'_>) -> Failure {
        Failure::Final(match reason {
            GivenUp::Stopped => ModelError::Stopped,
            GivenUp::TimedOut => call.timed_out(&endpoint.server),
            GivenUp::Late => ModelError::Silent {
                server: endpoint.server.clone(),
                seconds: self.silence.as_secs_f64(),
            },
        })
    }
}

/// A streamed answer while it is read.
struct Incoming<'a> {
    endpoint: &'a Endpoint,
    events: EventReader,
    answer: Answer,
    /// Bytes received so far, and their limit.
    bytes: u64,
    most: u64,
    /// Number of received pieces of text.
    pieces: usize,
    events_read: bool,
    cut: bool,
}

impl<'a> Incoming<'a> {
    fn new(endpoint: &'a Endpoint, max_tokens: u32) -> Self {
        Self {
            endpoint,
            events: EventReader::default(),
            answer: Answer::new(endpoint.kind, limit::text_bytes(max_tokens)),
            bytes: 0,
            most: limit::answer_bytes(max_tokens),
            pieces: 0,
            events_read: false,
            cut: false,
        }
    }

    /// Adds received bytes; `None` is the end of the stream. Returns true when the answer is complete.
    fn add(&mut self, part: Option<&[u8]>, tell: &mut dyn FnMut(Progress)) -> Result<bool, Failure> {
        self.bytes += part.map_or(0, |part| part.len() as u64);
        if self.bytes > self.most {
            let error = limit::too_large(&self.endpoint.server, AnswerLimit::Bytes(self.most));
            return Err(Failure::Final(error));
        }
        let mut rest = part;
        loop {
            let event = match &mut rest {
                Some(rest) => self.events.next(rest),
                None => self.events.end(),
            };
            let Some(event) = event.map_err(|reason| Failure::Final(broken(self.endpoint, reason)))? else {
                return Ok(false);
            };
            self.events_read = true;
            match self.effect(&event)? {
                Effect::Nothing => {}
                Effect::Written => {
                    // A piece is one token with most servers, and a few tokens with others.
                    self.pieces += 1;
                    tell(Progress::Writing { tokens: self.pieces });
                }
                Effect::End => return Ok(true),
                Effect::Full => {
                    self.cut = true;
                    return Ok(true);
                }
            }
        }
    }

    /// Adds an event. An error before anything was written is a rejection of the request, whatever its status.
    fn effect(&mut self, event: &Event) -> Result<Effect, Failure> {
        self.answer.add(event).map_err(|reason| match reason {
            Unreadable::Complaint(body) if self.answer.is_blank() => Failure::Rejected {
                status: 200,
                message: self.endpoint.one_line(&complaint(&body)),
                wait: wait_in_body(&body),
                body,
            },
            reason => Failure::Final(unreadable(self.endpoint, reason)),
        })
    }

    /// The end of the connection, before a server has said that the answer is complete.
    fn ended(mut self) -> Result<Received, Failure> {
        if self.answer.is_finished() {
            return self.received();
        }
        if self.events_read {
            return Err(Failure::Final(bad(self.endpoint, BROKEN_OFF)));
        }
        let body = self.events.stray().to_owned();
        if body.is_empty() {
            return Err(Failure::Unreachable(bad(self.endpoint, "its answer is empty")));
        }
        if !body.starts_with(['{', '[']) {
            let reason = match body.starts_with('<') {
                true => "it is a web page; the address of the API may end in `/v1`".to_owned(),
                false => format!(
                    "it is no stream of events: `{}`",
                    self.endpoint.one_line(&start_of(&body))
                ),
            };
            return Err(Failure::Final(bad(self.endpoint, &reason)));
        }
        // A server that does not stream.
        let data = body.clone();
        self.effect(&Event {
            data,
            ..Event::default()
        })?;
        match self.answer.is_blank() && !self.answer.is_finished() {
            true => {
                let reason = format!("it has no message: `{}`", self.endpoint.one_line(&start_of(&body)));
                Err(Failure::Final(bad(self.endpoint, &reason)))
            }
            false => self.received(),
        }
    }

    fn received(self) -> Result<Received, Failure> {
        let reply = self.answer.reply(self.cut);
        let reply = reply.map_err(|reason| Failure::Final(bad(self.endpoint, &reason)))?;
        Ok(Received { reply, cut: self.cut })
    }
}

const BROKEN_OFF: &str = "it ended early";

/// Longest key that is recognized in a truncated error body.
const KEY_BYTES: usize = 8 << 10;

/// Maps a request that got no response.
fn no_answer(endpoint: &Endpoint, error: &reqwest::Error) -> Failure {
    let reason = endpoint.one_line(&root(error));
    match call::http_error(error) {
        Some(error) if error.is_parse_too_large() => {
            Failure::Final(limit::too_large(&endpoint.server, AnswerLimit::Headers))
        }
        Some(error) if error.is_parse() => Failure::Final(bad(endpoint, &format!("it is not HTTP: {reason}"))),
        _ => Failure::Unreachable(unreachable(endpoint, &reason)),
    }
}

fn broken_off(endpoint: &Endpoint, error: &reqwest::Error) -> ModelError {
    let reason = endpoint.one_line(&root(error));
    bad(endpoint, &format!("{BROKEN_OFF}: {reason}"))
}

fn broken(endpoint: &Endpoint, reason: Broken) -> ModelError {
    match reason {
        Broken::TooLarge(limit) => limit::too_large(&endpoint.server, limit),
        Broken::NoText(error) => bad(endpoint, &format!("a part of it is not text: {error}")),
    }
}

fn unreadable(endpoint: &Endpoint, reason: Unreadable) -> ModelError {
    let reason = match reason {
        Unreadable::NoJson(reason) => format!("a part of it is not JSON: {}", endpoint.one_line(&reason)),
        Unreadable::Complaint(event) => format!("{BROKEN_OFF}: {}", endpoint.one_line(&complaint(&event))),
    };
    bad(endpoint, &reason)
}

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

fn start_of(body: &str) -> String {
    body.chars().take(120).collect()
}

/// The message in a server's error body, with that of the server behind it; or the whole body.
fn complaint(body: &str) -> String {
    let value: Option<Value> = serde_json::from_str(body).ok();
    let message = value.as_ref().and_then(|value| {
        let value = value.get(0).unwrap_or(value);
        let error = value.get("error").filter(|error| !error.is_null()).unwrap_or(value);
        let text = [
            &error["message"],
            &error["detail"],
            &value["base_resp"]["status_msg"],
            error,
        ];
        let text = text.into_iter().find_map(Value::as_str)?;
        let behind = match &error["metadata"]["raw"] {
            Value::String(raw) => Some(complaint(raw)).filter(|behind| !behind.trim().is_empty()),
            _ => None,
        };
        Some(behind.map_or_else(|| text.to_owned(), |behind| format!("{text}: {behind}")))
    });
    message.unwrap_or_else(|| body.to_owned())
}
