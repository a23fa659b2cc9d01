//! One attempt: sends a request and reads the streamed answer, with a limit on every part of it.

use std::time::{Duration, Instant};

use longstep::dialogue::{ChatRequest, Reply};
use reqwest::{RequestBuilder, Response};

use super::answer::{Answer, Effect, NoReply, Unreadable};
use super::complaint::Complaint;
use super::dialect::Dialect;
use super::endpoint::Endpoint;
use super::event::{Broken, Event, EventReader};
use super::failure::Failure;
use super::limit::{self, COMPLAINT_BYTES, COMPLAINT_TIME};
use super::retry::{wait_in_body, wait_in_headers};
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
    /// The size of the context that Ollama's own API is asked for.
    pub(super) context: Option<u64>,
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
            context,
        } = outgoing;
        let mut post = self.http.post(dialect.chat_url(endpoint));
        for (name, value) in endpoint.chat_headers() {
            post = post.header(name, value);
        }
        let post = post.json(&dialect.body(&endpoint.model, request, sampling, *context));
        let sent = call.wait(self.silence, post.send()).await;
        let mut response = sent
            .map_err(|reason| self.given_up(reason, endpoint, call))?
            .map_err(|error| no_answer(endpoint, &error))?;
        if !response.status().is_success() {
            return Err(self.rejected(response, endpoint, call).await);
        }
        let most = Dialect::max_tokens(request, sampling);
        let mut incoming = StreamedAnswer::new(endpoint, *dialect, most);
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
        let wait = wait_in_headers(status, response.headers());
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
        rejection(endpoint, status, &body, wait)
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
struct StreamedAnswer<'a> {
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

impl<'a> StreamedAnswer<'a> {
    fn new(endpoint: &'a Endpoint, dialect: Dialect, max_tokens: u32) -> Self {
        Self {
            endpoint,
            events: if dialect.is_native() {
                EventReader::of_lines()
            } else {
                EventReader::default()
            },
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
                Effect::End => {
                    // Some gateways put the end mark behind an answer that is no stream.
                    if self.answer.is_blank() && self.events.stray().starts_with(['{', '[']) {
                        self.add_whole()?;
                    }
                    return Ok(true);
                }
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
            Unreadable::Complaint(body) if self.answer.is_blank() => rejection(self.endpoint, 200, &body, None),
            Unreadable::Failed(reason) if self.answer.is_blank() => rejection(
                self.endpoint,
                500,
                &format!("no answer (finish reason `{reason}`)"),
                None,
            ),
            reason => Failure::Final(unreadable(self.endpoint, reason)),
        })
    }

    /// The end of the connection, before a server has said that the answer is complete.
    fn ended(mut self) -> Result<Received, Failure> {
        if self.answer.is_finished() {
            return self.received();
        }
        let body = self.events.stray().to_owned();
        if self.events_read {
            let reason = match self.endpoint.one_line(&start_of(&body)) {
                words if words.is_empty() => BROKEN_OFF.to_owned(),
                words => format!("{BROKEN_OFF}: {words}"),
            };
            return Err(Failure::Final(bad(self.endpoint, &reason)));
        }
        if body.is_empty() {
            return Err(Failure::Unreachable(bad(self.endpoint, "its answer is empty")));
        }
        if !body.starts_with(['{', '[']) {
            let reason = if body.starts_with('<') {
                "it is a web page; the address of the API may end in `/v1`".to_owned()
            } else {
                format!(
                    "it is no stream of events: `{}`",
                    self.endpoint.one_line(&start_of(&body))
                )
            };
            return Err(Failure::Final(bad(self.endpoint, &reason)));
        }
        self.add_whole()?;
        if self.answer.is_blank() && !self.answer.is_finished() {
            let reason = format!("it has no message: `{}`", self.endpoint.one_line(&start_of(&body)));
            Err(Failure::Final(bad(self.endpoint, &reason)))
        } else {
            self.received()
        }
    }

    /// Adds the answer of a server that does not stream.
    fn add_whole(&mut self) -> Result<(), Failure> {
        let body = self.events.stray();
        let data = body
            .strip_suffix("[DONE]")
            .map_or(body, |body| body.trim_end().trim_end_matches("data:"));
        let whole = Event {
            name: String::new(),
            data: data.trim_end().to_owned(),
        };
        self.effect(&whole).map(|_| ())
    }

    fn received(self) -> Result<Received, Failure> {
        let server = &self.endpoint.server;
        match self.answer.reply(self.cut) {
            Ok(reply) => Ok(Received { reply, cut: self.cut }),
            Err(NoReply::Empty) => Err(Failure::Empty(bad(self.endpoint, "its message has no content"))),
            Err(NoReply::ReasonedOnly { at_limit, tokens }) => Err(Failure::Final(ModelError::ReasonedOnly {
                server: server.clone(),
                reason: match (at_limit, tokens) {
                    (false, _) => "it ended after its reasoning".to_owned(),
                    (true, 0) => "it spent all of its tokens on reasoning".to_owned(),
                    (true, tokens) => format!("it spent all of its {tokens} tokens on reasoning"),
                },
            })),
        }
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
        Unreadable::Complaint(event) => {
            format!("{BROKEN_OFF}: {}", endpoint.one_line(&Complaint::of(&event).message))
        }
        Unreadable::Failed(reason) => format!("{BROKEN_OFF} (finish reason `{}`)", endpoint.one_line(&reason)),
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

/// The failure of a request that the server rejects. A status in the body counts where the HTTP status is a success.
fn rejection(endpoint: &Endpoint, status: u16, body: &str, wait: Option<Duration>) -> Failure {
    let complaint = Complaint::of(body);
    Failure::Rejected {
        status: if status == 200 {
            complaint.status.unwrap_or(200)
        } else {
            status
        },
        message: endpoint.one_line(&complaint.message),
        wait: wait.or_else(|| wait_in_body(body)),
        complaint,
    }
}
