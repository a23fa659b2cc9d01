//! The reason why a request is not fulfilled.

use longstep::ErrorKind;
use longstep::session::{ObserveError, OutOfTurn, ResumeError};
use longstep_core::secret;
use longstep_files::DomainError;
use longstep_llm::{AdvanceError, ModelError};
use longstep_robot::{OpenError, Unfit};
use serde_json::{Value, json};

use crate::store::StoreError;

/// The kind of a problem.
///
/// Exhaustive on purpose: every face has an answer of its own for each kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProblemKind {
    /// The request cannot be read, or asks for something that cannot be.
    Unreadable,
    /// Nobody has shown who they are.
    Unknown,
    /// It is not allowed.
    Forbidden,
    /// There is no such object.
    Missing,
    /// The object is not in the state that the request needs.
    Conflict,
    /// It is too large.
    TooLarge,
    /// Too much waits already.
    Busy,
    /// The model or the robot failed.
    Failed,
    /// The server failed.
    Internal,
}

impl ProblemKind {
    /// Returns the name of the kind in messages to programs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unreadable => "unreadable",
            Self::Unknown => "unauthorized",
            Self::Forbidden => "forbidden",
            Self::Missing => "missing",
            Self::Conflict => "conflict",
            Self::TooLarge => "too_large",
            Self::Busy => "busy",
            Self::Failed => "failed",
            Self::Internal => "internal",
        }
    }
}

/// The reason why a request is not fulfilled: a line for a person, and the next step. It has no passwords or keys.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
#[non_exhaustive]
pub struct Problem {
    /// The kind.
    pub kind: ProblemKind,
    /// The reason in one line.
    pub message: String,
    /// The next step.
    pub hint: Option<String>,
}

impl Problem {
    /// Creates a problem. Passwords and keys are removed from the message.
    pub fn new(kind: ProblemKind, message: impl AsRef<str>) -> Self {
        Self {
            kind,
            message: secret::redacted(message.as_ref()).into_owned(),
            hint: None,
        }
    }

    /// Sets the next step.
    #[must_use]
    pub fn hint(self, hint: impl AsRef<str>) -> Self {
        Self {
            hint: Some(secret::redacted(hint.as_ref()).into_owned()),
            ..self
        }
    }

    /// Returns the problem as JSON.
    pub(crate) fn to_json(&self) -> Value {
        json!({"kind": self.kind.name(), "message": self.message, "hint": self.hint})
    }

    fn hinted(self, hint: Option<String>) -> Self {
        match hint {
            Some(hint) => self.hint(hint),
            None => self,
        }
    }

    pub(crate) fn unreadable(message: impl AsRef<str>) -> Self {
        Self::new(ProblemKind::Unreadable, message)
    }

    pub(crate) fn conflict(message: impl AsRef<str>) -> Self {
        Self::new(ProblemKind::Conflict, message)
    }

    pub(crate) fn missing(what: &str, id: impl std::fmt::Display) -> Self {
        Self::new(ProblemKind::Missing, format!("there is no {what} `{id}`"))
    }
}

impl From<OutOfTurn> for Problem {
    fn from(error: OutOfTurn) -> Self {
        Self::conflict(error.to_string())
    }
}

impl From<ObserveError> for Problem {
    fn from(error: ObserveError) -> Self {
        match error {
            ObserveError::OutOfTurn(error) => error.into(),
            error => Self::unreadable(error.to_string()),
        }
    }
}

impl From<StoreError> for Problem {
    fn from(error: StoreError) -> Self {
        let (kind, hint) = match &error {
            StoreError::Open(_) => (ProblemKind::Conflict, None),
            StoreError::Taken(_) => (ProblemKind::Busy, Some("try again in some seconds")),
            StoreError::Lost(_) => (ProblemKind::Busy, Some("look at it again; nothing was changed")),
            StoreError::TooLarge(_) => (ProblemKind::TooLarge, None),
            StoreError::File { .. } | StoreError::Database { .. } => (ProblemKind::Internal, None),
        };
        Self::new(kind, error.to_string()).hinted(hint.map(str::to_owned))
    }
}

impl From<DomainError> for Problem {
    fn from(error: DomainError) -> Self {
        Self::unreadable(error.to_string()).hinted(error.hint())
    }
}

impl From<ResumeError> for Problem {
    fn from(error: ResumeError) -> Self {
        Self::conflict(error.to_string())
    }
}

impl From<longstep::Error> for Problem {
    fn from(error: longstep::Error) -> Self {
        let kind = match error.kind() {
            ErrorKind::GaveUp | ErrorKind::Unsolvable | ErrorKind::Invalid => ProblemKind::Conflict,
            _ => ProblemKind::Unreadable,
        };
        Self::new(kind, error.to_string())
    }
}

impl From<ModelError> for Problem {
    fn from(error: ModelError) -> Self {
        let hint = error.hint();
        Self::new(ProblemKind::Failed, error.to_string()).hinted(hint)
    }
}

impl From<AdvanceError> for Problem {
    fn from(error: AdvanceError) -> Self {
        match error {
            AdvanceError::Model(error) => error.into(),
            AdvanceError::OutOfTurn(error) => error.into(),
            error => Self::new(ProblemKind::Failed, error.to_string()),
        }
    }
}

impl From<OpenError> for Problem {
    fn from(error: OpenError) -> Self {
        let hint = error.hint().map(str::to_owned);
        Self::new(ProblemKind::Failed, error.to_string()).hinted(hint)
    }
}

impl From<Unfit> for Problem {
    fn from(error: Unfit) -> Self {
        let hint = error.hint().map(str::to_owned);
        Self::conflict(error.to_string()).hinted(hint)
    }
}

impl From<getrandom::Error> for Problem {
    fn from(error: getrandom::Error) -> Self {
        Self::new(ProblemKind::Internal, format!("there are no random numbers: {error}"))
    }
}
