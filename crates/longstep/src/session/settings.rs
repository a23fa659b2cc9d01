//! Settings of a session.

use serde::{Deserialize, Serialize};

use crate::dialogue::ConstraintKind;
use crate::search::Effort;

/// The planning strategy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Strategy {
    /// The model writes goals and search finds the steps. It needs few tokens and suits small models.
    #[default]
    Goal,
    /// The model writes the whole plan and the final environment, as in the paper.
    Direct,
}

/// Treatment of invalid plans from the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RepairPolicy {
    /// Repair first; the model gets feedback only on plans that repair cannot fix.
    #[default]
    First,
    /// Feedback first; repair after the last round.
    AfterFeedback,
    /// Feedback only.
    Never,
}

/// Settings of a session.
///
/// # Example
///
/// ```
/// use longstep::session::{Settings, Strategy};
/// let settings = Settings::default().with_strategy(Strategy::Direct).with_rounds(1);
/// assert_eq!((settings.rounds, settings.history, settings.accept), (1, 2, false));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct Settings {
    /// The planning strategy.
    pub strategy: Strategy,
    /// Treatment of invalid plans.
    pub repair: RepairPolicy,
    /// Maximum number of corrections sent to the model, for each instruction.
    pub rounds: u32,
    /// True to accept verified plans automatically.
    pub accept: bool,
    /// Maximum number of earlier instructions, with their accepted plans, in a prompt of the direct strategy. Those
    /// that exceed the token budget are dropped, oldest first.
    pub history: usize,
    /// Work of a search for a goal; none for the limits of the planner.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort: Option<Effort>,
    /// True if a plan that leaves out a part of the instruction is proposed like any other; otherwise it is a question
    /// ([`Response::Consent`](super::Response::Consent)).
    #[serde(default)]
    pub partial: bool,
}

impl Default for Settings {
    /// The goal strategy, repair first, three rounds (the most that the paper needed), and two earlier
    /// instructions.
    /// Two suffice for "put it back" and keep prompts at a constant length.
    fn default() -> Self {
        Self {
            strategy: Strategy::default(),
            repair: RepairPolicy::default(),
            rounds: 3,
            accept: false,
            history: 2,
            effort: None,
            partial: false,
        }
    }
}

impl Settings {
    /// Sets the planning strategy. See the [example](Self#example).
    #[must_use]
    pub fn with_strategy(self, strategy: Strategy) -> Self {
        Self { strategy, ..self }
    }

    /// Sets the treatment of invalid plans.
    #[must_use]
    pub fn with_repair(self, repair: RepairPolicy) -> Self {
        Self { repair, ..self }
    }

    /// Sets the maximum number of corrections sent to the model, for each instruction.
    #[must_use]
    pub fn with_rounds(self, rounds: u32) -> Self {
        Self { rounds, ..self }
    }

    /// Accepts verified plans automatically, or not.
    #[must_use]
    pub fn with_accept(self, accept: bool) -> Self {
        Self { accept, ..self }
    }

    /// Sets the maximum number of earlier instructions in a prompt of the direct strategy.
    #[must_use]
    pub fn with_history(self, history: usize) -> Self {
        Self { history, ..self }
    }

    /// Sets the work of a search for a goal; none for the limits of the planner.
    #[must_use]
    pub fn with_effort(self, effort: impl Into<Option<Effort>>) -> Self {
        Self {
            effort: effort.into(),
            ..self
        }
    }

    /// Proposes a plan that leaves out a part of the instruction like any other, or not.
    #[must_use]
    pub fn with_partial(self, partial: bool) -> Self {
        Self { partial, ..self }
    }
}

/// Properties of the model that a session depends on.
///
/// ```
/// use longstep::dialogue::ConstraintKind;
/// use longstep::session::ModelFacts;
/// let model = ModelFacts::new("mine", ConstraintKind::JsonSchema).with_context(8192);
/// assert_eq!(model.context, Some(8192));
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct ModelFacts {
    /// Name for the log.
    pub name: String,
    /// Kind of constraint that it supports.
    pub kind: ConstraintKind,
    /// Context length in tokens, for prompt and answer together, if known.
    pub context: Option<u64>,
}

impl ModelFacts {
    /// Describes a model with this name and kind of constraint, whose context length is not known.
    pub fn new(name: impl Into<String>, kind: ConstraintKind) -> Self {
        Self {
            name: name.into(),
            kind,
            context: None,
        }
    }

    /// Sets the context length in tokens, if it is known.
    #[must_use]
    pub fn with_context(self, context: impl Into<Option<u64>>) -> Self {
        Self {
            context: context.into(),
            ..self
        }
    }
}
