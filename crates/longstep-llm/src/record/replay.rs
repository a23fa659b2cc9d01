//! A model that answers only recorded requests.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use longstep::dialogue::{ChatRequest, ConstraintKind, Counting, EstimatedTokens, Message, Reply, TokenCounter};

use super::difference;
use super::line::Line;
use crate::wire::{VERSION, WireHead, WireMessage, WireReply, WireRequest};
use crate::{ChatModel, ModelError, Watch};
use longstep_files::{LOG_LIMIT, read_text_bounded};

/// A replayed recording.
#[derive(Debug)]
pub(crate) struct Replay {
    path: PathBuf,
    head: WireHead,
    turns: Vec<Turn>,
    /// By the recorded form of a message, which has the hashes of its pictures.
    counts: HashMap<WireMessage, u64>,
    frame: Option<u64>,
}

#[derive(Debug)]
struct Turn {
    request: WireRequest,
    reply: WireReply,
    given: bool,
}

impl Replay {
    /// Reads a recording.
    pub(crate) fn open(path: &Path) -> Result<Self, ModelError> {
        let text = read_text_bounded(path, LOG_LIMIT).map_err(ModelError::file("cannot replay", path))?;
        let bad = |line: usize, reason: String| ModelError::BadRecording {
            path: path.to_path_buf(),
            line: line + 1,
            reason,
        };
        let (mut head, mut turns) = (None, Vec::new());
        let (mut counts, mut frame) = (HashMap::new(), None);
        for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
            match serde_json::from_str(line).map_err(|error| bad(number, error.to_string()))? {
                Line::Recording(recording) if recording.version != VERSION => {
                    let version = recording.version;
                    return Err(bad(
                        number,
                        format!("version {version} is not supported, only {VERSION}"),
                    ));
                }
                Line::Recording(recording) => {
                    head.get_or_insert(recording);
                }
                Line::Turn { request, reply } => turns.push(Turn {
                    request,
                    reply,
                    given: false,
                }),
                Line::Count(count) => {
                    counts.entry(count.message).or_insert(count.tokens);
                }
                Line::Frame(tokens) => {
                    frame.get_or_insert(tokens);
                }
            }
        }
        Ok(Self {
            path: path.to_path_buf(),
            head: head.ok_or_else(|| bad(0, "the first line with the model is missing".into()))?,
            turns,
            counts,
            frame,
        })
    }
}

impl ChatModel for Replay {
    fn name(&self) -> &str {
        &self.head.name
    }

    fn constraint_kind(&self) -> ConstraintKind {
        self.head.kind()
    }

    fn chat(&mut self, request: &ChatRequest, watch: &mut dyn Watch) -> Result<Reply, ModelError> {
        if watch.stop() {
            return Err(ModelError::Stopped);
        }
        let requested = WireRequest::of(request);
        let mut equal = self.turns.iter_mut().filter(|turn| turn.request == requested);
        if let Some(turn) = equal.find(|turn| !turn.given) {
            turn.given = true;
            return Ok((&turn.reply).into());
        }
        let times = self.turns.iter().filter(|turn| turn.request == requested).count();
        let recorded = self.turns.iter().map(|turn| &turn.request);
        let difference = match times {
            0 => difference::nearest(&requested, recorded),
            1 => "it was recorded once and already used".to_owned(),
            _ => format!("it was recorded {times} times and already used as often"),
        };
        Err(ModelError::NotRecorded {
            path: self.path.clone(),
            difference,
        })
    }

    fn context_tokens(&self) -> Option<u64> {
        self.head.context_tokens
    }
}

impl TokenCounter for Replay {
    /// The recorded count, or an estimate for a message that was not counted.
    fn message_tokens(&mut self, message: &Message) -> u64 {
        let known = self.counts.get(&WireMessage::from(message)).copied();
        known.unwrap_or_else(|| EstimatedTokens::default().message_tokens(message))
    }

    fn frame_tokens(&mut self) -> u64 {
        self.frame.unwrap_or_else(|| EstimatedTokens::default().frame_tokens())
    }

    fn counting(&self) -> Counting {
        self.head.counting()
    }
}
