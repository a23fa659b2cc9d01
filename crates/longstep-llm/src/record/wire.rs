//! The lines of a recording.

use longstep::dialogue::{
    ChatRequest, Constraint, ConstraintKind, Counting, Finish, Likelihood, Message, Picture, Reply, Role, Usage,
};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::ChatModel;

/// The version of the format.
pub(super) const VERSION: u32 = 1;

/// One line: an object with one key, which names its kind.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Line {
    /// The recorded model; the first line.
    Recording(WireHead),
    /// A request and its reply.
    Turn { request: WireRequest, reply: WireReply },
    /// A counted message.
    Count(WireCount),
    /// The tokens around the messages of a conversation.
    Frame(u64),
}

/// The recorded model.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct WireHead {
    /// The version of the format, see [`VERSION`].
    pub(super) version: u32,
    pub(super) name: String,
    pub(super) constraint_kind: WireKind,
    pub(super) counting: WireCounting,
    pub(super) context_tokens: Option<u64>,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum WireKind {
    Grammar,
    JsonSchema,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum WireCounting {
    Exact(String),
    Estimate(String),
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct WireCount {
    #[serde(flatten)]
    pub(super) message: WireMessage,
    pub(super) tokens: u64,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(super) struct WireMessage {
    pub(super) role: WireRole,
    pub(super) text: String,
    /// The pictures by their hashes: a recording has no copies of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) pictures: Vec<WirePicture>,
}

/// A picture, identified by its SHA-256 hash.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(super) struct WirePicture {
    pub(super) media_type: String,
    pub(super) sha256: String,
}

impl From<&Picture> for WirePicture {
    fn from(picture: &Picture) -> Self {
        let hash = Sha256::digest(picture.bytes());
        Self {
            media_type: picture.media_type().to_owned(),
            sha256: hash.iter().map(|byte| format!("{byte:02x}")).collect(),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum WireRole {
    System,
    User,
    Assistant,
}

/// The content of a request. The number of fixed messages only affects speed and is left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct WireRequest {
    pub(super) messages: Vec<WireMessage>,
    pub(super) answer_so_far: String,
    pub(super) constraint: WireConstraint,
    pub(super) max_tokens: u32,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum WireConstraint {
    Free,
    Lark(String),
    JsonSchema(Value),
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct WireReply {
    text: String,
    finish: WireFinish,
    prompt_tokens: u64,
    cached_tokens: u64,
    completion_tokens: u64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    likelihood: Option<Likelihood>,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum WireFinish {
    Stop,
    Length,
    Refused,
}

impl WireHead {
    pub(super) fn of(model: &dyn ChatModel) -> Self {
        Self {
            version: VERSION,
            name: model.name().to_owned(),
            constraint_kind: match model.constraint_kind() {
                ConstraintKind::Grammar => WireKind::Grammar,
                ConstraintKind::JsonSchema => WireKind::JsonSchema,
            },
            counting: match model.counting() {
                Counting::Exact(how) => WireCounting::Exact(how),
                Counting::Estimate(how) => WireCounting::Estimate(how),
            },
            context_tokens: model.context_tokens(),
        }
    }

    pub(super) fn kind(&self) -> ConstraintKind {
        match self.constraint_kind {
            WireKind::Grammar => ConstraintKind::Grammar,
            WireKind::JsonSchema => ConstraintKind::JsonSchema,
        }
    }

    pub(super) fn counting(&self) -> Counting {
        match &self.counting {
            WireCounting::Exact(how) => Counting::Exact(how.clone()),
            WireCounting::Estimate(how) => Counting::Estimate(how.clone()),
        }
    }
}

impl From<&Message> for WireMessage {
    fn from(message: &Message) -> Self {
        Self {
            role: match message.role {
                Role::System => WireRole::System,
                Role::User => WireRole::User,
                Role::Assistant => WireRole::Assistant,
            },
            text: message.text.clone(),
            pictures: message.pictures.iter().map(WirePicture::from).collect(),
        }
    }
}

impl WireRequest {
    pub(super) fn of(request: &ChatRequest) -> Self {
        Self {
            messages: request.messages.iter().map(WireMessage::from).collect(),
            answer_so_far: request.answer_so_far.clone(),
            constraint: match &request.constraint {
                Constraint::Free => WireConstraint::Free,
                Constraint::Lark(grammar) => WireConstraint::Lark(grammar.clone()),
                Constraint::JsonSchema(schema) => WireConstraint::JsonSchema(schema.clone()),
            },
            max_tokens: request.max_tokens,
        }
    }
}

impl From<&Reply> for WireReply {
    fn from(reply: &Reply) -> Self {
        Self {
            text: reply.text.clone(),
            finish: match reply.finish {
                Finish::Stop => WireFinish::Stop,
                Finish::Length => WireFinish::Length,
                Finish::Refused => WireFinish::Refused,
            },
            prompt_tokens: reply.usage.prompt_tokens,
            cached_tokens: reply.usage.cached_tokens,
            completion_tokens: reply.usage.completion_tokens,
            likelihood: reply.likelihood,
        }
    }
}

impl From<&WireReply> for Reply {
    fn from(reply: &WireReply) -> Self {
        Self {
            text: reply.text.clone(),
            finish: match reply.finish {
                WireFinish::Stop => Finish::Stop,
                WireFinish::Length => Finish::Length,
                WireFinish::Refused => Finish::Refused,
            },
            usage: Usage {
                calls: 1,
                prompt_tokens: reply.prompt_tokens,
                cached_tokens: reply.cached_tokens,
                completion_tokens: reply.completion_tokens,
            },
            likelihood: reply.likelihood,
        }
    }
}
