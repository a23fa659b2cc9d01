//! The trait that every model stands behind, and how one is opened.

use std::path::PathBuf;

use longstep::prompt::{ChatRequest, ConstraintKind, Reply, TokenCounter};

use crate::embedded::EmbeddedModel;
use crate::openai::OpenAiModel;
use crate::{ModelError, ModelReference, store};

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
    /// but a [`Finish`](longstep::prompt::Finish).
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
    /// The embedded engine writes.
    Writing {
        /// Tokens written so far.
        tokens: usize,
    },
    /// A request has gone to a server.
    Waiting,
    /// Something went less well than it could, in one line; the answer is not affected.
    Warning(String),
}

/// How a model is opened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OpenOptions {
    /// Threads of the embedded engine; `None` takes the machine's physical cores.
    pub threads: Option<usize>,
    /// The folder for models and engine states, usually
    /// [`cache_directory`](crate::cache_directory).
    pub cache: PathBuf,
    /// How many tokens prompt and answer may have together, for the embedded engine. Memory
    /// grows with it: about 28 KB a token with the default model.
    pub context_tokens: u32,
}

impl OpenOptions {
    /// A context of 8192 tokens, and as many threads as the machine has physical cores.
    #[must_use]
    pub fn new(cache: PathBuf) -> Self {
        Self {
            threads: None,
            cache,
            context_tokens: 8192,
        }
    }
}

/// Opens the model that is meant.
///
/// An embedded model is loaded here (about a second); a server is not contacted before the
/// first request.
///
/// # Errors
///
/// [`ModelError::NotPulled`] for a model of the catalogue that is not in the cache,
/// [`ModelError::WrongHash`] for one that has changed there, [`ModelError::NotLoaded`] for a
/// file that is no model, [`ModelError::NoKey`] for OpenAI without a key.
pub fn open(
    reference: &ModelReference,
    options: &OpenOptions,
    progress: &mut dyn FnMut(Progress),
) -> Result<Box<dyn ChatModel>, ModelError> {
    match reference {
        ModelReference::Catalogue(entry) => {
            progress(Progress::Loading);
            let path = store::locate(entry, &options.cache)?.ok_or_else(|| ModelError::NotPulled {
                name: entry.name,
                cache: options.cache.clone(),
            })?;
            let identity = entry.sha256.to_owned();
            let model = EmbeddedModel::open(entry.name, &path, identity, options)?;
            Ok(Box::new(model))
        }
        ModelReference::File(path) => {
            progress(Progress::Loading);
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
            let identity = store::identity(path)?;
            let model = EmbeddedModel::open(&name, path, identity, options)?;
            Ok(Box::new(model))
        }
        ModelReference::OpenAi { model } => Ok(Box::new(OpenAiModel::openai(model)?)),
        ModelReference::Server { url, model } => Ok(Box::new(OpenAiModel::server(url, model))),
    }
}
