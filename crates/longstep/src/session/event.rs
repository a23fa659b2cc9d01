//! What happens in a session, as it is written down.
//!
//! One event is one line of JSON. Events are a wire format of their own: the log of today is read by the program of
//! tomorrow, so fields are added, never renamed, and a change that older programs cannot read raises [`VERSION`].

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::Settings;
use crate::dialogue::{Message, Role, Usage};
use crate::environment::Environment;
use crate::plan::PlanFile;

/// The version of the log that this library writes, and the newest that it reads.
pub const VERSION: u32 = 1;

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// The session begins: everything that it depends on.
    Begin {
        /// Of the log.
        version: u32,
        /// The domain's name, or its folder.
        domain: String,
        /// The first environment.
        environment: Box<Environment>,
        /// How the session goes about it.
        settings: Settings,
    },
    /// From now on this model is asked.
    Model {
        /// What it is called.
        name: String,
        /// Whether it takes a JSON schema; else it obeys a grammar.
        schema: bool,
        /// How many tokens prompt and answer may have together, if that is known.
        context: Option<u64>,
    },
    /// From now on the session goes about it in another way.
    Settings(Settings),
    /// A person says what is wanted.
    Instruction {
        /// In these words.
        text: String,
    },
    /// The fixed part of requests to come, which is not repeated in each of them.
    Prompt {
        /// Requests refer to it by this number.
        number: usize,
        /// Its turns.
        messages: Vec<MessageRecord>,
    },
    /// A model is asked.
    Request {
        /// The fixed part.
        prompt: usize,
        /// The turns behind it.
        messages: Vec<MessageRecord>,
        /// How the answer begins already.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        answer_so_far: String,
        /// At most so many tokens are wanted.
        max_tokens: u32,
        /// Pairs of earlier instructions that did not fit.
        #[serde(default, skip_serializing_if = "is_zero")]
        dropped: usize,
        /// Things of the environment that the model was not told of.
        #[serde(default, skip_serializing_if = "is_zero")]
        left_out: usize,
    },
    /// The model is told of these things only, since more do not fit.
    Focus {
        /// Their identifiers.
        kept: Vec<String>,
    },
    /// The model answers.
    Reply {
        /// Its words, as they came.
        text: String,
        /// Why it ended: `stop`, `length` or `refused`.
        finish: String,
        /// What it cost, in tokens.
        usage: UsageRecord,
        /// How long it took, in milliseconds.
        milliseconds: f64,
    },
    /// The model was asked and did not answer.
    Failed {
        /// Why.
        error: String,
    },
    /// A plan was looked at; programs know this object from `longstep plan --json`.
    Verdict {
        /// The answer, edits and violations included.
        answer: Value,
    },
    /// What a model is told about its plan or its reply before it tries again.
    Correction {
        /// In these words.
        text: String,
    },
    /// The person is asked.
    Question {
        /// In these words.
        text: String,
    },
    /// The person answers a question.
    Answer {
        /// In these words.
        text: String,
    },
    /// The person says what is to be different about a plan.
    Feedback {
        /// In these words.
        text: String,
    },
    /// What the person asked for cannot be had.
    Refused {
        /// Why, as sentences.
        why: Vec<String>,
    },
    /// Nothing came of the instruction.
    Stuck {
        /// Why.
        why: String,
    },
    /// A verified plan is accepted: what comes next begins where it ends.
    Accept {
        /// From 0.
        number: usize,
        /// What was asked for.
        instruction: String,
        /// The goal that it was made for, with the environment's identifiers; empty if it was made for none.
        goal: Vec<String>,
        /// Its steps with every argument.
        steps: Vec<StepRecord>,
        /// The plan in the paper's JSON, with the simulated environment.
        plan: Box<PlanFile>,
    },
    /// It is told how the plan ended that was accepted last, where it can end in several ways.
    Ended {
        /// Which of its endings, from 0.
        number: usize,
        /// The environment that it left.
        environment: Box<Environment>,
    },
    /// The last accepted plan is taken back.
    Undo {
        /// Its number.
        number: usize,
    },
    /// The instruction at hand is given up.
    Cancel,
}

/// A turn of a conversation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MessageRecord {
    /// `system`, `user` or `assistant`.
    pub role: String,
    /// What is said.
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

/// What a call cost, in tokens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct UsageRecord {
    /// Of the prompt.
    pub prompt_tokens: u64,
    /// Of those, how many needed no computation.
    pub cached_tokens: u64,
    /// Of the answer.
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

/// A step with everything that the call syntax hides.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct StepRecord {
    /// The action's name in the PDDL.
    pub action: String,
    /// One identifier for each of its parameters.
    pub arguments: Vec<String>,
    /// What it does.
    pub explanation: String,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(number: &usize) -> bool {
    *number == 0
}
