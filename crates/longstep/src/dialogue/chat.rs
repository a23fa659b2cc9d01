//! What is said to a language model and what comes back, whichever model it is.
//!
//! These are plain data: the library makes requests and reads replies, and never calls a model itself.

use crate::usage::Usage;
use serde_json::Value;

/// Who says a [`Message`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Role {
    /// Sets the task; comes first.
    System,
    /// Speaks for the person.
    User,
    /// Speaks for the model.
    Assistant,
}

/// One turn of a conversation.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Message {
    /// Who speaks.
    pub role: Role,
    /// What is said, without any template markers of a model.
    pub text: String,
}

impl Message {
    /// A turn of the given role.
    pub fn new(role: Role, text: impl Into<String>) -> Self {
        Self {
            role,
            text: text.into(),
        }
    }
}

/// Which answers are allowed.
#[derive(Debug, Clone, PartialEq)]
pub enum Constraint {
    /// Any text.
    Free,
    /// A grammar in llguidance's Lark dialect, for a model whose every token we choose.
    Lark(String),
    /// A JSON schema, for a server. A hint only: some servers accept a schema and ignore it,
    /// so the reader of the reply checks it all the same.
    JsonSchema(Value),
}

/// One request to a model.
#[derive(Debug, Clone, PartialEq)]
pub struct ChatRequest {
    /// The conversation, system turn first, the person's turn last.
    pub messages: Vec<Message>,
    /// How many of the first messages are the same for every request of a domain. An engine
    /// that can keep its state for them on disk does.
    pub fixed: usize,
    /// How the model's answer begins already; the reply's text goes on from here. Only sent to
    /// models that take [`Constraint::Lark`].
    pub answer_so_far: String,
    /// What the answer (after `answer_so_far`) must look like.
    pub constraint: Constraint,
    /// At most this many tokens are generated.
    pub max_tokens: u32,
}

/// Why a model stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Finish {
    /// It said that it was done, or the grammar allowed nothing more.
    Stop,
    /// It ran into the token limit: the text is cut off.
    Length,
    /// The server withheld the answer or the model refused to give one.
    Refused,
}

/// What a model answered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reply {
    /// The text, as it came.
    pub text: String,
    /// Why it ended.
    pub finish: Finish,
    /// What it cost.
    pub usage: Usage,
}

/// The kind of [`Constraint`] that a model obeys, which decides how it is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConstraintKind {
    /// The engine masks every token by a grammar: the answer is built fact by fact.
    Grammar,
    /// A server that takes a JSON schema: the answer comes whole.
    JsonSchema,
}

/// What a model replied about an instruction, and what was said to it then.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Round {
    /// The reply, or what was made of it: goals joined by ` & `, `question: ...`, or a plan.
    pub replied: String,
    /// The words of a person, or of the verifier.
    pub said: String,
}
