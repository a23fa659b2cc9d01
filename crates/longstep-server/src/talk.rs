//! Requests of a person to a session.

use std::sync::Arc;
use std::time::{Duration, Instant};

use longstep::session::{Response, Session};

use crate::audit::Deed;
use crate::hosted::{Held, Hosted};
use crate::hub::{Hub, checked_text};
use crate::id::SessionId;
use crate::problem::Problem;
use crate::view::{Snapshot, proposal_hash};

/// The longest time in which a model that has shown its result leaves a session.
const LEAVING: Duration = Duration::from_secs(2);

/// A request of a person that a model may have to answer.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Said {
    /// An instruction.
    Instruction(String),
    /// An answer to the question.
    Answer(String),
    /// Feedback on the plan.
    Feedback(String),
}

impl Said {
    fn text(&self) -> &str {
        match self {
            Self::Instruction(text) | Self::Answer(text) | Self::Feedback(text) => text,
        }
    }

    fn apply(&self, session: &mut Session) -> Result<(), Problem> {
        let text = checked_text(self.text())?;
        match self {
            Self::Instruction(_) => session.instruct(text)?,
            Self::Answer(_) => session.answer(text)?,
            Self::Feedback(_) => session.feedback(text)?,
        }
        Ok(())
    }
}

/// Cancels the work of a model when the one who asked for it goes away.
pub struct Waiting {
    hosted: Arc<Hosted>,
    is_over: bool,
}

impl Waiting {
    pub(crate) fn new(hosted: Arc<Hosted>) -> Self {
        Self { hosted, is_over: false }
    }

    /// Returns the session as it is now.
    pub fn snapshot(&self) -> Arc<Snapshot> {
        self.hosted.snapshot()
    }

    /// Waits until it is the person's turn.
    pub async fn turn(self) -> Arc<Snapshot> {
        self.ended().await.snapshot()
    }

    /// Waits until it is the person's turn; returns the session itself.
    pub(crate) async fn ended(mut self) -> Arc<Hosted> {
        let mut version = self.hosted.version();
        while self.hosted.is_thinking() {
            version.borrow_and_update();
            if !self.hosted.is_thinking() || version.changed().await.is_err() {
                break;
            }
        }
        self.is_over = true;
        Arc::clone(&self.hosted)
    }

    /// Leaves the model at work: what comes of it is in the session, and on the live stream.
    pub fn leave(mut self) -> Arc<Snapshot> {
        self.is_over = true;
        self.hosted.snapshot()
    }
}

impl Drop for Waiting {
    fn drop(&mut self) {
        if !self.is_over {
            self.hosted.stop_thinking();
        }
    }
}

/// Marks that a model is to work for a session; false if one does already. One that has shown its result leaves in a moment,
/// which is waited for: whoever sees a plan may go on.
fn begin_thinking(held: &Held) -> bool {
    let began = Instant::now();
    while !held.begin_thinking() {
        let is_at_work = held.look(|session| matches!(session.response(), Response::Waiting));
        if is_at_work || began.elapsed() > LEAVING {
            return false;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    true
}

impl Hub {
    /// Tells a session something; a model then works for it. Drop what is returned, and the work is cancelled.
    ///
    /// # Errors
    ///
    /// The session waits for something else, the queue for the model is full, or there is no model.
    pub fn say(self: &Arc<Self>, id: &SessionId, said: &Said) -> Result<Waiting, Problem> {
        let held = self.held(id)?;
        self.say_to(&held, said)?;
        Ok(Waiting::new(Arc::clone(&held)))
    }

    pub(crate) fn say_to(&self, held: &Held, said: &Said) -> Result<(), Problem> {
        self.think(held, |session| said.apply(session))
    }

    /// Lets the model go on for a session that was read from its log in the middle of a request: the server that asked it
    /// has ended. Without a model, the request is cancelled.
    pub(crate) fn think_on(&self, held: &Held) {
        let is_waiting = || held.look(|session| matches!(session.response(), Response::Waiting));
        if !held.is_thinking() && is_waiting() && self.think(held, |_| Ok(())).is_err() {
            // It may have been cancelled already.
            let _ = held.change(|session| Ok(session.cancel()?));
        }
    }

    /// Lets the model work for a session after a change.
    fn think(&self, held: &Held, change: impl FnOnce(&mut Session) -> Result<(), Problem>) -> Result<(), Problem> {
        let models = self.models_or_problem()?;
        if !begin_thinking(held) {
            return Err(Problem::conflict("a model works for this session already")
                .hint("wait for it, or cancel the instruction"));
        }
        let job = {
            let held = held.clone();
            Box::new(move |model: &mut dyn longstep_llm::ChatModel| held.think(model))
        };
        let facts = models.facts().clone();
        let begun = held.change(|session| {
            if *session.model() != facts {
                session.set_model(facts);
            }
            change(session)
        });
        let submitted = begun.and_then(|()| {
            models.submit(job).inspect_err(|_| {
                // Nobody will answer: the session is as before.
                let _ = held.change(|session| Ok(session.cancel()?));
            })
        });
        submitted.inspect_err(|_| held.end_thinking())
    }

    /// Cancels what a session does: the work of a model, feedback, or the instruction.
    ///
    /// # Errors
    ///
    /// There is nothing to cancel.
    pub fn cancel(&self, id: &SessionId) -> Result<Arc<Snapshot>, Problem> {
        let held = self.held(id)?;
        if held.is_thinking() {
            // The thread of the model cancels the session.
            held.stop_thinking();
        } else {
            held.change(|session| Ok(session.cancel()?))?;
        }
        Ok(held.snapshot())
    }

    /// Accepts the plan with this hash: the next instruction begins in its final world. Nothing moves for that.
    ///
    /// # Errors
    ///
    /// Another plan, or none, waits for a decision; a robot carries out a plan that this one would take the place of.
    pub fn accept(&self, id: &SessionId, plan: &str, by: &str) -> Result<Arc<Snapshot>, Problem> {
        let held = self.held(id)?;
        let _beginning = self.beginning.lock(id);
        let accepted = held.change(|session| {
            let shown = session.proposal().map(proposal_hash);
            if shown.as_deref() != Some(plan) {
                return Err(Problem::conflict(match shown {
                    Some(_) => "another plan waits for a decision now",
                    None => "no plan waits for a decision",
                })
                .hint("look at the session again"));
            }
            if session.replaces_pending() {
                self.refuse_during_run(id)?;
            }
            self.audit.add(
                by,
                Deed::Accepted {
                    session: id.clone(),
                    plan: plan.to_owned(),
                },
            )?;
            Ok(session.accept()?)
        });
        match accepted {
            Ok(()) => Ok(held.snapshot()),
            Err(problem) => {
                self.audit.refused(by, id, plan, &problem.message)?;
                Err(problem)
            }
        }
    }

    /// Reverts the last accepted plan.
    ///
    /// # Errors
    ///
    /// An instruction is in progress, there is no accepted plan, or a robot carries it out.
    pub fn undo(&self, id: &SessionId) -> Result<Arc<Snapshot>, Problem> {
        self.refuse_during_run(id)?;
        self.changed(id, |session| {
            session.undo()?;
            Ok(())
        })
    }

    /// Says which of its endings the last plan had.
    ///
    /// # Errors
    ///
    /// No ending is open, or there is none with this number.
    pub fn ended(&self, id: &SessionId, number: usize) -> Result<Arc<Snapshot>, Problem> {
        self.changed(id, |session| Ok(session.ended(number)?))
    }

    /// Takes an observation of the world between two instructions.
    ///
    /// # Errors
    ///
    /// An instruction is in progress, a robot carries a plan out, or a statement cannot be read in this world.
    pub fn observed(
        &self,
        id: &SessionId,
        statements: &longstep_core::environment::Observation,
    ) -> Result<Arc<Snapshot>, Problem> {
        self.refuse_during_run(id)?;
        self.changed(id, |session| {
            session.observed(statements)?;
            Ok(())
        })
    }

    fn changed(
        &self,
        id: &SessionId,
        change: impl FnOnce(&mut Session) -> Result<(), Problem>,
    ) -> Result<Arc<Snapshot>, Problem> {
        let held = self.held(id)?;
        held.change(change)?;
        Ok(held.snapshot())
    }
}
