//! Approvals used, and runs begun, paused, continued and stopped.

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, MutexGuard, PoisonError};
use std::time::Duration;

use longstep_core::environment;
use longstep_core::execution::{Aim, Event};
use longstep_core::json;
use longstep_robot::RunLog;

use crate::approval::{Approval, Approved};
use crate::audit::Deed;
use crate::hosted::{EndedRun, Hosted};
use crate::hub::Hub;
use crate::id::{ApprovalId, RunId, SessionId};
use crate::problem::Problem;
use crate::run::{EndView, HostedRun, RunRecord, RunState, RunView, Start, Task};
use crate::store::{LogName, RecordKey};
use crate::view::{accepted_hash, goal_of};

/// The most runs whose views keep their steps.
const WHOLE_RUNS: usize = 512;

impl Hub {
    /// Approves the next accepted plan of a session for a robot. It names the hash that the person saw.
    ///
    /// # Errors
    ///
    /// Another plan, or none, waits for a robot; there is no such robot.
    pub fn approve(
        &self,
        id: &SessionId,
        plan: &str,
        robot: &str,
        by: &str,
        lifetime: Duration,
    ) -> Result<Approval, Problem> {
        let snapshot = self.hosted(id)?.snapshot();
        let entry = self.robot(robot)?;
        let next = snapshot.next.as_ref().map(|accepted| accepted_hash(accepted));
        if next.as_deref() != Some(plan) {
            let problem = Problem::conflict(match next {
                Some(_) => "another plan is the next for a robot",
                None => "no accepted plan waits for a robot",
            });
            self.audit.refused(by, id, plan, &problem.message)?;
            return Err(problem.hint("accept the plan first, then look at the session again"));
        }
        let subject = Approved {
            session: id,
            plan,
            world: &snapshot.robot_world,
            robot: &entry.name,
        };
        self.approvals.approve(&subject, by, lifetime)
    }

    /// Begins a run with an approval, which is used then. An urgent run interrupts the one that the robot carries out.
    ///
    /// # Errors
    ///
    /// The approval does not hold, or the robot cannot take another run.
    pub fn start(&self, approval: &ApprovalId, urgent: bool, by: &str) -> Result<Arc<RunView>, Problem> {
        let approval = self.approvals.find(approval)?;
        let hosted = self.hosted(&approval.session)?;
        let _beginning = self.beginning.lock(&approval.session);
        self.refuse_during_run(&approval.session)?;
        let snapshot = hosted.snapshot();
        let entry = self.robot(&approval.robot)?.clone();
        let Some(accepted) = &snapshot.next else {
            return Err(Problem::conflict("no accepted plan waits for a robot"));
        };
        let subject = Approved {
            session: &approval.session,
            plan: &accepted_hash(accepted),
            world: &snapshot.robot_world,
            robot: &entry.name,
        };
        let run = RunId::random()?;
        self.approvals.consume(&approval, &subject, &run, by)?;
        let number = snapshot
            .view
            .accepted
            .iter()
            .find(|own| own.pending)
            .map_or(0, |own| own.number);
        let record = RunRecord {
            id: run.clone(),
            session: approval.session.clone(),
            number,
            plan: approval.plan.clone(),
            approval: approval.id.clone(),
            robot: entry.name.clone(),
            by: by.to_owned(),
            instruction: accepted.instruction.clone(),
            urgent,
        };
        let text = serde_json::to_string(&record).unwrap_or_default();
        self.store.insert(&RecordKey::Run(run.clone()), &text)?;
        // With its log, a run is listed after a restart.
        self.store.own(&LogName::Run(run.clone()))?;
        let start = Start::Plan {
            plan: Box::new(accepted.plan.clone()),
            aim: Aim::from((!goal_of(accepted).is_empty()).then(|| goal_of(accepted).join(" & "))),
            domain: accepted.before.domain().name.clone(),
        };
        let run = Arc::new(HostedRun::new(record, Arc::clone(&self.feed), RunState::Queued));
        self.queue(&run, hosted, start)
    }

    fn queue(&self, run: &Arc<HostedRun>, session: Arc<Hosted>, start: Start) -> Result<Arc<RunView>, Problem> {
        let entry = self.robot(&run.record().robot)?.clone();
        let body = Self::body(&entry, &run.record().session);
        self.hosted_runs().insert(run.record().id.clone(), Arc::clone(run));
        self.shorten_runs(run);
        let task = Task {
            run: Arc::clone(run),
            entry,
            session,
            store: Arc::clone(&self.store),
            audit: self.audit.clone(),
            start,
        };
        run.update(|_| {});
        let queued = self.queues.add(&body, task);
        if let Err(problem) = &queued {
            run.update(|view| {
                view.state = RunState::Stopped;
                view.end = Some(EndView {
                    done: false,
                    text: problem.message.clone(),
                    resumable: false,
                });
            });
        }
        queued.map(|()| run.view())
    }

    /// Shortens the views of the runs that ended before the last ones, so that a long life of the server does not fill the
    /// memory. The new run is one of those that are not shortened.
    fn shorten_runs(&self, new: &Arc<HostedRun>) {
        let mut whole = self.whole_runs.lock().unwrap_or_else(PoisonError::into_inner);
        whole.push_back(Arc::clone(new));
        for _ in WHOLE_RUNS..whole.len() {
            let Some(oldest) = whole.pop_front() else { break };
            if oldest.view().state.is_ended() {
                oldest.shorten();
            } else {
                whole.push_back(oldest);
            }
        }
    }

    pub(crate) fn hosted_runs(&self) -> MutexGuard<'_, HashMap<RunId, Arc<HostedRun>>> {
        self.runs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn hosted_run(&self, id: &RunId) -> Result<Arc<HostedRun>, Problem> {
        let found = self.hosted_runs().get(id).cloned();
        found.ok_or_else(|| Problem::missing("run", id))
    }

    /// Returns a run as it is now. Never waits.
    ///
    /// # Errors
    ///
    /// There is none with this id.
    pub fn run(&self, id: &RunId) -> Result<Arc<RunView>, Problem> {
        Ok(self.hosted_run(id)?.view())
    }

    /// Returns all runs, in the order of their ids.
    pub fn runs(&self) -> Vec<Arc<RunView>> {
        let mut runs: Vec<_> = self.hosted_runs().values().map(|run| run.view()).collect();
        runs.sort_by(|one, other| one.record.id.cmp(&other.record.id));
        runs
    }

    /// Answers the question of a run. For a proposal, `question` is the hash that the person saw.
    ///
    /// # Errors
    ///
    /// The run asks something else, or nothing.
    pub fn decide(&self, id: &RunId, question: &str, yes: bool, by: &str) -> Result<Arc<RunView>, Problem> {
        let run = self.hosted_run(id)?;
        let asked = run.view().question.clone();
        let is_proposal = asked.is_some_and(|asked| matches!(asked.kind, "plan" | "change" | "step"));
        // The decision is in the audit log before it takes effect.
        self.audit.add(
            by,
            Deed::Decided {
                run: id.clone(),
                proposal: is_proposal.then(|| question.to_owned()),
                yes,
            },
        )?;
        run.decide(question, yes)?;
        Ok(run.view())
    }

    /// Pauses a run after the steps that are under way.
    ///
    /// # Errors
    ///
    /// There is no such run, or it has ended.
    pub fn pause(&self, id: &RunId, by: &str) -> Result<Arc<RunView>, Problem> {
        let run = self.going(id)?;
        self.audit.add(by, Deed::Paused { run: id.clone() })?;
        run.pause(true);
        Ok(run.view())
    }

    /// Lets a paused run go on, from the world that is observed then.
    ///
    /// # Errors
    ///
    /// There is no such run, or it has ended.
    pub fn go_on(&self, id: &RunId, by: &str) -> Result<Arc<RunView>, Problem> {
        let run = self.going(id)?;
        self.audit.add(by, Deed::Continued { run: id.clone() })?;
        run.pause(false);
        Ok(run.view())
    }

    fn going(&self, id: &RunId) -> Result<Arc<HostedRun>, Problem> {
        let run = self.hosted_run(id)?;
        if run.view().state.is_ended() {
            return Err(Problem::conflict("the run has ended"));
        }
        Ok(run)
    }

    /// Stops a run: the robot before anything else. Waits for nothing. A run that has ended is no error.
    ///
    /// # Errors
    ///
    /// There is no such run. That the audit log could not be written is said after the robot was stopped.
    pub fn stop(&self, id: &RunId, by: &str) -> Result<Arc<RunView>, Problem> {
        let run = self.hosted_run(id)?;
        run.control().stop();
        self.audit.add(by, Deed::Stopped { run: Some(id.clone()) })?;
        Ok(run.view())
    }

    /// Stops all robots, before anything else. Returns the number of runs that were going on.
    ///
    /// # Errors
    ///
    /// That the audit log could not be written is said after the robots were stopped.
    pub fn stop_all(&self, by: &str) -> Result<usize, Problem> {
        let runs: Vec<_> = self.hosted_runs().values().cloned().collect();
        let going: Vec<_> = runs.into_iter().filter(|run| !run.view().state.is_ended()).collect();
        going.iter().for_each(|run| run.control().stop());
        self.audit.add(by, Deed::Stopped { run: None })?;
        Ok(going.len())
    }

    /// Returns an error while a robot carries out a plan of a session.
    pub(crate) fn refuse_during_run(&self, id: &SessionId) -> Result<(), Problem> {
        let is_busy = |run: &Arc<HostedRun>| run.record().session == *id && !run.view().state.is_ended();
        if self.hosted_runs().values().any(is_busy) {
            return Err(
                Problem::conflict("a robot carries out a plan of this session").hint("wait for the run, or stop it")
            );
        }
        Ok(())
    }

    /// Takes up an interrupted run from its log, on the same robot.
    ///
    /// # Errors
    ///
    /// The run is not interrupted, or its log cannot be read.
    pub fn resume(&self, id: &RunId, by: &str) -> Result<Arc<RunView>, Problem> {
        let run = self.hosted_run(id)?;
        let view = run.view();
        let is_resumable = view.state == RunState::Interrupted || view.end.as_ref().is_some_and(|end| end.resumable);
        if !view.state.is_ended() || !is_resumable {
            return Err(Problem::conflict("the run cannot be resumed"));
        }
        let record = run.record().clone();
        let _beginning = self.beginning.lock(&record.session);
        self.refuse_during_run(&record.session)?;
        let hosted = self.hosted(&record.session)?;
        let snapshot = hosted.snapshot();
        let next = snapshot.view.accepted.iter().find(|accepted| accepted.pending);
        if !next.is_some_and(|next| next.number == record.number && next.plan == record.plan) {
            return Err(
                Problem::conflict("the plan of the run does not wait for a robot any more")
                    .hint("it was undone, or carried out by another run"),
            );
        }
        let (domain, events) = self.run_log(id)?;
        let planner = self.domains.planner(&domain)?;
        let Some(Event::Began { environment, .. }) = events.first() else {
            return Err(Problem::conflict("the log of the run has no beginning"));
        };
        let world = environment::read(planner.domain(), environment, "the log", "", &json::Path::default());
        let world = world.map_err(|error| Problem::conflict(error.to_string()))?;
        self.audit.add(by, Deed::Continued { run: id.clone() })?;
        let run = Arc::new(HostedRun::new(record, Arc::clone(&self.feed), RunState::Queued));
        let world = Box::new(world);
        self.queue(&run, hosted, Start::Log { events, world })
    }

    /// Reads the log of a run: the domain, and the events. A run that has not begun has none.
    fn run_log(&self, id: &RunId) -> Result<(String, Vec<Event>), Problem> {
        let bytes = self.store.read(&LogName::Run(id.clone()))?.unwrap_or_default();
        if !bytes.contains(&b'\n') {
            return Ok((String::new(), Vec::new()));
        }
        let text = String::from_utf8_lossy(&bytes);
        let read = RunLog::parse(Path::new(id.as_str()), &text);
        let (header, events) =
            read.map_err(|error| Problem::conflict(format!("the log of the run cannot be read: {error}")))?;
        Ok((header.domain, events))
    }

    /// Takes up the runs of earlier servers as they ended.
    pub(crate) fn load_runs(&self) -> Result<(), Problem> {
        for id in self.store.runs()? {
            let Some(text) = self.store.record(&RecordKey::Run(id.clone()))? else {
                // A run of the command line.
                continue;
            };
            let Ok(record) = serde_json::from_str::<RunRecord>(&text) else {
                continue;
            };
            let (state, end) = match self.run_log(&id) {
                Ok((_, events)) => end_of(&events),
                Err(problem) => (
                    RunState::Stopped,
                    Some(EndView {
                        done: false,
                        text: problem.message,
                        resumable: false,
                    }),
                ),
            };
            let run = HostedRun::new(record, Arc::clone(&self.feed), state);
            run.update(|view| view.end = end);
            self.hosted_runs().insert(id, Arc::new(run));
        }
        Ok(())
    }

    /// Gives a session that is read from its log the ends of runs that it has not taken before a server ended.
    pub(crate) fn settle_runs(&self, hosted: &Arc<Hosted>) -> Result<(), Problem> {
        let snapshot = hosted.snapshot();
        let Some(next) = snapshot.view.accepted.iter().find(|accepted| accepted.pending) else {
            return Ok(());
        };
        let is_done = |run: &&Arc<HostedRun>| {
            let record = run.record();
            let is_same =
                record.session == snapshot.view.id && record.number == next.number && record.plan == next.plan;
            is_same && run.view().state == RunState::Done && !run.view().dry_run
        };
        let run = self
            .hosted_runs()
            .values()
            .find(is_done)
            .map(|run| run.record().id.clone());
        let Some(run) = run else { return Ok(()) };
        let (_, events) = self.run_log(&run)?;
        let statements = events.iter().rev().find_map(|event| match event {
            Event::Observed { statements } => Some(statements.clone()),
            _ => None,
        });
        match statements {
            Some(statements) => hosted.run_ended(EndedRun {
                number: next.number,
                is_reached: true,
                statements,
            }),
            None => Ok(()),
        }
    }
}

/// Returns the state of a run by its log.
fn end_of(events: &[Event]) -> (RunState, Option<EndView>) {
    match events.last() {
        Some(Event::Done { .. }) => {
            let end = EndView {
                done: true,
                text: "the goal is reached in the observed world".to_owned(),
                resumable: false,
            };
            (RunState::Done, Some(end))
        }
        Some(Event::Stopped { why, .. }) => {
            let end = EndView {
                done: false,
                text: why.clone(),
                resumable: true,
            };
            (RunState::Stopped, Some(end))
        }
        Some(_) => (RunState::Interrupted, None),
        None => {
            let end = EndView {
                done: false,
                text: "the server ended before the run began; nothing has moved".to_owned(),
                resumable: false,
            };
            (RunState::Stopped, Some(end))
        }
    }
}
