//! One request over HTTP, tried again where that may help.

use std::time::Duration;

use serde_json::Value;
use ureq::Agent;
use ureq::http::{Response, StatusCode, header};

use super::secret::Secret;
use crate::{ModelError, Progress, Watch};

/// How often a request is tried again.
const RETRIES: u32 = 2;

/// The longest time that a server may ask us to wait; beyond it we give up at once.
const PATIENCE: Duration = Duration::from_secs(60);

/// How much of a server's complaint is repeated.
const COMPLAINT: usize = 300;

/// A connection to a server.
#[derive(Debug)]
pub(super) struct Transport {
    agent: Agent,
    server: String,
    url: String,
    key: Option<Secret>,
}

/// What a server answered.
#[derive(Debug)]
pub(super) enum Answer {
    /// The answer itself.
    Ok(Value),
    /// A complaint, on one line and without the key.
    Rejected { status: u16, message: String },
}

impl Transport {
    pub(super) fn new(base: &str, key: Option<Secret>) -> Self {
        let config = Agent::config_builder()
            .http_status_as_error(false)
            .timeout_connect(Some(Duration::from_secs(10)))
            .timeout_global(Some(Duration::from_secs(120)))
            // A key is for the host that it was given for.
            .max_redirects(0)
            .max_redirects_will_error(false)
            .user_agent(concat!("longstep/", env!("CARGO_PKG_VERSION")))
            .build();
        let base = base.trim_end_matches('/');
        Self {
            agent: config.new_agent(),
            server: without_password(base),
            url: format!("{base}/chat/completions"),
            key,
        }
    }

    /// The server's address, to be shown.
    pub(super) fn server(&self) -> &str {
        &self.server
    }

    /// Sends a request. Where the server is busy or the connection fails, it is sent again.
    pub(super) fn post(&self, body: &Value, watch: &mut dyn Watch) -> Result<Answer, ModelError> {
        let mut tries = 0;
        loop {
            let outcome = self.once(body);
            let Some(pause) = pause(&outcome, tries) else {
                return outcome.map(|(answer, _)| answer);
            };
            tries += 1;
            let reason = match &outcome {
                Ok((Answer::Rejected { status, .. }, _)) => {
                    format!("it answered with status {status}")
                }
                Ok(_) => String::new(),
                Err(error) => error.to_string(),
            };
            watch.tell(Progress::Warning(format!(
                "{}: {reason}; trying again in {:.1} s",
                self.server,
                pause.as_secs_f64()
            )));
            std::thread::sleep(pause);
        }
    }

    fn once(&self, body: &Value) -> Result<(Answer, Option<Duration>), ModelError> {
        let mut request = self.agent.post(&self.url);
        if let Some(key) = &self.key {
            request = request.header(header::AUTHORIZATION, format!("Bearer {}", key.reveal()));
        }
        let mut response = request.send_json(body).map_err(|error| ModelError::Unreachable {
            server: self.server.clone(),
            reason: self.one_line(&error.to_string()),
        })?;
        let status = response.status();
        let wait = retry_after(&response);
        let text = response.body_mut().read_to_string();
        if status.is_success() {
            let text = text.map_err(|error| self.unreadable(&error.to_string()))?;
            let value = serde_json::from_str(&text).map_err(|error| self.unreadable(&error.to_string()))?;
            return Ok((Answer::Ok(value), None));
        }
        let message = self.one_line(&complaint(&text.unwrap_or_default()));
        let status = status.as_u16();
        Ok((Answer::Rejected { status, message }, wait))
    }

    fn unreadable(&self, reason: &str) -> ModelError {
        ModelError::BadAnswer {
            server: self.server.clone(),
            reason: self.one_line(reason),
        }
    }

    /// A text that may be shown: without the key, on one line, not too long.
    fn one_line(&self, text: &str) -> String {
        let text = match &self.key {
            Some(key) => key.scrub(text),
            None => text.to_owned(),
        };
        let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
        match line.char_indices().nth(COMPLAINT) {
            Some((end, _)) => format!("{}...", line.get(..end).unwrap_or_default()),
            None => line,
        }
    }
}

/// How long to wait before the next try; `None` if there is none.
fn pause(outcome: &Result<(Answer, Option<Duration>), ModelError>, tries: u32) -> Option<Duration> {
    let backoff = Duration::from_millis(500) * 2_u32.pow(tries);
    let pause = match outcome {
        Err(ModelError::Unreachable { .. }) => backoff,
        Ok((Answer::Rejected { status, .. }, wait)) if *status == 429 || *status >= 500 => wait.unwrap_or(backoff),
        _ => return None,
    };
    (tries < RETRIES && pause <= PATIENCE).then_some(pause)
}

/// The seconds that a busy server asks to wait. The other form, a date, is not used by servers
/// of this dialect.
fn retry_after<T>(response: &Response<T>) -> Option<Duration> {
    if response.status() != StatusCode::TOO_MANY_REQUESTS && !response.status().is_server_error() {
        return None;
    }
    let seconds = response.headers().get(header::RETRY_AFTER)?.to_str().ok()?;
    let seconds: f64 = seconds.trim().parse().ok()?;
    Duration::try_from_secs_f64(seconds).ok()
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

/// An address without the user and password that may be written into it.
fn without_password(url: &str) -> String {
    match url.split_once("://") {
        Some((scheme, rest)) => {
            let end = rest.find('/').unwrap_or(rest.len());
            let (host, path) = rest.split_at(end);
            let host = host.rsplit_once('@').map_or(host, |(_, host)| host);
            format!("{scheme}://{host}{path}")
        }
        None => url.to_owned(),
    }
}
