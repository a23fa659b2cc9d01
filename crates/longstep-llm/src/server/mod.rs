//! Models on servers, by the APIs of OpenAI, Anthropic and Gemini.
//!
//! [`dialect`] decides what a request has, without the parameters that the server names in a [`complaint`], and [`body`] writes
//! it; [`connection`] sends it and reads the streamed answer, [`event`] by event, into an [`answer`]; [`retry`] decides about further attempts. [`limit`] bounds
//! everything that a server sends, and [`count`] counts tokens.

mod answer;
mod body;
mod complaint;
mod connection;
mod count;
mod delta_text;
mod dialect;
mod endpoint;
mod event;
mod failure;
mod limit;
mod probe;
mod redaction;
mod retry;
mod secret;

use std::cell::{OnceCell, RefCell};

use longstep::dialogue::{
    ChatRequest, Constraint, ConstraintKind, Counting, Finish, Message, Reply, TokenCounter, object_text,
};

use crate::call::{Call, GivenUp};
use crate::{ChatModel, ModelError, ModelReference, OpenOptions, Progress, Reasoning, Sampling, Watch};
use connection::{Connection, Outgoing, Received};
use count::Counter;
use dialect::Dialect;
use endpoint::{Endpoint, Lookup};
use failure::Failure;

/// Limit for changes of the dialect in one chat, above the number of parameters that can be omitted.
const CHANGES: usize = 8;

/// A model of a server.
#[derive(Debug)]
pub(crate) struct ServerModel {
    endpoint: Endpoint,
    connection: Connection,
    sampling: Sampling,
    /// The request format, reduced by the parameters that the server rejects.
    dialect: Dialect,
    /// True if a warning about ignored schemas was given.
    warned_of_ignored_schema: bool,
    counter: Counter,
    /// The user's value for the size of the context, if the server reports none.
    given_context: Option<u64>,
    /// The server's value for the size of the context, once requested.
    context: OnceCell<Option<u64>>,
}

/// The canonical address of a reference's server, from the reference and the environment, without user, password and
/// query. `None` if the model is not on a server.
///
/// # Errors
///
/// [`ModelError::NoKey`] and [`ModelError::NoAddress`], as when the model is opened.
pub fn server_address(reference: &ModelReference) -> Result<Option<String>, ModelError> {
    let endpoint = Endpoint::of(reference, &environment).transpose()?;
    Ok(endpoint.map(|endpoint| endpoint.normal_address()))
}

/// The value of an environment variable; an empty one counts as unset.
pub(crate) fn environment(name: &str) -> Option<String> {
    let value = std::env::var(name).ok()?;
    Some(value.trim().to_owned()).filter(|value| !value.is_empty())
}

impl ServerModel {
    /// The model of a reference, with keys from the environment; `None` if the reference is not a server.
    pub(crate) fn open(reference: &ModelReference, options: &OpenOptions) -> Option<Result<Self, ModelError>> {
        Self::open_with(reference, options, &environment)
    }

    fn open_with(
        reference: &ModelReference,
        options: &OpenOptions,
        variable: Lookup<'_>,
    ) -> Option<Result<Self, ModelError>> {
        let endpoint = Endpoint::of(reference, variable)?;
        Some(endpoint.and_then(|endpoint| Self::new(endpoint, options)))
    }

    fn new(endpoint: Endpoint, options: &OpenOptions) -> Result<Self, ModelError> {
        let connection = Connection::new(options.silence, options.timeout, options.stop.clone());
        let connection = connection.map_err(|reason| ModelError::Unreachable {
            server: endpoint.server.clone(),
            reason,
        })?;
        Ok(Self {
            dialect: Dialect::of(endpoint.kind),
            counter: Counter::of(&endpoint),
            connection,
            sampling: options.sampling.clone(),
            warned_of_ignored_schema: false,
            given_context: options.context_tokens.map(u64::from),
            context: OnceCell::new(),
            endpoint,
        })
    }
}

impl ChatModel for ServerModel {
    fn name(&self) -> &str {
        &self.endpoint.model
    }

    fn constraint_kind(&self) -> ConstraintKind {
        ConstraintKind::JsonSchema
    }

    fn chat(&mut self, request: &ChatRequest, watch: &mut dyn Watch) -> Result<Reply, ModelError> {
        if !request.answer_so_far.is_empty() {
            return Err(self.unsupported("a server cannot continue an answer"));
        }
        if let Constraint::Lark(_) = request.constraint {
            return Err(self.unsupported("a server supports JSON schemas, not grammars"));
        }
        let watch = RefCell::new(watch);
        let flag = self.connection.stop.clone();
        let stopped = || flag.is_set() || watch.borrow().stop();
        let call = Call::new(self.connection.timeout, &stopped);
        let mut tell = |progress: Progress| watch.borrow_mut().tell(progress);
        let mut changes = 0;
        loop {
            let failure = match self.try_often(request, &call, &mut tell) {
                Ok(mut received) => {
                    completed(&mut received.reply, request);
                    // Sessions and recordings keep replies.
                    received.reply.text = self.endpoint.without_keys(&received.reply.text);
                    self.look_at(&received, request, &mut tell);
                    return Ok(received.reply);
                }
                Err(failure) => failure,
            };
            changes += 1;
            // Omits the rejected parameters from now on, one at a time.
            if let Some((dialect, warning)) = self.smaller(&failure, request).filter(|_| changes < CHANGES) {
                self.dialect = dialect;
                if let Some(warning) = warning {
                    tell(Progress::Warning(warning.into()));
                }
                continue;
            }
            return Err(match failure {
                Failure::Rejected { status, message, .. } => ModelError::Status {
                    server: self.endpoint.server.clone(),
                    status,
                    message,
                },
                Failure::Final(error) | Failure::Unreachable(error) | Failure::Empty(error) => error,
            });
        }
    }

    /// The size without the tokens that are reserved for reasoning.
    fn context_tokens(&self) -> Option<u64> {
        let reasoning = self.sampling.reasoning.map_or(0, Reasoning::tokens);
        self.window().map(|window| window.saturating_sub(reasoning.into()))
    }
}

impl ServerModel {
    /// The size of the context: the user's value, else the server's.
    fn window(&self) -> Option<u64> {
        let reported = match self.context.get() {
            _ if self.given_context.is_some() => None,
            Some(known) => *known,
            None => {
                let reported = probe::context(&self.endpoint, &self.connection);
                // A cancelled request has no answer, and is repeated later.
                if !self.connection.stop.is_set() {
                    let _ = self.context.set(reported);
                }
                reported
            }
        };
        self.given_context.or(reported)
    }
}

/// An answer that is a whole JSON object is no answer that was cut off: some models fill the rest with blanks.
fn completed(reply: &mut Reply, request: &ChatRequest) {
    let is_whole = matches!(request.constraint, Constraint::JsonSchema(_))
        && reply.text.ends_with(char::is_whitespace)
        && reply.text.trim_end().ends_with('}');
    if reply.finish == Finish::Length && is_whole && object_text(&reply.text).is_some() {
        reply.finish = Finish::Stop;
    }
}

impl TokenCounter for ServerModel {
    fn message_tokens(&mut self, message: &Message) -> u64 {
        self.counter.message(message, &self.endpoint, &self.connection)
    }

    fn frame_tokens(&mut self) -> u64 {
        self.counter.frame()
    }

    fn counting(&self) -> Counting {
        self.counter.counting(&self.endpoint)
    }
}

impl ServerModel {
    /// Sends a request, with retries if the server is busy or the connection fails.
    fn try_often(
        &self,
        request: &ChatRequest,
        call: &Call<'_>,
        tell: &mut dyn FnMut(Progress),
    ) -> Result<Received, Failure> {
        let outgoing = Outgoing {
            endpoint: &self.endpoint,
            dialect: self.dialect,
            request,
            sampling: &self.sampling,
            context: self.dialect.is_native().then(|| self.window()).flatten(),
        };
        let mut tries = 0;
        loop {
            if call.stopped() {
                return Err(Failure::Final(ModelError::Stopped));
            }
            tell(Progress::Waiting);
            let failure = match self.connection.ask(&outgoing, call, tell) {
                Ok(received) => return Ok(received),
                Err(failure) => failure,
            };
            let pause = retry::pause(&failure, tries).filter(|_| self.smaller(&failure, request).is_none());
            // If the pause exceeds the remaining time, the failure is more informative than a timeout.
            let Some(pause) = pause.filter(|pause| *pause < call.left()) else {
                return Err(failure);
            };
            tries += 1;
            let reason = match &failure {
                Failure::Rejected { status, .. } => format!("it answered with status {status}"),
                Failure::Final(error) | Failure::Unreachable(error) | Failure::Empty(error) => error.to_string(),
            };
            tell(Progress::Warning(format!(
                "{}: {reason}; trying again in {:.1} s",
                self.endpoint.server,
                pause.as_secs_f64()
            )));
            if call.rest(pause) == Err(GivenUp::Stopped) {
                return Err(Failure::Final(ModelError::Stopped));
            }
        }
    }

    /// The dialect without a rejected parameter, and a warning; `None` if the failure names no parameter that can be
    /// omitted.
    fn smaller(&self, failure: &Failure, request: &ChatRequest) -> Option<(Dialect, Option<&'static str>)> {
        let Failure::Rejected { status, complaint, .. } = failure else {
            return None;
        };
        let has_no_such_path = matches!(status, 404 | 405) && !complaint.says(&["model"]);
        if self.dialect.is_native() && has_no_such_path {
            return Some((self.dialect.compatible(), None));
        }
        // Some servers report an invalid request, or a schema that they cannot follow, with status 500.
        let is_invalid = || complaint.says(&["validation error"]) || Dialect::is_about_request(complaint);
        let is_rejected = matches!(status, 200 | 400 | 403 | 404 | 422) || (*status == 500 && is_invalid());
        let smaller = || self.dialect.without(complaint, request, &self.sampling);
        is_rejected.then(smaller).flatten()
    }

    /// Calibrates token counts with a reply, and checks that the server respected limit and schema.
    fn look_at(&mut self, received: &Received, request: &ChatRequest, tell: &mut dyn FnMut(Progress)) {
        let reply = &received.reply;
        if received.cut {
            tell(Progress::Warning(format!(
                "the server exceeded the limit of {} tokens; its answer is cut off",
                request.max_tokens
            )));
            return;
        }
        self.counter.learn(&request.messages, &reply.usage);
        if let Constraint::JsonSchema(schema) = &request.constraint
            && reply.finish == Finish::Stop
            && self.dialect.sends_schema()
            && !self.warned_of_ignored_schema
            && !dialect::fits(object_text(&reply.text).as_deref().unwrap_or(&reply.text), schema)
        {
            self.warned_of_ignored_schema = true;
            let warning = "the server ignored the schema: its answer has another form";
            tell(Progress::Warning(warning.into()));
        }
    }

    fn unsupported(&self, reason: &str) -> ModelError {
        ModelError::Unsupported {
            model: self.endpoint.model.clone(),
            reason: reason.to_owned(),
        }
    }
}

#[cfg(test)]
mod cassettes;
#[cfg(test)]
mod tests;
