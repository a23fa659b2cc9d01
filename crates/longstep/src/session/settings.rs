//! How a session goes about it.

use serde::{Deserialize, Serialize};

use crate::dialogue::ConstraintKind;

/// What a model is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Strategy {
    /// Only what is wanted; search finds the steps. Few tokens, and what small models can do.
    #[default]
    Goal,
    /// The whole plan and the environment after it, as in the paper.
    Direct,
}

/// What happens to a plan of a model that is not valid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RepairPolicy {
    /// It is repaired; only what repair cannot mend goes back to the model.
    #[default]
    First,
    /// It goes back to the model, and is repaired when the rounds are used up.
    AfterFeedback,
    /// It goes back to the model and is never repaired.
    Never,
}

/// How a session goes about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// What a model is asked for.
    pub strategy: Strategy,
    /// What happens to a plan that is not valid.
    pub repair: RepairPolicy,
    /// How often a model is told what is wrong with its reply, for each instruction.
    pub rounds: u32,
    /// Whether verified plans are accepted without asking.
    pub accept: bool,
    /// How many earlier instructions a model is shown at most, with the plans that were accepted for them (direct
    /// strategy). What does not fit is dropped, oldest first.
    pub history: usize,
}

impl Default for Settings {
    /// The goal strategy, repair first, three rounds (the most that the paper needed), and two earlier instructions:
    /// enough for "put it back", and the same for the hundredth instruction as for the third.
    fn default() -> Self {
        Self {
            strategy: Strategy::default(),
            repair: RepairPolicy::default(),
            rounds: 3,
            accept: false,
            history: 2,
        }
    }
}

/// What a session has to know of the model that is asked.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelFacts {
    /// What it is called, for the log.
    pub name: String,
    /// What it obeys.
    pub kind: ConstraintKind,
    /// How many tokens prompt and answer may have together; none if nobody knows.
    pub context: Option<u64>,
}
