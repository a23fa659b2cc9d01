//! The embedded engine: a GGUF file, run by llama.cpp on this machine's processor.
//!
//! A thread of its own owns the model and its context, since the one borrows the other; the
//! [`EmbeddedModel`] that callers hold is a channel to it. Dropping that ends the thread and
//! frees the model.

mod blocks;
mod engine;
mod file;
mod grammar;
mod prompt;
mod state;
mod worker;

use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use longstep::prompt::{ChatRequest, ConstraintKind, Reply};

use crate::{ChatModel, ModelError, OpenOptions, Progress};
use worker::Setting;

/// A request on its way to the worker, with the line that the answer comes back on.
struct Job {
    request: ChatRequest,
    events: Sender<Event>,
}

/// What the worker says about a job.
enum Event {
    Progress(Progress),
    Done(Result<Reply, ModelError>),
}

/// A model that runs in this process.
pub(crate) struct EmbeddedModel {
    name: String,
    /// `None` only while it is being dropped.
    jobs: Option<Sender<Job>>,
    thread: Option<JoinHandle<()>>,
}

impl EmbeddedModel {
    /// Loads the file. `identity` changes with the file's content: saved states are kept by it.
    pub(crate) fn open(name: &str, path: &Path, identity: String, options: &OpenOptions) -> Result<Self, ModelError> {
        file::check(path)?;
        let setting = Setting {
            name: name.to_owned(),
            path: path.to_path_buf(),
            identity,
            threads: options.threads.unwrap_or_else(num_cpus::get_physical).max(1),
            context_tokens: options.context_tokens,
            states: options.cache.join("state"),
        };
        let (jobs, inbox) = channel();
        let (ready, loaded) = channel();
        let thread = std::thread::Builder::new()
            .name("longstep-model".into())
            .spawn(move || worker::run(&setting, &ready, &inbox))
            .map_err(|error| stopped(name, &format!("no thread could be started: {error}")))?;
        let model = Self {
            name: name.to_owned(),
            jobs: Some(jobs),
            thread: Some(thread),
        };
        match loaded.recv() {
            Ok(Ok(())) => Ok(model),
            Ok(Err(error)) => Err(error),
            Err(_) => Err(stopped(name, "it ended while the model was being loaded")),
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

    fn chat(&mut self, request: &ChatRequest, progress: &mut dyn FnMut(Progress)) -> Result<Reply, ModelError> {
        let (events, answers) = channel();
        let job = Job {
            request: request.clone(),
            events,
        };
        let sent = self.jobs.as_ref().is_some_and(|jobs| jobs.send(job).is_ok());
        if !sent {
            return Err(stopped(&self.name, "it has ended"));
        }
        follow(&self.name, &answers, progress)
    }
}

/// Passes progress on until the answer is there.
fn follow(name: &str, answers: &Receiver<Event>, progress: &mut dyn FnMut(Progress)) -> Result<Reply, ModelError> {
    loop {
        match answers.recv() {
            Ok(Event::Progress(step)) => progress(step),
            Ok(Event::Done(answer)) => return answer,
            Err(_) => return Err(stopped(name, "it ended before it had answered")),
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
        // Without a sender the worker's loop ends; the model is freed once the thread has.
        drop(self.jobs.take());
        if let Some(thread) = self.thread.take() {
            // A panic over there has been reported as an error already.
            let _ = thread.join();
        }
    }
}
