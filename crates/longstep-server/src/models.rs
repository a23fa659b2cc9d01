//! The model of a server: opened once, shared by all sessions, behind a queue with a bound.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use longstep::session::ModelFacts;
use longstep_llm::{ChatModel, ModelError};

use crate::problem::{Problem, ProblemKind};

/// Work for a model, on the thread that owns it.
pub(crate) type Job = Box<dyn FnOnce(&mut dyn ChatModel) + Send>;

/// Opens a model. Called once on each thread that owns one.
pub type OpenModel = Arc<dyn Fn() -> Result<Box<dyn ChatModel>, ModelError> + Send + Sync>;

/// The model of a server.
///
/// Each thread owns one opened model: an embedded one takes one thread, a client of a server many. Sessions wait in one
/// queue, first come, first served; a session has at most one request in it, so no session holds another one up.
pub struct Models {
    facts: ModelFacts,
    jobs: SyncSender<Job>,
    waiting: Arc<AtomicUsize>,
    bound: usize,
}

impl Models {
    /// Opens a model on `threads` threads; at most `bound` requests wait for them.
    ///
    /// # Errors
    ///
    /// The model cannot be opened.
    pub fn open(open: OpenModel, threads: usize, bound: usize) -> Result<Self, ModelError> {
        let (jobs, receiver) = sync_channel::<Job>(bound.max(1));
        let receiver = Arc::new(Mutex::new(receiver));
        let waiting = Arc::new(AtomicUsize::new(0));
        let (opened, results) = sync_channel(threads.max(1));
        for _ in 0..threads.max(1) {
            let (open, receiver, waiting, opened) = (
                Arc::clone(&open),
                Arc::clone(&receiver),
                Arc::clone(&waiting),
                opened.clone(),
            );
            thread::spawn(move || match open() {
                Ok(mut model) => {
                    let facts = model.facts();
                    if opened.send(Ok(facts)).is_ok() {
                        drop(opened);
                        serve(model.as_mut(), &receiver, &waiting);
                    }
                }
                Err(error) => drop(opened.send(Err(error))),
            });
        }
        drop(opened);
        let mut facts = None;
        for result in results {
            facts = Some(result?);
        }
        let facts = facts.ok_or(ModelError::Stopped)?;
        Ok(Self {
            facts,
            jobs,
            waiting,
            bound: bound.max(1),
        })
    }

    /// Returns the facts about the model that a session depends on.
    pub fn facts(&self) -> &ModelFacts {
        &self.facts
    }

    /// Returns the number of requests that wait.
    pub fn waiting(&self) -> usize {
        self.waiting.load(Ordering::SeqCst)
    }

    /// Adds work to the queue.
    ///
    /// # Errors
    ///
    /// The queue is full.
    pub(crate) fn submit(&self, job: Job) -> Result<(), Problem> {
        self.waiting.fetch_add(1, Ordering::SeqCst);
        self.jobs.try_send(job).map_err(|error| {
            self.waiting.fetch_sub(1, Ordering::SeqCst);
            match error {
                TrySendError::Full(_) => Problem::new(
                    ProblemKind::Busy,
                    format!("{} requests wait for the model already", self.bound),
                )
                .hint("try again in some seconds"),
                TrySendError::Disconnected(_) => Problem::new(ProblemKind::Internal, "the model has ended"),
            }
        })
    }
}

/// Does the work of the queue, one after the other, until the server ends.
fn serve(model: &mut dyn ChatModel, receiver: &Mutex<Receiver<Job>>, waiting: &AtomicUsize) {
    loop {
        // One idle thread waits inside the lock, the others for it; the lock is free while the work is done.
        let job = receiver.lock().unwrap_or_else(PoisonError::into_inner).recv();
        let Ok(job) = job else { return };
        waiting.fetch_sub(1, Ordering::SeqCst);
        job(model);
    }
}
