//! The result of one instruction, as a line of a file.
//!
//! An [`Attempt`] is one line of `results.jsonl` and depends on the requests and replies alone, so repeating a run
//! gives the same bytes. Values that depend on the machine are in a [`Timing`], in a separate file.

use longstep::dialogue::Reading;
use longstep::report::{EditAnswer, Status};
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// The key of an attempt, unique in a run.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Key {
    /// The case's id.
    pub case: String,
    /// Its step, from 0.
    pub step: usize,
    /// The wording of the instruction.
    pub wording: String,
    /// The trial, from 1.
    pub trial: u32,
}

/// The result of an instruction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Attempt {
    /// Its key.
    #[serde(flatten)]
    pub key: Key,
    /// The scene of its case.
    pub scene: String,
    /// The tags of its case.
    pub tags: Vec<String>,
    /// The instruction.
    pub says: String,
    /// The expected result.
    pub expected: Wanted,
    /// The actual result.
    pub outcome: Outcome,
    /// True if there is a plan whose steps are executable on every branch, without a broken rule.
    pub executable: bool,
    /// True if the result is the expected one. For a plan: one of the goals holds at each of its ends, and nothing else
    /// changed.
    pub correct: bool,
    /// Reasons why it is not correct, as sentences; empty if it is correct.
    pub why: Vec<String>,
    /// The kinds of failures, including those that feedback or repair corrected later.
    pub failures: Vec<Failure>,
    /// Number of rounds of feedback to the model.
    pub rounds: u32,
    /// The edits of repair.
    pub edits: Vec<Edit>,
    /// True if the environment that the model claims equals the simulated one; `None` without a claim.
    pub claim_right: Option<bool>,
    /// The goals of the model's answer, in everyday names (goal strategy).
    pub understood: Vec<String>,
    /// The clarifying question, if there is one.
    pub question: String,
    /// How the instruction was understood: the answers of the model that were weighed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub readings: Vec<Reading>,
    /// The model's replies, one a call.
    pub replies: Vec<String>,
    /// The feedback to the model between its replies.
    pub corrections: Vec<String>,
    /// The plan, one line a step.
    pub plan: Vec<PlanLine>,
    /// The violations of the plan, as sentences.
    pub violations: Vec<String>,
    /// Calls to the model.
    pub calls: u32,
    /// Tokens of all prompts.
    pub prompt_tokens: u64,
    /// Tokens of all answers.
    pub completion_tokens: u64,
}

impl Attempt {
    /// Returns true if the first reply is an executable plan, without feedback or repair.
    pub fn is_first_shot(&self) -> bool {
        self.executable && self.rounds == 0 && self.edits.is_empty()
    }

    /// Returns true if a plan was expected.
    pub fn wants_plan(&self) -> bool {
        matches!(self.expected, Wanted::Plan { .. })
    }

    /// Returns true if the result is a clarifying question.
    pub fn is_question(&self) -> bool {
        self.outcome == Outcome::Question
    }
}

/// An expected result, as results contain it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Wanted {
    /// A plan to one of these goals.
    Plan(Vec<String>),
    /// A clarifying question.
    Question,
    /// No plan.
    Refusal,
    /// A clarifying question, or no plan.
    Either,
    /// An empty plan, or a clarifying question.
    Nothing,
}

/// The kind of result of an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// A verified plan.
    Verified,
    /// A plan with violations.
    Invalid,
    /// A proof that there is no plan.
    Unsolvable,
    /// No plan was found within the limits.
    GaveUp,
    /// A clarifying question.
    Question,
    /// An unusable reply.
    Unusable,
    /// A prompt that does not fit into the model's context.
    Limit,
}

impl Outcome {
    /// The name in results.
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

/// An edit of repair.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Edit {
    /// `insert`, `drop`, `replace` or `move`.
    pub kind: String,
    /// Its place in the plan, from 0.
    pub at: usize,
    /// The call before, if there was one.
    pub before: Option<String>,
    /// The call after, if there is one.
    pub after: Option<String>,
    /// The reason, as a sentence.
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
#[non_exhaustive]
pub struct PlanLine {
    /// The step of the line, from 0; `None` for the head of a branch or loop.
    pub step: Option<usize>,
    /// Depth of the indentation.
    pub depth: usize,
    /// The call, or the head of a branch or loop.
    pub text: String,
    /// The step's explanation.
    pub explanation: String,
    /// The changes by the step on the first branch, as sentences.
    pub changes: Vec<String>,
}

/// Duration and cache use of an attempt.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Timing {
    /// The key of the attempt.
    #[serde(flatten)]
    pub key: Key,
    /// Prompt tokens from the prefix cache.
    pub cached_tokens: u64,
    /// Milliseconds in the model.
    pub model_ms: f64,
    /// Milliseconds from the instruction to the result.
    pub total_ms: f64,
}
