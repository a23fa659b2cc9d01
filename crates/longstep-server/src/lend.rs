//! The model, lent to programs that build their requests themselves.

use longstep_llm::lent::{ChatCall, CountCall, facts};
use longstep_llm::{ChatModel, ModelError, Progress, Watch};
use serde_json::Value;
use tokio::sync::oneshot::{Sender, channel};

use crate::hub::Hub;
use crate::problem::{Problem, ProblemKind};

/// Work for a lent model.
#[derive(Debug)]
#[non_exhaustive]
pub enum LentWork {
    /// Describes the model.
    Describe,
    /// Answers a request.
    Chat(ChatCall),
    /// Counts tokens.
    Count(CountCall),
}

impl LentWork {
    fn done(self, model: &mut dyn ChatModel, watch: &mut dyn Watch) -> Result<Value, ModelError> {
        match self {
            Self::Describe => facts(model),
            Self::Chat(call) => call.answer(model, watch),
            Self::Count(call) => call.answer(model),
        }
    }
}

/// Cancels the work when nobody waits for it.
struct Waited<'a>(&'a Sender<Result<Value, ModelError>>);

impl Watch for Waited<'_> {
    fn tell(&mut self, _: Progress) {}

    fn stop(&self) -> bool {
        self.0.is_closed()
    }
}

impl Hub {
    /// Lets the model do work, after what waits for it. Drop what is returned, and the work is cancelled.
    ///
    /// # Errors
    ///
    /// There is no model, its queue is full, or it failed.
    pub async fn lend(&self, work: LentWork) -> Result<Value, Problem> {
        let models = self.models_or_problem()?;
        let (answer, answered) = channel();
        models.submit(Box::new(move |model: &mut dyn ChatModel| {
            if answer.is_closed() {
                return;
            }
            let done = work.done(model, &mut Waited(&answer));
            // Whoever waited may be gone.
            let _ = answer.send(done);
        }))?;
        let done = answered.await;
        let done = done.map_err(|_| Problem::new(ProblemKind::Internal, "the model has ended"))?;
        done.map_err(|error| {
            let kind = match error {
                ModelError::Unsupported { .. } | ModelError::Grammar(_) => ProblemKind::Unreadable,
                ModelError::TooLong { .. } => ProblemKind::TooLarge,
                _ => ProblemKind::Failed,
            };
            Problem { kind, ..error.into() }
        })
    }
}
