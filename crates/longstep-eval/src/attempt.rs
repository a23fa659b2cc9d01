//! What came of one instruction, as it is written down.
//!
//! An [`Attempt`] is one line of `results.jsonl` and depends on nothing but what was asked and what was answered, so the
//! same run writes the same bytes. What the machine had to do with it is a [`Timing`], in a file of its own.

use longstep::report::{EditAnswer, Status};
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// Which attempt it is: unlike every other of a run.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Key {
    /// The case's id.
    pub case: String,
    /// Its step, from 0.
    pub step: usize,
    /// In which words it was asked.
    pub wording: String,
    /// From 1.
    pub trial: u32,
}

/// What came of an instruction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Attempt {
    /// Which one it is.
    #[serde(flatten)]
    pub key: Key,
    /// The scene of its case.
    pub scene: String,
    /// The tags of its case.
    pub tags: Vec<String>,
    /// The instruction.
    pub says: String,
    /// What was expected.
    pub expected: Wanted,
    /// What it came to.
    pub outcome: Outcome,
    /// Whether there is a plan of which every step can be done, on every way through it, and no rule is broken.
    pub executable: bool,
    /// Whether what was expected came of it; of a plan, that a goal holds wherever it can end and that nothing else
    /// changed.
    pub correct: bool,
    /// Why it is not correct, in sentences; empty if it is.
    pub why: Vec<String>,
    /// What went wrong, by kind, even if it was mended later.
    pub failures: Vec<Failure>,
    /// How often the model was told what was wrong.
    pub rounds: u32,
    /// What repair changed.
    pub edits: Vec<Edit>,
    /// Whether the environment that the model claimed is the simulated one; none if it claimed none.
    pub claim_right: Option<bool>,
    /// The goals that were understood, in everyday names (goal strategy).
    pub understood: Vec<String>,
    /// The question back, if there is one.
    pub question: String,
    /// What the model wrote, call by call.
    pub replies: Vec<String>,
    /// What it was told in between.
    pub corrections: Vec<String>,
    /// The plan, line by line.
    pub plan: Vec<PlanLine>,
    /// What is wrong with the plan, in sentences.
    pub violations: Vec<String>,
    /// Calls to the model.
    pub calls: u32,
    /// Tokens of all prompts.
    pub prompt_tokens: u64,
    /// Tokens of all answers.
    pub completion_tokens: u64,
}

impl Attempt {
    /// Whether the model's first word was enough: a plan without a round or an edit.
    pub fn is_first_shot(&self) -> bool {
        self.executable && self.rounds == 0 && self.edits.is_empty()
    }

    /// Whether a plan was expected.
    pub fn wants_plan(&self) -> bool {
        matches!(self.expected, Wanted::Plan { .. })
    }

    /// Whether a question was asked.
    pub fn asked(&self) -> bool {
        self.outcome == Outcome::Question
    }
}

/// What was expected, as it is written down.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Wanted {
    /// A plan to one of these goals.
    Plan(Vec<String>),
    /// A question back.
    Question,
    /// No plan.
    Refusal,
    /// A question back or no plan.
    Either,
}

/// What an instruction came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// A verified plan.
    Verified,
    /// A plan with something wrong in it.
    Invalid,
    /// It was proven that there is no plan.
    Unsolvable,
    /// No plan was found within the limits.
    GaveUp,
    /// A question back.
    Question,
    /// A reply that could not be used.
    Unusable,
    /// What had to be said did not fit into the model.
    Limit,
}

impl Outcome {
    /// As results name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Verified => "verified",
            Self::Invalid => "invalid",
            Self::Unsolvable => "unsolvable",
            Self::GaveUp => "gave_up",
            Self::Question => "question",
            Self::Unusable => "unusable",
            Self::Limit => "limit",
        }
    }
}

impl From<Status> for Outcome {
    fn from(status: Status) -> Self {
        match status {
            Status::Verified => Self::Verified,
            Status::Invalid => Self::Invalid,
            Status::Unsolvable => Self::Unsolvable,
            Status::GaveUp => Self::GaveUp,
            Status::Question => Self::Question,
        }
    }
}

/// A change that repair made.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Edit {
    /// `insert`, `drop`, `replace` or `move`.
    pub kind: String,
    /// Where it shows in the plan, from 0.
    pub at: usize,
    /// The call before, if there was one.
    pub before: Option<String>,
    /// The call after, if there is one.
    pub after: Option<String>,
    /// Why, in a sentence.
    pub why: String,
}

impl From<&EditAnswer> for Edit {
    fn from(edit: &EditAnswer) -> Self {
        Self {
            kind: edit.kind.to_owned(),
            at: edit.at,
            before: edit.before.clone(),
            after: edit.after.clone(),
            why: edit.why.clone(),
        }
    }
}

/// A line of a plan.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlanLine {
    /// The step that it shows, from 0; none for what only leads others.
    pub step: Option<usize>,
    /// How deep it is indented.
    pub depth: usize,
    /// The call, or what leads others.
    pub text: String,
    /// What it does.
    pub explanation: String,
    /// What became so by it, as sentences, on the first way through the plan.
    pub changes: Vec<String>,
}

/// What an attempt took.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Which attempt it is.
    #[serde(flatten)]
    pub key: Key,
    /// Tokens of the prompts that needed no computation.
    pub cached_tokens: u64,
    /// Milliseconds in which the model was at work.
    pub model_ms: f64,
    /// From the instruction to what came of it, in milliseconds.
    pub total_ms: f64,
}
