//! Requests and replies as JSON: in recordings, and between a program and a server that lends its model.

use longstep::dialogue::{
    ChatRequest, Constraint, ConstraintKind, Counting, Finish, Likelihood, Message, Picture, Reply, Role, Task, Usage,
};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::ChatModel;

/// The version of the format.
pub(crate) const VERSION: u32 = 1;

/// A model.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct WireHead {
    /// The version of the format, see [`VERSION`].
    pub(crate) version: u32,
    pub(crate) name: String,
    pub(crate) constraint_kind: WireKind,
    pub(crate) counting: WireCounting,
    pub(crate) context_tokens: Option<u64>,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum WireKind {
    Grammar,
    JsonSchema,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum WireCounting {
    Exact(String),
    Estimate(String),
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(crate) struct WireMessage {
    pub(crate) role: WireRole,
    pub(crate) text: String,
    /// The pictures by their hashes: a recording has no copies of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) pictures: Vec<WirePicture>,
}

/// A picture, identified by its SHA-256 hash.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(crate) struct WirePicture {
    pub(crate) media_type: String,
    pub(crate) sha256: String,
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
pub(crate) enum WireRole {
    System,
    User,
    Assistant,
}

/// The content of a request. The number of fixed messages only affects speed and is left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct WireRequest {
    pub(crate) messages: Vec<WireMessage>,
    pub(crate) answer_so_far: String,
    pub(crate) constraint: WireConstraint,
    pub(crate) max_tokens: u32,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum WireConstraint {
    Free,
    Lark(String),
    JsonSchema(Value),
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct WireReply {
    text: String,
    finish: WireFinish,
    prompt_tokens: u64,
    cached_tokens: u64,
    completion_tokens: u64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    likelihood: Option<Likelihood>,
}

/// The task of a request, which decides about adapters.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum WireTask {
    Goals,
    Description,
    Plans,
    #[default]
    Other,
}

impl From<Task> for WireTask {
    fn from(task: Task) -> Self {
        match task {
            Task::Goals => Self::Goals,
            Task::Description => Self::Description,
            Task::Plans => Self::Plans,
            Task::Other => Self::Other,
        }
    }
}

impl From<WireTask> for Task {
    fn from(task: WireTask) -> Self {
        match task {
            WireTask::Goals => Self::Goals,
            WireTask::Description => Self::Description,
            WireTask::Plans => Self::Plans,
            WireTask::Other => Self::Other,
        }
    }
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum WireFinish {
    Stop,
    Length,
    Refused,
}

impl WireHead {
    pub(crate) fn of(model: &dyn ChatModel) -> Self {
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

    pub(crate) fn kind(&self) -> ConstraintKind {
        match self.constraint_kind {
            WireKind::Grammar => ConstraintKind::Grammar,
            WireKind::JsonSchema => ConstraintKind::JsonSchema,
        }
    }

    pub(crate) fn counting(&self) -> Counting {
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

impl WireMessage {
    /// Returns the message as a model takes it.
    ///
    /// # Errors
    ///
    /// It has pictures, of which only the hashes are here.
    pub(crate) fn whole(self) -> Result<Message, &'static str> {
        if !self.pictures.is_empty() {
            return Err("a lent model takes no pictures");
        }
        let role = match self.role {
            WireRole::System => Role::System,
            WireRole::User => Role::User,
            WireRole::Assistant => Role::Assistant,
        };
        Ok(Message::new(role, self.text))
    }
}

impl WireRequest {
    pub(crate) fn of(request: &ChatRequest) -> Self {
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

    /// Returns the request as a model takes it.
    ///
    /// # Errors
    ///
    /// It has pictures, of which only the hashes are here.
    pub(crate) fn whole(self, task: Task, fixed: usize) -> Result<ChatRequest, &'static str> {
        let messages: Result<Vec<Message>, _> = self.messages.into_iter().map(WireMessage::whole).collect();
        Ok(ChatRequest {
            task,
            messages: messages?,
            fixed,
            answer_so_far: self.answer_so_far,
            constraint: match self.constraint {
                WireConstraint::Free => Constraint::Free,
                WireConstraint::Lark(grammar) => Constraint::Lark(grammar),
                WireConstraint::JsonSchema(schema) => Constraint::JsonSchema(schema),
            },
            max_tokens: self.max_tokens,
        })
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
