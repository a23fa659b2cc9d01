//! The side that has the model.

use longstep::dialogue::{Message, Task};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::wire::{WireHead, WireMessage, WireReply, WireRequest, WireTask};
use crate::{ChatModel, ModelError, Watch};

/// Returns the description of a model that is lent: its name, how its answers are constrained and its tokens counted, and
/// the size of its context.
///
/// # Errors
///
/// [`ModelError::BadAnswer`] if a name cannot be written as JSON.
pub fn facts(model: &dyn ChatModel) -> Result<Value, ModelError> {
    written(&WireHead::of(model), model)
}

/// A request to a lent model.
///
/// ```
/// use longstep_llm::lent::ChatCall;
///
/// let body = r#"{"request": {"messages": [{"role": "user", "text": "Is the door open?"}], "answer_so_far": "",
///     "constraint": {"lark": "start: \"yes\" | \"no\""}, "max_tokens": 8}}"#;
/// assert!(serde_json::from_str::<ChatCall>(body).is_ok());
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChatCall {
    pub(super) request: WireRequest,
    #[serde(default)]
    pub(super) task: WireTask,
    /// The leading messages that are equal in all requests of a domain.
    #[serde(default)]
    pub(super) fixed: usize,
}

impl ChatCall {
    /// Returns the model's reply.
    ///
    /// # Errors
    ///
    /// Those of [`ChatModel::chat`], and [`ModelError::Unsupported`] for a request with pictures.
    pub fn answer(self, model: &mut dyn ChatModel, watch: &mut dyn Watch) -> Result<Value, ModelError> {
        let fixed = self.fixed.min(self.request.messages.len());
        let request = self.request.whole(Task::from(self.task), fixed);
        let request = request.map_err(|reason| unsupported(model, reason))?;
        let reply = model.chat(&request, watch)?;
        written(&WireReply::from(&reply), model)
    }
}

/// A request for the tokens of messages.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CountCall {
    pub(super) messages: Vec<WireMessage>,
}

impl CountCall {
    /// Returns the tokens of each message, and those of a conversation outside its messages.
    ///
    /// # Errors
    ///
    /// [`ModelError::Unsupported`] for a message with pictures.
    pub fn answer(self, model: &mut dyn ChatModel) -> Result<Value, ModelError> {
        let messages: Result<Vec<Message>, _> = self.messages.into_iter().map(WireMessage::whole).collect();
        let messages = messages.map_err(|reason| unsupported(model, reason))?;
        let tokens: Vec<u64> = messages.iter().map(|message| model.message_tokens(message)).collect();
        Ok(json!({"tokens": tokens, "frame": model.frame_tokens()}))
    }
}

fn unsupported(model: &dyn ChatModel, reason: &str) -> ModelError {
    ModelError::Unsupported {
        model: model.name().to_owned(),
        reason: reason.to_owned(),
    }
}

fn written(value: &impl Serialize, model: &dyn ChatModel) -> Result<Value, ModelError> {
    serde_json::to_value(value).map_err(|error| ModelError::BadAnswer {
        server: model.name().to_owned(),
        reason: error.to_string(),
    })
}
