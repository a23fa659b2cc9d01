//! The embedded engine: llama.cpp runs a GGUF file on this machine's processor.
//!
//! A worker thread owns the model and its context, because the context borrows the model. Callers hold an
//! [`EmbeddedModel`], which is a channel to the worker. Dropping it ends the thread and frees the model.

mod adapter;
mod blocks;
mod contexts;
mod engine;
mod file;
#[cfg(feature = "vision")]
mod gguf;
mod grammar;
#[cfg(test)]
mod grammar_tests;
#[cfg(feature = "vision")]
mod picture;
#[cfg(feature = "vision")]
mod projector;
#[cfg(all(test, feature = "vision"))]
mod projector_tests;
mod prompt;
mod sample;
mod state;
#[cfg(feature = "vision")]
mod vision;
#[cfg(not(feature = "vision"))]
#[path = "without_vision.rs"]
mod vision;
mod worker;

use std::collections::HashMap;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use longstep::dialogue::{ChatRequest, ConstraintKind, Counting, Message, Reply, Role, TokenCounter};

use crate::{ChatModel, ModelError, OpenOptions, Progress, Watch};
use worker::Setting;

/// Default size of the context: prompt and answer together, in tokens.
const CONTEXT_TOKENS: u32 = 8192;

/// A job for the worker, with the channel for its result.
enum Job {
    /// Answers a request.
    Chat(ChatRequest, Sender<WorkerReport>),
    /// Counts the tokens of a message, and of the template around messages.
    Count(Message, Sender<Count>),
}

/// Tokens of a message, and of a conversation without messages.
struct Count {
    message: u64,
    frame: u64,
}

/// The worker's report about a chat job.
enum WorkerReport {
    Progress(Progress),
    Done(Result<Reply, ModelError>),
}

/// A model that runs in this process.
pub(crate) struct EmbeddedModel {
    name: String,
    context_tokens: u32,
    /// Cached counts: the same fixed parts are counted many times.
    counted: HashMap<Message, u64>,
    frame: Option<u64>,
    /// `None` only while the model is being dropped.
    jobs: Option<Sender<Job>>,
    thread: Option<JoinHandle<()>>,
}

impl EmbeddedModel {
    /// Loads the file. `identity` changes with the file's content and is part of the key of saved states.
    pub(crate) fn open(name: &str, path: &Path, identity: String, options: &OpenOptions) -> Result<Self, ModelError> {
        file::check(path)?;
        let adapters = adapter::chosen(name, &options.adapters)?;
        let context_tokens = options.context_tokens.unwrap_or(CONTEXT_TOKENS);
        let setting = Setting {
            name: name.to_owned(),
            path: path.to_path_buf(),
            identity,
            threads: options.threads.unwrap_or_else(num_cpus::get_physical).max(1),
            context_tokens,
            sampling: options.sampling.clone(),
            states: options.cache.join("state"),
            projector: options.vision.clone(),
            adapters,
        };
        let (jobs, inbox) = channel();
        let (ready, loaded) = channel();
        let thread = std::thread::Builder::new()
            .name("longstep-model".into())
            .spawn(move || worker::run(&setting, &ready, &inbox))
            .map_err(|error| stopped(name, &format!("cannot start a thread: {error}")))?;
        let model = Self {
            name: name.to_owned(),
            context_tokens,
            counted: HashMap::new(),
            frame: None,
            jobs: Some(jobs),
            thread: Some(thread),
        };
        match loaded.recv() {
            Ok(Ok(())) => Ok(model),
            Ok(Err(error)) => Err(error),
            Err(_) => Err(stopped(name, "its thread ended while it loaded the model")),
        }
    }
}

impl ChatModel for EmbeddedModel {
    fn name(&self) -> &str {
        &self.name
    }

    fn constraint_kind(&self) -> ConstraintKind {
        ConstraintKind::Grammar
    }

    fn chat(&mut self, request: &ChatRequest, watch: &mut dyn Watch) -> Result<Reply, ModelError> {
        let (events, answers) = channel();
        if !self.send(Job::Chat(request.clone(), events)) {
            return Err(stopped(&self.name, "its thread has ended"));
        }
        follow(&self.name, &answers, watch)
    }

    fn context_tokens(&self) -> Option<u64> {
        Some(self.context_tokens.into())
    }
}

impl TokenCounter for EmbeddedModel {
    fn message_tokens(&mut self, message: &Message) -> u64 {
        if let Some(known) = self.counted.get(message) {
            return *known;
        }
        let (answer, count) = channel();
        let sent = self.send(Job::Count(message.clone(), answer));
        // If the worker has ended, the next chat request reports it.
        let Some(count) = sent.then(|| count.recv().ok()).flatten() else {
            return 0;
        };
        self.frame = Some(count.frame);
        self.counted.insert(message.clone(), count.message);
        count.message
    }

    fn frame_tokens(&mut self) -> u64 {
        if self.frame.is_none() {
            self.message_tokens(&Message::new(Role::User, ""));
        }
        self.frame.unwrap_or_default()
    }

    fn counting(&self) -> Counting {
        Counting::Exact(format!("the tokenizer of {}", self.name))
    }
}

impl EmbeddedModel {
    fn send(&self, job: Job) -> bool {
        self.jobs.as_ref().is_some_and(|jobs| jobs.send(job).is_ok())
    }
}

/// Interval at which a waiting caller's [`Watch`] is checked.
const PATIENCE: Duration = Duration::from_millis(50);

/// Passes progress on until the answer arrives. On a stop the receiver is dropped; the worker's next send fails, and it
/// stops.
fn follow(name: &str, answers: &Receiver<WorkerReport>, watch: &mut dyn Watch) -> Result<Reply, ModelError> {
    loop {
        if watch.stop() {
            return Err(ModelError::Stopped);
        }
        match answers.recv_timeout(PATIENCE) {
            Ok(WorkerReport::Progress(step)) => watch.tell(step),
            Ok(WorkerReport::Done(answer)) => return answer,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err(stopped(name, "its thread ended before the answer")),
        }
    }
}

fn stopped(name: &str, reason: &str) -> ModelError {
    ModelError::Engine {
        model: name.to_owned(),
        reason: reason.to_owned(),
    }
}

impl Drop for EmbeddedModel {
    fn drop(&mut self) {
        // Without a sender the worker's loop ends; the thread frees the model when it ends.
        drop(self.jobs.take());
        if let Some(thread) = self.thread.take() {
            // A panic of the worker has been reported as an error already.
            let _ = thread.join();
        }
    }
}
