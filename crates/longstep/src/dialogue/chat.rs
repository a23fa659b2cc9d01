//! Requests to language models and their replies, as plain data.
//!
//! The library builds requests and parses replies; it never calls a model.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::Picture;
use crate::usage::Usage;

/// The role of a [`Message`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Role {
    /// Sets the task; the first message.
    System,
    /// The person.
    User,
    /// The model.
    Assistant,
}

/// One message of a conversation.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Message {
    /// The role.
    pub role: Role,
    /// The text, without chat-template markers.
    pub text: String,
    /// The pictures after the text, for models that see.
    pub pictures: Vec<Picture>,
}

impl Message {
    /// Creates a message.
    pub fn new(role: Role, text: impl Into<String>) -> Self {
        Self {
            role,
            text: text.into(),
            pictures: Vec::new(),
        }
    }

    /// Adds pictures to the message.
    #[must_use]
    pub fn with_pictures(self, pictures: Vec<Picture>) -> Self {
        Self { pictures, ..self }
    }
}

/// Constraint on the output of a model.
#[derive(Debug, Clone, PartialEq)]
pub enum Constraint {
    /// Any text.
    Free,
    /// A grammar in llguidance's Lark dialect, for an engine with control over token sampling.
    Lark(String),
    /// A JSON schema, for a server. Some servers accept a schema and ignore it, so the parser validates the reply
    /// anyway.
    JsonSchema(Value),
}

/// The task of a request. A model may have an adapter for one task; its other answers are those of the model alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Task {
    /// Says what an instruction means.
    Goals,
    /// Writes down what a description of a scene says.
    Description,
    /// Says how a plan is to change, or how stored plans go together.
    Plans,
    /// Every other task.
    #[default]
    Other,
}

/// One request to a model.
#[derive(Debug, Clone, PartialEq)]
pub struct ChatRequest {
    /// The task.
    pub task: Task,
    /// The conversation, from the system message to the newest user message.
    pub messages: Vec<Message>,
    /// Number of leading messages that are equal in all requests of a domain: the prefix to cache. An engine may keep
    /// its state for them on disk.
    pub fixed: usize,
    /// Start of the model's answer, which the reply continues. Used only with [`Constraint::Lark`].
    pub answer_so_far: String,
    /// Constraint on the answer after `answer_so_far`.
    pub constraint: Constraint,
    /// Token budget of the answer.
    pub max_tokens: u32,
}

/// Reason why generation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Finish {
    /// The model ended its answer, or the grammar permitted no further token.
    Stop,
    /// The token limit cut the text off.
    Length,
    /// The model refused or the server withheld the answer.
    Refused,
}

/// A model's reply.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reply {
    /// The text, unchanged.
    pub text: String,
    /// Reason why generation ended.
    pub finish: Finish,
    /// Token counts.
    pub usage: Usage,
    /// The likelihood of the text; none from a server or an old recording.
    pub likelihood: Option<Likelihood>,
}

impl Reply {
    /// A reply that its model ended, without token counts and without a likelihood: from a person, or of a model that tells
    /// neither.
    ///
    /// ```
    /// use longstep::dialogue::{Finish, Reply};
    /// let reply = Reply::complete("wish");
    /// assert_eq!((reply.text.as_str(), reply.finish), ("wish", Finish::Stop));
    /// ```
    #[must_use]
    pub fn complete(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            finish: Finish::Stop,
            usage: Usage::default(),
            likelihood: None,
        }
    }
}

/// How likely a model finds a reply under a grammar: logarithms of probabilities over its whole vocabulary, in thousandths
/// of a nat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Likelihood {
    /// The text, with its end if the model ended it, and without the tokens that the grammar forces.
    pub text: i64,
    /// By how much the text is likelier than every other one that the grammar allows, at least; none if no other one was looked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ahead: Option<i64>,
    /// True if the model was trained for the [`Task`]: it is sure of most of its answers then, and an answer of which it is
    /// not is more often wrong.
    #[serde(default, skip_serializing_if = "is_false")]
    pub is_trained: bool,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_false(value: &bool) -> bool {
    !value
}

/// The kind of [`Constraint`] that a model supports. It decides the form of requests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConstraintKind {
    /// The engine masks every token by a grammar; the answer is built goal by goal.
    Grammar,
    /// A server with JSON schemas; the answer arrives whole.
    JsonSchema,
}

/// A reply about an instruction, and the feedback on it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Round {
    /// The reply in normalized form: goals joined by ` & `, `question: ...`, or a plan.
    pub reply: String,
    /// The feedback of the person or the verifier.
    pub message: String,
}
