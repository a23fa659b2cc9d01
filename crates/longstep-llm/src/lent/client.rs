//! The side that borrows the model.

use std::cell::RefCell;
use std::collections::HashMap;
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use longstep::dialogue::{ChatRequest, ConstraintKind, Counting, Message, Reply, TokenCounter};
use longstep_files::{read_text_bounded, session_directory};
use reqwest::{RequestBuilder, Url};
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::service::{ChatCall, CountCall};
use crate::call::{self, Call, GivenUp};
use crate::server::environment;
use crate::wire::{VERSION, WireHead, WireMessage, WireReply, WireRequest, WireTask};
use crate::{AnswerLimit, ChatModel, ModelError, OpenOptions, Progress, Sampling, StopFlag, Watch};

/// The environment variable with the token of the server.
const TOKEN: &str = "LONGSTEP_TOKEN";

/// The most bytes of an answer.
const LARGEST: usize = 8 << 20;

/// The time for the description of the model, and for counts. A server answers when its model has no other work.
const QUESTION: Duration = Duration::from_secs(60);

/// The model of a Longstep server.
pub(crate) struct LentModel {
    connection: Connection,
    head: WireHead,
    timeout: Duration,
    counts: HashMap<Message, u64>,
    frame: Option<u64>,
    /// A count that failed; the next request returns it.
    failed: Option<ModelError>,
}

impl LentModel {
    /// Asks the server at this address for its model.
    ///
    /// # Errors
    ///
    /// Options that are those of the server, no token, or a server that does not answer.
    pub(crate) fn open(url: &str, options: &OpenOptions) -> Result<Self, ModelError> {
        let connection = Connection::new(url, options.stop.clone())?;
        if options.sampling != Sampling::default() || options.context_tokens.is_some() {
            return Err(ModelError::Unsupported {
                model: connection.server,
                reason: "its sampling, reasoning and context are those it was started with; leave them out".to_owned(),
            });
        }
        let head: WireHead = connection.ask(QUESTION, &|| false, |http, address| http.get(address("api/model")))?;
        if head.version != VERSION {
            return Err(connection.bad(&format!(
                "its model is described in version {}; this program reads version {VERSION}",
                head.version
            )));
        }
        Ok(Self {
            connection,
            head,
            timeout: options.timeout,
            counts: HashMap::new(),
            frame: None,
            failed: None,
        })
    }

    /// Counts the tokens of messages. A failure is told by the next request.
    fn count(&mut self, messages: &[Message]) {
        #[derive(Deserialize)]
        struct Counted {
            tokens: Vec<u64>,
            frame: u64,
        }
        let call = CountCall {
            messages: messages.iter().map(WireMessage::from).collect(),
        };
        let counted = self.connection.ask(QUESTION, &|| false, |http, address| {
            http.post(address("api/model/count")).json(&call)
        });
        match counted {
            Ok(Counted { tokens, frame }) => {
                self.frame = Some(frame);
                self.counts.extend(messages.iter().cloned().zip(tokens));
            }
            Err(error) => drop(self.failed.get_or_insert(error)),
        }
    }
}

impl ChatModel for LentModel {
    fn name(&self) -> &str {
        &self.head.name
    }

    fn constraint_kind(&self) -> ConstraintKind {
        self.head.kind()
    }

    fn chat(&mut self, request: &ChatRequest, watch: &mut dyn Watch) -> Result<Reply, ModelError> {
        if let Some(error) = self.failed.take() {
            return Err(error);
        }
        watch.tell(Progress::Waiting);
        let call = ChatCall {
            request: WireRequest::of(request),
            task: WireTask::from(request.task),
            fixed: request.fixed,
        };
        let watch = RefCell::new(watch);
        let stopped = || watch.borrow().stop();
        let reply: WireReply = self.connection.ask(self.timeout, &stopped, |http, address| {
            http.post(address("api/model/chat")).json(&call)
        })?;
        Ok(Reply::from(&reply))
    }

    fn context_tokens(&self) -> Option<u64> {
        self.head.context_tokens
    }
}

impl TokenCounter for LentModel {
    fn message_tokens(&mut self, message: &Message) -> u64 {
        if !self.counts.contains_key(message) {
            self.count(std::slice::from_ref(message));
        }
        self.counts.get(message).copied().unwrap_or_default()
    }

    fn frame_tokens(&mut self) -> u64 {
        if self.frame.is_none() {
            self.count(&[]);
        }
        self.frame.unwrap_or_default()
    }

    fn tokens(&mut self, messages: &[Message]) -> u64 {
        let new: Vec<Message> = messages
            .iter()
            .filter(|message| !self.counts.contains_key(*message))
            .cloned()
            .collect();
        if !new.is_empty() {
            self.count(&new);
        }
        let all: u64 = messages.iter().map(|message| self.message_tokens(message)).sum();
        self.frame_tokens() + all
    }

    fn counting(&self) -> Counting {
        self.head.counting()
    }
}

/// A server and its token.
struct Connection {
    http: reqwest::Client,
    base: Url,
    /// The address without user and password, for messages.
    server: String,
    token: String,
    stop: StopFlag,
}

impl Connection {
    fn new(url: &str, stop: StopFlag) -> Result<Self, ModelError> {
        let unreachable = |reason: String| ModelError::Unreachable {
            server: "the server of Longstep".to_owned(),
            reason,
        };
        let base: Url = format!("{url}/")
            .parse()
            .map_err(|error| unreachable(format!("its address cannot be read: {error}")))?;
        let server = format!("the server of Longstep at {}", base.origin().ascii_serialization());
        let token = token(&base).ok_or_else(|| ModelError::NoKey {
            server: server.clone(),
            variable: TOKEN,
        })?;
        let http = call::client(0).map_err(unreachable)?;
        Ok(Self {
            http,
            base,
            server,
            token,
            stop,
        })
    }

    /// Sends a request, and reads the answer.
    fn ask<T: DeserializeOwned>(
        &self,
        time: Duration,
        stopped: &dyn Fn() -> bool,
        request: impl FnOnce(&reqwest::Client, &dyn Fn(&str) -> Url) -> RequestBuilder,
    ) -> Result<T, ModelError> {
        let stopped = || self.stop.is_set() || stopped();
        let call = Call::new(time, &stopped);
        // A path of letters joins every address.
        let address = |path: &str| self.base.join(path).unwrap_or_else(|_| self.base.clone());
        let request = request(&self.http, &address).bearer_auth(&self.token);
        let (status, body) = call::run(self.exchange(request, &call)).map_err(|error| self.unreachable(&error))??;
        if status != 200 {
            return Err(self.refused(status, &body));
        }
        serde_json::from_slice(&body).map_err(|error| self.bad(&error.to_string()))
    }

    async fn exchange(&self, request: RequestBuilder, call: &Call<'_>) -> Result<(u16, Vec<u8>), ModelError> {
        let given_up = |reason| match reason {
            GivenUp::Stopped => ModelError::Stopped,
            GivenUp::Late | GivenUp::TimedOut => call.timed_out(&self.server),
        };
        let failed = |error: reqwest::Error| ModelError::Unreachable {
            server: self.server.clone(),
            reason: call::root(&error),
        };
        let mut response = call
            .wait(call.left(), request.send())
            .await
            .map_err(given_up)?
            .map_err(failed)?;
        let mut body = Vec::new();
        while let Some(part) = call
            .wait(call.left(), response.chunk())
            .await
            .map_err(given_up)?
            .map_err(failed)?
        {
            body.extend_from_slice(&part);
            if body.len() > LARGEST {
                return Err(ModelError::TooLarge {
                    server: self.server.clone(),
                    limit: AnswerLimit::Bytes(LARGEST as u64),
                });
            }
        }
        Ok((response.status().as_u16(), body))
    }

    /// Returns the error for the problem of a server.
    fn refused(&self, status: u16, body: &[u8]) -> ModelError {
        #[derive(Deserialize)]
        struct Body {
            error: Problem,
        }
        #[derive(Deserialize)]
        struct Problem {
            message: String,
        }
        let message = match serde_json::from_slice(body) {
            Ok(Body { error }) => error.message,
            Err(_) => "this is no server of Longstep, or one without a model to lend".to_owned(),
        };
        ModelError::Status {
            server: self.server.clone(),
            status,
            message: longstep_core::visible::line(&message).into_owned(),
        }
    }

    fn unreachable(&self, error: &std::io::Error) -> ModelError {
        ModelError::Unreachable {
            server: self.server.clone(),
            reason: error.to_string(),
        }
    }

    fn bad(&self, reason: &str) -> ModelError {
        ModelError::BadAnswer {
            server: self.server.clone(),
            reason: reason.to_owned(),
        }
    }
}

/// Returns the token for a server: that of the environment, or the one in the state of this user, which is sent to this
/// machine alone.
fn token(base: &Url) -> Option<String> {
    if let Some(token) = environment(TOKEN) {
        return Some(token);
    }
    let file = token_file().filter(|_| is_this_machine(base))?;
    read_text_bounded(Path::new(&file), 1_000)
        .ok()
        .map(|text| text.trim().to_owned())
}

/// The file in which `longstep serve` keeps its token.
fn token_file() -> Option<PathBuf> {
    Some(session_directory().ok()?.parent()?.join("server").join("token"))
}

fn is_this_machine(base: &Url) -> bool {
    let host = base.host_str().unwrap_or_default().trim_matches(['[', ']']);
    host == "localhost" || host.parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn token_of_the_user_is_sent_to_this_machine_alone() {
        for (url, expected) in [
            ("http://127.0.0.1:8765/", true),
            ("http://localhost:1/", true),
            ("http://[::1]:1/", true),
            ("https://robot.lab/", false),
            ("http://127.0.0.1.evil.example/", false),
            ("http://localhost.evil.example/", false),
            ("http://10.0.0.1/", false),
        ] {
            assert_eq!(is_this_machine(&url.parse().unwrap()), expected, "{url}");
        }
    }
}
