//! The reason why a step or a goal is refused.

use std::fmt;

/// The reason why a step, or a goal, is outside of the levels and limits.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Refusal {
    /// The kind of the reason.
    pub kind: RefusalKind,
    /// The words of the file about the limit.
    pub says: Option<String>,
}

/// The kind of the reason of a [`Refusal`].
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum RefusalKind {
    /// The action is never performed.
    Never {
        /// The name of the action.
        action: String,
    },
    /// The place is forbidden.
    Place {
        /// The name of the place.
        name: String,
    },
    /// A value is outside of its range.
    Range {
        /// The name of the skill parameter, or the type of the value.
        name: String,
        /// The value with its unit.
        value: String,
        /// The range: `at most 0.25 m/s`.
        range: String,
    },
}

impl Refusal {
    pub(super) fn new(kind: RefusalKind, says: Option<&str>) -> Self {
        Self {
            kind,
            says: says.map(str::to_owned),
        }
    }
}

impl fmt::Display for Refusal {
    /// Writes the reason as a sentence, with the words of the file.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.kind {
            RefusalKind::Never { action } => write!(formatter, "`{action}` is never performed")?,
            RefusalKind::Place { name } => write!(formatter, "{name} is forbidden")?,
            RefusalKind::Range { name, value, range } => {
                write!(formatter, "`{name}` is {value}, and the limit is {range}")?;
            }
        }
        match &self.says {
            Some(says) => write!(formatter, " ({says})"),
            None => Ok(()),
        }
    }
}
