//! The events of a session.
//!
//! An event is one line of JSON in the log. Events are a wire format: new versions read old logs, so fields are added
//! and never renamed. A change that older programs cannot read raises [`VERSION`].

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::Settings;
use crate::dialogue::{Likelihood, Message, Reading, Role, Usage};
use crate::environment::Environment;
use crate::plan::PlanFile;
use longstep_core::environment::Observation;

/// The version of logs that this library writes, and the newest that it reads.
pub const VERSION: u32 = 5;

/// An event of a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Event {
    /// The session starts.
    Begin {
        /// Version of the log.
        version: u32,
        /// Name or folder of the domain.
        domain: String,
        /// The initial environment.
        environment: Box<Environment>,
        /// The initial settings.
        settings: Settings,
    },
    /// The model for the following requests.
    Model {
        /// Its name.
        name: String,
        /// True if it supports JSON schemas; false for a grammar.
        schema: bool,
        /// Context length in tokens, for prompt and answer together, if known.
        context: Option<u64>,
    },
    /// The settings for the following inputs.
    Settings(Settings),
    /// A standing rule is put in force.
    Rule {
        /// The rule in the goal language, with identifiers of the environment.
        text: String,
    },
    /// A standing rule is lifted.
    Lifted {
        /// Its number, from 0, among the rules in force.
        number: usize,
    },
    /// An instruction of the person.
    Instruction {
        /// Its text.
        text: String,
    },
    /// A fixed prompt part. Requests refer to it by number.
    Prompt {
        /// Its number.
        number: usize,
        /// Its messages.
        messages: Vec<MessageRecord>,
    },
    /// A request to the model.
    Request {
        /// Number of its fixed part.
        prompt: usize,
        /// The messages after the fixed part.
        messages: Vec<MessageRecord>,
        /// Start of the answer, which the reply continues.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        answer_so_far: String,
        /// Token budget of the reply.
        max_tokens: u32,
        /// Number of dropped exchanges of the history.
        #[serde(default, skip_serializing_if = "is_zero")]
        dropped: usize,
        /// Number of entities that the prompt omits.
        #[serde(default, skip_serializing_if = "is_zero")]
        left_out: usize,
    },
    /// The entities in the following prompts, since the whole world does not fit.
    Focus {
        /// Their identifiers.
        kept: Vec<String>,
    },
    /// A reply of the model.
    Reply {
        /// Its text, unchanged.
        text: String,
        /// Reason why generation ended: `stop`, `length` or `refused`.
        finish: String,
        /// Token counts.
        usage: UsageRecord,
        /// The likelihood of the text, if the model gives it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        likelihood: Option<Likelihood>,
        /// Duration in milliseconds.
        milliseconds: f64,
    },
    /// A model call failed.
    Failed {
        /// The reason.
        error: String,
    },
    /// The verdict on a plan, as the JSON object of `longstep plan --json`.
    Verdict {
        /// The answer with its edits and violations.
        answer: Value,
    },
    /// Feedback to the model on its plan or reply, before its next attempt.
    Correction {
        /// Its text.
        text: String,
    },
    /// A question to the person.
    Question {
        /// Its text.
        text: String,
        /// The readings that led to it.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        readings: Vec<Reading>,
    },
    /// The person's answer to a question.
    Answer {
        /// Its text.
        text: String,
    },
    /// The person's feedback on a plan.
    Feedback {
        /// Its text.
        text: String,
    },
    /// The feedback is impossible to fulfil.
    Refused {
        /// The reasons, as sentences.
        why: Vec<String>,
    },
    /// The instruction led to no plan.
    Stuck {
        /// The reason.
        why: String,
    },
    /// A verified plan is accepted. The next instruction starts in its final world.
    Accept {
        /// Number of the plan, from 0.
        number: usize,
        /// The instruction.
        instruction: String,
        /// Goal of the plan, with identifiers of the environment; empty if it has none.
        goal: Vec<String>,
        /// Its steps with all arguments.
        steps: Vec<StepRecord>,
        /// The plan in the paper's JSON, with the simulated environment.
        plan: Box<PlanFile>,
    },
    /// The ending of the last accepted plan, if it has several.
    Ended {
        /// Index of the ending, from 0.
        number: usize,
        /// The environment after it.
        environment: Box<Environment>,
    },
    /// The world was observed between two instructions.
    Observed {
        /// The statements.
        statements: Observation,
        /// The differences from the expected world, as sentences.
        changes: Vec<String>,
    },
    /// A robot carried out an accepted plan.
    CarriedOut {
        /// Its number.
        number: usize,
        /// True if the plan's goal was reached in the observed world.
        reached: bool,
        /// The statements about the world at the end.
        statements: Observation,
        /// The differences from the expected world, as sentences.
        changes: Vec<String>,
    },
    /// The last accepted plan is reverted.
    Undo {
        /// Its number.
        number: usize,
    },
    /// The current activity is cancelled: feedback or the instruction.
    Cancel,
}

impl Event {
    /// Returns true for an event that a crash of the machine must not lose: it is flushed to the disk before the session
    /// continues.
    ///
    /// ```
    /// use longstep::session::Event;
    /// assert!(Event::Undo { number: 0 }.is_lasting() && !Event::Cancel.is_lasting());
    /// ```
    pub fn is_lasting(&self) -> bool {
        matches!(
            self,
            Self::Begin { .. }
                | Self::Accept { .. }
                | Self::Undo { .. }
                | Self::Rule { .. }
                | Self::Lifted { .. }
                | Self::Ended { .. }
                | Self::Observed { .. }
                | Self::CarriedOut { .. }
        )
    }
}

/// A message of a conversation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MessageRecord {
    /// `system`, `user` or `assistant`.
    pub role: String,
    /// Its text.
    pub text: String,
}

impl From<&Message> for MessageRecord {
    fn from(message: &Message) -> Self {
        let role = match message.role {
            Role::System => "system",
            Role::User => "user",
            Role::Assistant => "assistant",
        };
        Self {
            role: role.to_owned(),
            text: message.text.clone(),
        }
    }
}

/// Token counts of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct UsageRecord {
    /// Prompt tokens.
    pub prompt_tokens: u64,
    /// Prompt tokens that came from the prefix cache.
    pub cached_tokens: u64,
    /// Generated tokens.
    pub completion_tokens: u64,
}

impl From<Usage> for UsageRecord {
    fn from(usage: Usage) -> Self {
        Self {
            prompt_tokens: usage.prompt_tokens,
            cached_tokens: usage.cached_tokens,
            completion_tokens: usage.completion_tokens,
        }
    }
}

impl From<UsageRecord> for Usage {
    fn from(record: UsageRecord) -> Self {
        Self {
            calls: 1,
            prompt_tokens: record.prompt_tokens,
            cached_tokens: record.cached_tokens,
            completion_tokens: record.completion_tokens,
        }
    }
}

/// A step with all arguments.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StepRecord {
    /// Name of the action in the PDDL.
    pub action: String,
    /// One identifier for each parameter of the action.
    pub arguments: Vec<String>,
    /// Description of the step.
    pub explanation: String,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(number: &usize) -> bool {
    *number == 0
}
