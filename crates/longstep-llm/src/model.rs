//! The trait of all models, and the options for opening one.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use longstep::dialogue::{ChatRequest, ConstraintKind, Forecast, Reply, TokenCounter};
use longstep::session::ModelFacts;

use crate::{ModelError, Reasoning};

/// A language model that answers one request at a time, and counts tokens for itself.
pub trait ChatModel: TokenCounter {
    /// The name in reports: the catalogue name, the file name, or the name on the server.
    fn name(&self) -> &str;

    /// The kind of constraint it supports, which decides the form of requests.
    fn constraint_kind(&self) -> ConstraintKind;

    /// Answers a request. An embedded model gives equal answers to equal requests.
    ///
    /// # Errors
    ///
    /// A [`ModelError`] with the cause, or [`ModelError::Stopped`]. A refused or truncated answer is not an error but a
    /// [`Finish`](longstep::dialogue::Finish).
    fn chat(&mut self, request: &ChatRequest, watch: &mut dyn Watch) -> Result<Reply, ModelError>;

    /// Tokens of prompt and answer together; `None` if unknown.
    fn context_tokens(&self) -> Option<u64>;

    /// The facts about the model that a session depends on.
    fn facts(&self) -> ModelFacts {
        ModelFacts::new(self.name(), self.constraint_kind()).with_context(self.context_tokens())
    }
}

/// An observer of a model call: it receives progress and may cancel the call.
///
/// Any `FnMut(Progress)` is an observer that never cancels.
pub trait Watch {
    /// Receives progress.
    fn tell(&mut self, progress: Progress);

    /// Returns true to cancel the call. Called at least ten times a second; the call then ends with
    /// [`ModelError::Stopped`], and the model accepts further requests.
    fn stop(&self) -> bool {
        false
    }
}

impl<F: FnMut(Progress)> Watch for F {
    fn tell(&mut self, progress: Progress) {
        self(progress);
    }
}

/// Progress of a model call.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Progress {
    /// The model's file is being loaded.
    Loading,
    /// A request for a whole plan follows, with these tokens.
    Forecast(Forecast),
    /// The embedded engine reads the prompt.
    ReadingPrompt {
        /// Tokens from the cache or computed so far.
        done: usize,
        /// Tokens of the whole prompt.
        total: usize,
    },
    /// The model generates the answer.
    Writing {
        /// Tokens generated so far. For a server, the number of received pieces, each of one token or a few.
        tokens: usize,
    },
    /// The request was sent to a server.
    Waiting,
    /// The answer is complete.
    Answered,
    /// A problem that does not affect the answer, in one line.
    Warning(String),
}

/// A shared flag that requests a stop.
#[derive(Debug, Clone, Default)]
pub struct StopFlag(Arc<AtomicBool>);

impl StopFlag {
    /// Requests a stop, or withdraws the request.
    pub fn set(&self, stop: bool) {
        self.0.store(stop, Ordering::Relaxed);
    }

    /// Returns whether a stop is requested.
    #[must_use]
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// The underlying atomic flag.
    #[must_use]
    pub fn atomic(&self) -> &AtomicBool {
        &self.0
    }
}

/// Flags are equal if they share one value.
impl PartialEq for StopFlag {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// Options for opening a model.
///
/// ```
/// use longstep_llm::{OpenOptions, Sampling};
/// let options = OpenOptions::new("cache".into()).with_threads(2).with_sampling(Sampling::default().with_seed(7));
/// assert_eq!((options.threads, options.sampling.seed), (Some(2), Some(7)));
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct OpenOptions {
    /// Threads of the embedded engine; `None` takes the machine's physical cores.
    pub threads: Option<usize>,
    /// The folder for models and engine states, usually
    /// [`cache_directory`](longstep_files::cache_directory).
    pub cache: PathBuf,
    /// Tokens of prompt and answer together. `None` means 8192 for the embedded engine, whose memory grows with it
    /// (about 28 KB a token with the default model). If a server reports its own value, that one counts.
    pub context_tokens: Option<u32>,
    /// The projector (mmproj) file of an embedded model, with which it sees pictures (feature `vision`). Other models take
    /// none.
    pub vision: Option<PathBuf>,
    /// The adapters of an embedded model. Other models take none.
    pub adapters: AdapterChoice,
    /// Sampling of the next token.
    pub sampling: Sampling,
    /// Longest time in which a server may send nothing, before its answer and within it; 60 s.
    pub silence: Duration,
    /// Time limit for one call of [`ChatModel::chat`] to a server, including all retries; 600 s. Then the call ends
    /// with [`ModelError::TimedOut`].
    pub timeout: Duration,
    /// Cancels all traffic with a server, also requests without a [`Watch`]: those for the size of its context and for
    /// token counts.
    pub stop: StopFlag,
    /// A file to which every request and reply is appended, for `replay:FILE`. It contains the conversation, and no
    /// keys.
    pub record: Option<PathBuf>,
}

impl OpenOptions {
    /// Greedy decoding, no recording, and as many threads as the machine has physical cores.
    #[must_use]
    pub fn new(cache: PathBuf) -> Self {
        Self {
            threads: None,
            cache,
            context_tokens: None,
            vision: None,
            adapters: AdapterChoice::default(),
            sampling: Sampling::default(),
            silence: Duration::from_secs(60),
            timeout: Duration::from_secs(600),
            stop: StopFlag::default(),
            record: None,
        }
    }

    /// Sets the threads of the embedded engine; `None` takes the machine's physical cores.
    #[must_use]
    pub fn with_threads(self, threads: impl Into<Option<usize>>) -> Self {
        Self {
            threads: threads.into(),
            ..self
        }
    }

    /// Sets the tokens of prompt and answer together; `None` takes the default.
    #[must_use]
    pub fn with_context_tokens(self, context_tokens: impl Into<Option<u32>>) -> Self {
        Self {
            context_tokens: context_tokens.into(),
            ..self
        }
    }

    /// Sets the projector file of an embedded model.
    #[must_use]
    pub fn with_vision(self, vision: impl Into<Option<PathBuf>>) -> Self {
        Self {
            vision: vision.into(),
            ..self
        }
    }

    /// Sets the adapters of an embedded model.
    #[must_use]
    pub fn with_adapters(self, adapters: AdapterChoice) -> Self {
        Self { adapters, ..self }
    }

    /// Sets the sampling of the next token.
    #[must_use]
    pub fn with_sampling(self, sampling: Sampling) -> Self {
        Self { sampling, ..self }
    }

    /// Sets the longest time in which a server may send nothing.
    #[must_use]
    pub fn with_silence(self, silence: Duration) -> Self {
        Self { silence, ..self }
    }

    /// Sets the time limit for one call to a server, including all retries.
    #[must_use]
    pub fn with_timeout(self, timeout: Duration) -> Self {
        Self { timeout, ..self }
    }

    /// Sets the flag that cancels all traffic with a server.
    #[must_use]
    pub fn with_stop(self, stop: StopFlag) -> Self {
        Self { stop, ..self }
    }

    /// Sets the file to which every request and reply is appended.
    #[must_use]
    pub fn with_record(self, record: impl Into<Option<PathBuf>>) -> Self {
        Self {
            record: record.into(),
            ..self
        }
    }
}

/// The adapters of an embedded model: small additions to its weights (LoRA), each for one [task](longstep::dialogue::Task). All
/// other answers are those of the model alone.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum AdapterChoice {
    /// Those of the catalogue, if it has any for the model.
    #[default]
    Catalogue,
    /// None.
    Off,
    /// GGUF files with adapters for this model. Each names its task in `longstep.task`: `goals`, `description` or `plans`.
    Files(Vec<PathBuf>),
}

/// Sampling of the next token among the allowed ones. A parameter that a server rejects is omitted, with a
/// [`Progress::Warning`].
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Sampling {
    /// 0 (the default) takes the most likely token. 1 samples with the model's probabilities; higher values make them
    /// more even. The embedded engine treats a negative value or NaN as 0.
    pub temperature: f64,
    /// Nucleus sampling: keeps the most likely tokens up to this total probability (0 to 1).
    pub top_p: Option<f64>,
    /// Seed of the sampling. `None` means 0 for the embedded engine, and the server's choice otherwise.
    pub seed: Option<u64>,
    /// Limit of the reasoning of a model on a server; `None` leaves it to the server. An embedded model does not reason.
    pub reasoning: Option<Reasoning>,
}

impl Sampling {
    /// Sets the temperature.
    #[must_use]
    pub fn with_temperature(self, temperature: f64) -> Self {
        Self { temperature, ..self }
    }

    /// Sets the total probability of nucleus sampling.
    #[must_use]
    pub fn with_top_p(self, top_p: impl Into<Option<f64>>) -> Self {
        Self {
            top_p: top_p.into(),
            ..self
        }
    }

    /// Sets the seed.
    #[must_use]
    pub fn with_seed(self, seed: impl Into<Option<u64>>) -> Self {
        Self {
            seed: seed.into(),
            ..self
        }
    }

    /// Sets the limit of the reasoning of a model on a server.
    #[must_use]
    pub fn with_reasoning(self, reasoning: impl Into<Option<Reasoning>>) -> Self {
        Self {
            reasoning: reasoning.into(),
            ..self
        }
    }
}
