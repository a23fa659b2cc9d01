//! Errors of the library as exceptions of Python, with their hints.

use crate::interpreter::attach;
use longstep_core::diagnostic::Diagnostics;
use longstep_core::goal::GoalError;
use longstep_files::{DomainError, TextFileError};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The class of an exception in `longstep._errors`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FailureKind {
    /// A call that does not fit, or work that failed.
    Failed,
    /// An input that cannot be read.
    Unreadable,
    /// An invalid plan.
    NotValid,
    /// A proof that no plan exists.
    Unsolvable,
    /// No plan within the limits.
    GaveUp,
    /// A question to the person.
    Question,
}

impl FailureKind {
    fn class(self) -> &'static str {
        match self {
            Self::Failed => "LongstepError",
            Self::Unreadable => "Unreadable",
            Self::NotValid => "NotValid",
            Self::Unsolvable => "Unsolvable",
            Self::GaveUp => "GaveUp",
            Self::Question => "Question",
        }
    }
}

/// A failure: the message, the next step for the user, and the answer if there is one.
#[derive(Debug)]
pub(crate) struct Failure {
    kind: FailureKind,
    message: String,
    hint: Option<String>,
    answer: Option<Py<PyAny>>,
}

impl Failure {
    pub(crate) fn new(kind: FailureKind, message: impl Into<String>) -> Self {
        Self {
            kind,
            message: message.into(),
            hint: None,
            answer: None,
        }
    }

    /// Returns the failure to do what was asked for.
    pub(crate) fn failed(message: impl Into<String>) -> Self {
        Self::new(FailureKind::Failed, message)
    }

    /// Returns the failure of an input that cannot be read.
    pub(crate) fn unreadable(message: impl Into<String>) -> Self {
        Self::new(FailureKind::Unreadable, message)
    }

    /// Adds the next step for the user.
    pub(crate) fn hint(self, hint: impl Into<Option<String>>) -> Self {
        Self {
            hint: hint.into(),
            ..self
        }
    }

    /// Adds the answer that says why.
    pub(crate) fn answer(self, answer: Py<PyAny>) -> Self {
        Self {
            answer: Some(answer),
            ..self
        }
    }

    fn exception(&self, py: Python<'_>) -> PyResult<PyErr> {
        let options = PyDict::new(py);
        options.set_item("hint", &self.hint)?;
        options.set_item("answer", self.answer.as_ref().map(|answer| answer.clone_ref(py)))?;
        let class = py.import("longstep._errors")?.getattr(self.kind.class())?;
        Ok(PyErr::from_value(class.call((&self.message,), Some(&options))?))
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        attach(|py| {
            let exception = failure.exception(py);
            // Only a damaged installation lacks the classes.
            exception.unwrap_or_else(|_| PyRuntimeError::new_err(failure.message.clone()))
        })
    }
}

impl From<Diagnostics> for Failure {
    fn from(findings: Diagnostics) -> Self {
        let hint = match &findings.0[..] {
            [only] => only.hint.clone(),
            _ => None,
        };
        Self::unreadable(findings.to_string()).hint(hint)
    }
}

impl From<DomainError> for Failure {
    fn from(error: DomainError) -> Self {
        Self::unreadable(error.to_string()).hint(error.hint())
    }
}

impl From<TextFileError> for Failure {
    fn from(error: TextFileError) -> Self {
        Self::unreadable(error.to_string()).hint(error.hint().map(str::to_owned))
    }
}

impl From<GoalError> for Failure {
    fn from(error: GoalError) -> Self {
        let hint = match error {
            GoalError::UnknownName { .. } | GoalError::UnknownKind { .. } => {
                Some("`World.entities` has the names of an environment")
            }
            GoalError::UnknownWord { .. } | GoalError::WrongType { .. } => Some("`Domain.goals` lists the goals"),
            GoalError::Empty => Some("write a goal on each side of every `&` and every `then`"),
            GoalError::NeverHolds { .. } => Some("leave the rule out, or check the names in it"),
            _ => None,
        };
        Self::unreadable(error.to_string()).hint(hint.map(str::to_owned))
    }
}
