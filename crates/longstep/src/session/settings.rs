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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
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

/// Properties of the model that a session depends on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelFacts {
    /// Name for the log.
    pub name: String,
    /// Kind of constraint that it supports.
    pub kind: ConstraintKind,
    /// Context length in tokens, for prompt and answer together, if known.
    pub context: Option<u64>,
}
