//! The trait that every model stands behind, and the options of one.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use longstep::dialogue::{ChatRequest, ConstraintKind, Reply, TokenCounter};

use crate::ModelError;

/// A language model that answers one request at a time, and counts tokens as it does.
pub trait ChatModel: TokenCounter {
    /// What to call it in reports: the catalogue name, the file's name, or the server's name
    /// for it.
    fn name(&self) -> &str;

    /// Which kind of constraint it obeys, which decides how it is asked.
    fn constraint_kind(&self) -> ConstraintKind;

    /// Answers a request. The same request gives the same answer from an embedded model.
    ///
    /// # Errors
    ///
    /// A [`ModelError`] that says what failed, or [`ModelError::Stopped`]; a refused or cut-off answer is not an error
    /// but a [`Finish`](longstep::dialogue::Finish).
    fn chat(&mut self, request: &ChatRequest, watch: &mut dyn Watch) -> Result<Reply, ModelError>;

    /// How many tokens prompt and answer may have together; none if nobody knows.
    fn context_tokens(&self) -> Option<u64>;
}

/// Whoever waits for a model: is told what it does, and may call it off.
///
/// Any `FnMut(Progress)` is one that never does.
pub trait Watch {
    /// Hears what the model is doing.
    fn tell(&mut self, progress: Progress);

    /// Whether the answer is not wanted any more. Asked at least ten times a second; the call then ends with
    /// [`ModelError::Stopped`], and the model can be asked again.
    fn stop(&self) -> bool {
        false
    }
}

impl<F: FnMut(Progress)> Watch for F {
    fn tell(&mut self, progress: Progress) {
        self(progress);
    }
}

/// What a model is doing, told while it does it.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Progress {
    /// The model's file is being loaded.
    Loading,
    /// The embedded engine reads the prompt.
    ReadingPrompt {
        /// Tokens in the cache or computed so far.
        done: usize,
        /// All tokens of the prompt.
        total: usize,
    },
    /// The model writes.
    Writing {
        /// Tokens written so far; from a server, pieces of the answer, which are a token or a few.
        tokens: usize,
    },
    /// A request has gone to a server.
    Waiting,
    /// Something went less well than it could, in one line; the answer is not affected.
    Warning(String),
}

/// A request to stop, shared by whoever makes it and whoever heeds it.
#[derive(Debug, Clone, Default)]
pub struct StopFlag(Arc<AtomicBool>);

impl StopFlag {
    /// Requests to stop, or takes the request back.
    pub fn set(&self, stop: bool) {
        self.0.store(stop, Ordering::Relaxed);
    }

    /// Returns whether a stop is requested.
    #[must_use]
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// The flag itself, for what takes one.
    #[must_use]
    pub fn atomic(&self) -> &AtomicBool {
        &self.0
    }
}

/// Two flags are equal if they are the same.
impl PartialEq for StopFlag {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// How a model is opened.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenOptions {
    /// Threads of the embedded engine; `None` takes the machine's physical cores.
    pub threads: Option<usize>,
    /// The folder for models and engine states, usually
    /// [`cache_directory`](crate::cache_directory).
    pub cache: PathBuf,
    /// How many tokens prompt and answer may have together. `None` takes 8192 for the embedded engine, whose memory
    /// grows with it (about 28 KB a token with the default model). A server that says how many it has is believed more
    /// than this.
    pub context_tokens: Option<u32>,
    /// How the next token is chosen.
    pub sampling: Sampling,
    /// How long a server may send nothing, before its answer and between the pieces of it; 60 s.
    pub silence: Duration,
    /// The time for one call of [`ChatModel::chat`] to a server, with all its tries; 600 s. Afterwards the call ends with
    /// [`ModelError::TimedOut`].
    pub timeout: Duration,
    /// Calls off what goes on with a server, also where no [`Watch`] looks on: the questions about the size of its
    /// context and about tokens.
    pub stop: StopFlag,
    /// A file that every request and reply is appended to, as `replay:FILE` reads it. It holds what was said, and no
    /// keys.
    pub record: Option<PathBuf>,
}

impl OpenOptions {
    /// The likeliest token always, nothing recorded, and as many threads as the machine has physical cores.
    #[must_use]
    pub fn new(cache: PathBuf) -> Self {
        Self {
            threads: None,
            cache,
            context_tokens: None,
            sampling: Sampling::default(),
            silence: Duration::from_secs(60),
            timeout: Duration::from_secs(600),
            stop: StopFlag::default(),
            record: None,
        }
    }
}

/// How the next token is chosen among the allowed ones. A server that does not take one of these is asked without it,
/// with a [`Progress::Warning`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sampling {
    /// 0 (the default) takes the likeliest token; above, less likely ones have a chance: 1 leaves the model's
    /// probabilities as they are, more evens them out. Negative or not a number counts as 0 for the embedded engine.
    pub temperature: f64,
    /// Only the likeliest tokens that together have this probability (0 to 1) are considered.
    pub top_p: Option<f64>,
    /// The same seed gives the same answer. `None` is 0 for the embedded engine, and leaves it to a server.
    pub seed: Option<u64>,
}
