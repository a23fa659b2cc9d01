//! Sources of replies: a model that is opened for each trial, or recorded replies.

use std::collections::{BTreeMap, VecDeque};

use longstep::dialogue::{ChatRequest, ConstraintKind, Counting, EstimatedTokens, Message, Reply, TokenCounter, Usage};
use longstep_llm::{ChatModel, ModelError, Watch};
use serde::Deserialize;
use serde_json::Value;

/// A source of models for the trials of cases.
pub trait Source {
    /// The model for this trial of the case. Trials come in order; one model may serve all cases of a trial.
    ///
    /// # Errors
    ///
    /// When the model cannot be opened.
    fn model(&mut self, case: &str, trial: u32) -> Result<&mut dyn ChatModel, ModelError>;

    /// Limit for rounds of feedback, if the source has one: recorded replies are finite.
    fn rounds(&self, case: &str, trial: u32) -> Option<u32> {
        let _ = (case, trial);
        None
    }
}

/// Opens a model for a trial, which determines the seed.
pub type Opener = Box<dyn FnMut(u32) -> Result<Box<dyn ChatModel>, ModelError>>;

/// A model that is opened for each trial with its own seed.
pub struct Opened {
    open: Opener,
    current: Option<(u32, Box<dyn ChatModel>)>,
}

impl Opened {
    /// Opens nothing yet.
    pub fn new(open: Opener) -> Self {
        Self { open, current: None }
    }
}

impl Source for Opened {
    fn model(&mut self, _: &str, trial: u32) -> Result<&mut dyn ChatModel, ModelError> {
        // The old model is dropped first: two large models may not fit into memory.
        let kept = self.current.take().filter(|(of, _)| *of == trial);
        let model = match kept {
            Some(kept) => kept,
            None => (trial, (self.open)(trial)?),
        };
        Ok(self.current.insert(model).1.as_mut())
    }
}

/// Recorded replies, by case and trial, in the order of their rounds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Recorded {
    replies: BTreeMap<(String, u32), Vec<String>>,
    current: Script,
}

/// Reason why recorded replies cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordedError {
    /// The text is not a list of replies.
    #[error("not a list of recorded replies: {0}")]
    NoList(#[from] serde_json::Error),
    /// A reply is missing or exists twice.
    #[error("{entry}: {what}")]
    Entry {
        /// Number of the entry, from 1.
        entry: String,
        /// The reason.
        what: String,
    },
}

#[derive(Debug, Deserialize)]
struct Entry {
    #[serde(alias = "scenario")]
    case: Value,
    #[serde(default = "first")]
    trial: u32,
    #[serde(default)]
    round: u32,
    reply: Value,
}

fn first() -> u32 {
    1
}

impl Recorded {
    /// Reads a JSON array of `{"case": "1", "trial": 1, "round": 0, "reply": ...}`: the id of a case, or the number of
    /// a scenario as `scenario`; the trial from 1 (default 1); the round from 0 (default 0); and the model's reply, as
    /// text or as a JSON object.
    ///
    /// # Errors
    ///
    /// When the text is not such an array, or when a case lacks a round or has it twice.
    pub fn read(text: &str) -> Result<Self, RecordedError> {
        let entries: Vec<Entry> = serde_json::from_str(text)?;
        let mut replies: BTreeMap<(String, u32), Vec<String>> = BTreeMap::new();
        for (number, entry) in entries.into_iter().enumerate() {
            let word = |value: Value| match value {
                Value::String(text) => text,
                other => other.to_string(),
            };
            let case = word(entry.case);
            let known = replies.entry((case.clone(), entry.trial)).or_default();
            if known.len() != entry.round as usize {
                return Err(RecordedError::Entry {
                    entry: format!("entry {}", number + 1),
                    what: format!(
                        "round {} of case `{case}`, trial {}, comes where round {} should",
                        entry.round,
                        entry.trial,
                        known.len()
                    ),
                });
            }
            known.push(word(entry.reply));
        }
        Ok(Self {
            replies,
            current: Script::default(),
        })
    }

    /// The cases and trials with replies, in order.
    pub fn keys(&self) -> impl Iterator<Item = (&str, u32)> {
        self.replies.keys().map(|(case, trial)| (case.as_str(), *trial))
    }
}

impl Source for Recorded {
    fn model(&mut self, case: &str, trial: u32) -> Result<&mut dyn ChatModel, ModelError> {
        let replies = self.replies.get(&(case.to_owned(), trial)).cloned().unwrap_or_default();
        self.current = Script {
            replies: replies.into(),
            last: None,
        };
        Ok(&mut self.current)
    }

    fn rounds(&self, case: &str, trial: u32) -> Option<u32> {
        let replies = self.replies.get(&(case.to_owned(), trial));
        Some(replies.map_or(0, |replies| replies.len().saturating_sub(1) as u32))
    }
}

/// A model that gives prepared replies to any requests, and its last one again where that cannot be read.
#[derive(Debug, Clone, Default, PartialEq)]
struct Script {
    replies: VecDeque<String>,
    last: Option<String>,
}

impl TokenCounter for Script {
    fn message_tokens(&mut self, message: &Message) -> u64 {
        EstimatedTokens::default().message_tokens(message)
    }

    fn frame_tokens(&mut self) -> u64 {
        EstimatedTokens::default().frame_tokens()
    }

    fn counting(&self) -> Counting {
        EstimatedTokens::default().counting()
    }
}

impl ChatModel for Script {
    fn name(&self) -> &str {
        "recorded replies"
    }

    fn constraint_kind(&self) -> ConstraintKind {
        ConstraintKind::JsonSchema
    }

    fn chat(&mut self, _: &ChatRequest, _: &mut dyn Watch) -> Result<Reply, ModelError> {
        let Some(text) = self.replies.pop_front().or_else(|| self.last.clone()) else {
            return Err(ModelError::Unsupported {
                model: "recorded replies".to_owned(),
                reason: "there are no more of them".to_owned(),
            });
        };
        self.last = Some(text.clone());
        Ok(Reply {
            usage: Usage {
                calls: 1,
                ..Usage::default()
            },
            ..Reply::complete(text)
        })
    }

    fn context_tokens(&self) -> Option<u64> {
        None
    }
}
