//! Servers that speak OpenAI's dialect: `POST {base}/chat/completions`.

mod secret;
mod transport;
mod wire;

use longstep::prompt::{
    ChatRequest, Constraint, ConstraintKind, Counting, EstimatedTokens, Message, Reply, TokenCounter,
};
use serde_json::Value;

use crate::{ChatModel, ModelError, Progress, Watch};
use secret::Secret;
use transport::{Answer, Transport};
use wire::Dialect;

const OPENAI: &str = "https://api.openai.com/v1";

/// A model of a server.
#[derive(Debug)]
pub(crate) struct OpenAiModel {
    model: String,
    transport: Transport,
    /// How this server wants to be asked; learnt from what it rejects.
    dialect: Dialect,
}

impl OpenAiModel {
    /// A model of OpenAI, or of the server at `OPENAI_BASE_URL`.
    pub(crate) fn openai(model: &str) -> Result<Self, ModelError> {
        let base = variable("OPENAI_BASE_URL").unwrap_or_else(|| OPENAI.into());
        let key = variable("OPENAI_API_KEY").ok_or_else(|| ModelError::NoKey {
            server: base.clone(),
            variable: "OPENAI_API_KEY",
        })?;
        Ok(Self::new(model, &base, Some(Secret::new(key)), Dialect::openai()))
    }

    /// A model of another server. OpenAI's key goes to OpenAI alone.
    pub(crate) fn server(url: &str, model: &str) -> Self {
        let openai = is_openai(url);
        let key = variable("LONGSTEP_API_KEY").or_else(|| variable("OPENAI_API_KEY").filter(|_| openai));
        let dialect = if openai { Dialect::openai() } else { Dialect::common() };
        Self::new(model, url, key.map(Secret::new), dialect)
    }

    fn new(model: &str, base: &str, key: Option<Secret>, dialect: Dialect) -> Self {
        Self {
            model: model.to_owned(),
            transport: Transport::new(base, key),
            dialect,
        }
    }
}

/// The value of an environment variable that is set and not empty.
fn variable(name: &str) -> Option<String> {
    std::env::var(name).ok().filter(|value| !value.is_empty())
}

/// Whether an address is OpenAI's own: its host, whole, over HTTPS.
fn is_openai(url: &str) -> bool {
    let uri: Option<ureq::http::Uri> = url.parse().ok();
    uri.is_some_and(|uri| uri.scheme_str() == Some("https") && uri.host() == Some("api.openai.com"))
}

impl ChatModel for OpenAiModel {
    fn name(&self) -> &str {
        &self.model
    }

    fn constraint_kind(&self) -> ConstraintKind {
        ConstraintKind::JsonSchema
    }

    fn chat(&mut self, request: &ChatRequest, watch: &mut dyn Watch) -> Result<Reply, ModelError> {
        if !request.answer_so_far.is_empty() {
            return Err(self.unsupported("a server cannot go on with an answer that has begun"));
        }
        if let Constraint::Lark(_) = request.constraint {
            return Err(self.unsupported("a server takes a JSON schema, not a grammar"));
        }
        loop {
            let body = wire::body(&self.model, request, self.dialect);
            watch.tell(Progress::Waiting);
            match self.transport.post(&body, watch)? {
                Answer::Ok(answer) => return self.read(&answer),
                Answer::Rejected { status, message } => {
                    // What a server rejects is left out from now on, one thing at a time.
                    match self.dialect.without(&message, request) {
                        Some((dialect, warning)) if status == 400 || status == 422 => {
                            self.dialect = dialect;
                            if let Some(warning) = warning {
                                watch.tell(Progress::Warning(warning.into()));
                            }
                        }
                        _ => {
                            return Err(ModelError::Status {
                                server: self.transport.server().to_owned(),
                                status,
                                message,
                            });
                        }
                    }
                }
            }
        }
    }

    fn context_tokens(&self) -> Option<u64> {
        None
    }
}

impl TokenCounter for OpenAiModel {
    fn message_tokens(&mut self, message: &Message) -> u64 {
        EstimatedTokens::default().message_tokens(message)
    }

    fn frame_tokens(&mut self) -> u64 {
        EstimatedTokens::default().frame_tokens()
    }

    fn counting(&self) -> Counting {
        EstimatedTokens::default().counting()
    }
}

impl OpenAiModel {
    fn read(&self, answer: &Value) -> Result<Reply, ModelError> {
        wire::reply(answer).map_err(|reason| ModelError::BadAnswer {
            server: self.transport.server().to_owned(),
            reason,
        })
    }

    fn unsupported(&self, reason: &str) -> ModelError {
        ModelError::Unsupported {
            model: self.model.clone(),
            reason: reason.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests;
