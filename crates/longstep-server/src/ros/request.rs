//! Requests from ROS 2, and their answers, as JSON.

use longstep_core::visible;
use serde::Deserialize;
use serde_json::{Map, Value, json};

use crate::id::{ApprovalId, SessionId};
use crate::problem::{Problem, ProblemKind};
use crate::talk::Said;

/// The most bytes of a request.
pub(super) const LARGEST: usize = 64 << 10;

/// The most characters of an id that a caller chooses, of its name, and of a hash.
const LONGEST_NAME: usize = 100;

/// The role of a text in a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Role {
    Instruction,
    Answer,
    Feedback,
}

impl Role {
    /// Returns the role of a text in a session with this state.
    pub(super) fn of_state(state: &str) -> Self {
        match state {
            "question" => Self::Answer,
            "plan" | "consent" => Self::Feedback,
            _ => Self::Instruction,
        }
    }

    pub(super) fn said(self, text: String) -> Said {
        match self {
            Self::Instruction => Said::Instruction(text),
            Self::Answer => Said::Answer(text),
            Self::Feedback => Said::Feedback(text),
        }
    }
}

/// A text for a session.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Say {
    /// The id that the answer repeats.
    #[serde(default, rename = "id")]
    _id: Value,
    pub(super) text: String,
    /// The session; a new one if none is named.
    pub(super) session: Option<String>,
    /// The scene of a new session; the first of the server if none is named.
    pub(super) scene: Option<String>,
    /// The role of the text; by the state of the session if none is named.
    #[serde(rename = "as")]
    pub(super) role: Option<Role>,
}

/// A plan to carry out.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Execute {
    #[serde(default, rename = "id")]
    _id: Value,
    /// The hash of the plan.
    pub(super) plan: String,
    /// The session of the plan; needed only where the caller approves.
    pub(super) session: Option<String>,
    /// The approval to use; the last one of the plan that was not used if none is named.
    pub(super) approval: Option<String>,
    /// The robot, where the caller approves.
    pub(super) robot: Option<String>,
    /// The name of the caller, for the audit log.
    pub(super) caller: Option<String>,
}

impl Execute {
    /// Returns who asks, as the audit log names it.
    pub(super) fn by(&self) -> String {
        match self.name() {
            Some(name) => format!("ros2:{name}"),
            None => "ros2".to_owned(),
        }
    }

    /// Returns the name of the caller.
    pub(super) fn name(&self) -> Option<String> {
        let name = self.caller.as_deref().map(str::trim).filter(|name| !name.is_empty())?;
        let short: String = name.chars().take(LONGEST_NAME).collect();
        Some(visible::line(&short).into_owned())
    }

    /// Returns the hash, if it can be one.
    pub(super) fn hash(&self) -> Result<&str, Problem> {
        let is_hash = (1..=LONGEST_NAME).contains(&self.plan.len())
            && self
                .plan
                .bytes()
                .all(|byte| byte.is_ascii_alphanumeric() || byte == b'-');
        if is_hash {
            Ok(&self.plan)
        } else {
            Err(Problem::unreadable("`plan` is no hash of a plan").hint("name the hash that `say` answered"))
        }
    }
}

pub(super) fn session_id(text: &str) -> Result<SessionId, Problem> {
    SessionId::parse(text).ok_or_else(|| Problem::missing("session", quoted(text)))
}

pub(super) fn approval_id(text: &str) -> Result<ApprovalId, Problem> {
    ApprovalId::parse(text).ok_or_else(|| Problem::missing("approval", quoted(text)))
}

fn quoted(text: &str) -> String {
    let short: String = text.chars().take(LONGEST_NAME).collect();
    visible::line(&short).into_owned()
}

/// Reads a request. `text` is its JSON.
///
/// # Errors
///
/// It is too large, or no request of this kind.
pub(super) fn read<T: serde::de::DeserializeOwned>(text: &str) -> Result<T, Problem> {
    if text.len() > LARGEST {
        let message = format!("a request has at most {} KiB", LARGEST >> 10);
        return Err(Problem::new(ProblemKind::TooLarge, message).hint("send a shorter text"));
    }
    serde_json::from_str(text).map_err(|error| {
        let message = visible::line(&format!("the request cannot be read: {error}")).into_owned();
        Problem::unreadable(message).hint("docs/guide/ros2.md describes the requests")
    })
}

/// Returns the id that a caller gave a request: a short text or a number; null for others.
pub(super) fn id_of(text: &str) -> Value {
    #[derive(Deserialize)]
    struct Named {
        #[serde(default)]
        id: Value,
    }
    if text.len() > LARGEST {
        return Value::Null;
    }
    match serde_json::from_str::<Named>(text).map(|named| named.id) {
        Ok(Value::String(id)) if id.chars().count() <= LONGEST_NAME => Value::String(id),
        Ok(Value::Number(id)) => Value::Number(id),
        _ => Value::Null,
    }
}

/// Returns the text of an answer.
pub(super) fn answer(id: Value, result: Result<Map<String, Value>, Problem>) -> String {
    let mut fields = Map::new();
    fields.insert("id".to_owned(), id);
    fields.insert("ok".to_owned(), json!(result.is_ok()));
    match result {
        Ok(more) => fields.extend(more),
        Err(problem) => {
            fields.insert("error".to_owned(), problem.to_json());
        }
    }
    Value::Object(fields).to_string()
}
