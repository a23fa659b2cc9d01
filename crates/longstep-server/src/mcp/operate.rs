//! The tools for runs: `run_status`, `pause`, `resume` and `stop`.

use std::sync::Arc;
use std::time::Duration;

use serde_json::json;
use tokio::time::{Instant, timeout_at};

use super::call::{LookAt, OfRun, StopRun};
use super::caller::Caller;
use super::face::Face;
use super::reply::Reply;
use crate::audit::Deed;
use crate::id::{RunId, SessionId};
use crate::problem::{Problem, ProblemKind};
use crate::run::{RunState, RunView};

/// The longest wait of `run_status`.
const LONGEST_WAIT: Duration = Duration::from_secs(30);

impl Face {
    /// Reads the id of a run.
    ///
    /// # Errors
    ///
    /// The text cannot be one.
    pub(super) fn named_run(&self, text: &str) -> Result<RunId, Problem> {
        RunId::parse(text).ok_or_else(|| {
            Problem::missing("run", text).hint("use the `id` of the run that `execute_plan` or `run_status` returned")
        })
    }

    /// Shows a run, the named one or the last one of the session. Waits for its end or its question, if it is to.
    pub(super) async fn run_status(&self, caller: &Caller, asked: LookAt) -> Result<Reply, Problem> {
        let run = match &asked.run {
            Some(text) => self.named_run(text)?,
            None => self.last_run(&self.known_session(asked.session.as_deref())?)?,
        };
        let wait = asked.wait_seconds.unwrap_or(0.0).clamp(0.0, LONGEST_WAIT.as_secs_f64());
        let view = tokio::select! {
            view = self.settled(&run, Duration::from_secs_f64(wait)) => view?,
            () = caller.cancelled.cancelled() => self.shared.hub.run(&run)?,
        };
        self.shared.show_run(&view)
    }

    /// Returns the run of a session that goes on, or else that of its last plan.
    fn last_run(&self, session: &SessionId) -> Result<RunId, Problem> {
        let runs = self.shared.hub.runs();
        let own = runs.iter().filter(|run| run.record.session == *session);
        let last = own.max_by_key(|run| (!run.state.is_ended(), run.record.number));
        last.map(|run| run.record.id.clone()).ok_or_else(|| {
            Problem::new(ProblemKind::Missing, "no run of this session has begun").hint(
                "`execute_plan` begins one after a person approved; if a person is to approve on the page, wait for them",
            )
        })
    }

    /// Returns a run when it needs somebody or has ended, at the latest after a time.
    async fn settled(&self, run: &RunId, wait: Duration) -> Result<Arc<RunView>, Problem> {
        let hub = &self.shared.hub;
        let deadline = Instant::now() + wait;
        let mut news = hub.feed().newest();
        loop {
            news.borrow_and_update();
            let view = hub.run(run)?;
            let needs_somebody = matches!(view.state, RunState::Asking | RunState::Paused);
            if view.state.is_ended() || needs_somebody || timeout_at(deadline, news.changed()).await.is_err() {
                return Ok(view);
            }
        }
    }

    /// Pauses a run after the steps that are under way.
    pub(super) async fn pause(&self, caller: &Caller, asked: OfRun) -> Result<Reply, Problem> {
        let (run, by) = (self.named_run(&asked.run)?, caller.by.clone());
        self.work(move |shared| shared.show_run(&*shared.hub.pause(&run, &by)?))
            .await
    }

    /// Lets a run go on that this client has paused. The pause of a person is ended by a person.
    pub(super) async fn resume(&self, caller: &Caller, asked: OfRun) -> Result<Reply, Problem> {
        let (run, by) = (self.named_run(&asked.run)?, caller.by.clone());
        self.work(move |shared| {
            let entries = shared.hub.audit().last(usize::MAX)?;
            let paused = entries
                .iter()
                .find(|entry| matches!(&entry.deed, Deed::Paused { run: paused } if *paused == run));
            match paused {
                Some(entry) if entry.by == by => shared.show_run(&*shared.hub.go_on(&run, &by)?),
                Some(_) => Err(
                    Problem::new(ProblemKind::Forbidden, "somebody else has paused this run")
                        .hint("ask the person to let it go on where they paused it"),
                ),
                None => Err(Problem::conflict("nobody has paused this run").hint("call `run_status` to see its state")),
            }
        })
        .await
    }

    /// Stops a run, or all runs: the robot before anything else. Waits for nothing but the audit log after that.
    pub(super) fn stop(&self, caller: &Caller, asked: &StopRun) -> Result<Reply, Problem> {
        let hub = &self.shared.hub;
        let Some(text) = &asked.run else {
            let count = hub.stop_all(&caller.by)?;
            return Reply::new(format!("Stopped: {count} runs."), &json!({ "stopped": count }));
        };
        let all = "call `stop` without `run` to stop all robots";
        let run = self.named_run(text).map_err(|problem| problem.hint(all))?;
        let view = hub.stop(&run, &caller.by).map_err(|problem| problem.hint(all))?;
        let going = usize::from(!view.state.is_ended());
        let text = format!("Stop was sent to run {run}. Call `run_status` for its end.");
        Reply::new(text, &json!({ "stopped": going }))
    }
}
