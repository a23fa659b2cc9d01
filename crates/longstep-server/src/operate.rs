//! Approvals used, and runs begun, paused, continued and stopped.

use std::sync::Arc;
use std::time::Duration;

use longstep_core::environment;
use longstep_core::execution::{Aim, Event};
use longstep_core::json;

use crate::approval::{Approval, Approved};
use crate::audit::Deed;
use crate::hosted::Held;
use crate::hub::Hub;
use crate::id::{ApprovalId, RunId, SessionId};
use crate::problem::Problem;
use crate::run::{EndView, HostedRun, Rights, RobotEntry, RunRecord, RunState, RunView, Start, Task};
use crate::store::{LogName, StoreError};
use crate::view::{accepted_hash, goal_of};

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
        let snapshot = self.seen(id)?.snapshot();
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
        let held = self.held(&approval.session)?;
        let _beginning = self.beginning.lock(&approval.session);
        self.refuse_during_run(&approval.session)?;
        let snapshot = held.snapshot();
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
        // First: a robot of another server must not use up the approval.
        let rights = self.rights(&run, &entry, held)?;
        self.approvals.consume(&approval, &subject, &run, by)?;
        let number = snapshot
            .view
            .accepted
            .iter()
            .find(|own| own.pending)
            .map_or(0, |own| own.number);
        let record = RunRecord {
            id: run,
            session: approval.session.clone(),
            number,
            plan: approval.plan.clone(),
            approval: approval.id.clone(),
            robot: entry.name.clone(),
            by: by.to_owned(),
            instruction: accepted.instruction.clone(),
            urgent,
        };
        self.keep_record(&record)?;
        let start = Start::Plan {
            plan: Box::new(accepted.plan.clone()),
            aim: Aim::from((!goal_of(accepted).is_empty()).then(|| goal_of(accepted).join(" & "))),
            domain: accepted.before.domain().name.clone(),
        };
        self.queue(HostedRun::begin(record, Arc::clone(&self.feed), rights), entry, start)
    }

    /// Takes the rights that a run needs.
    fn rights(&self, run: &RunId, entry: &RobotEntry, session: Held) -> Result<Rights, Problem> {
        let body = Self::body(entry, session.id());
        let robot = self
            .queues
            .right(&body, || self.store.own(&LogName::Robot(body.clone())))?;
        let log = self.store.own(&LogName::Run(run.clone()))?.into();
        Ok(Rights { log, robot, session })
    }

    fn queue(&self, run: HostedRun, entry: RobotEntry, start: Start) -> Result<Arc<RunView>, Problem> {
        let run = Arc::new(run);
        let body = Self::body(&entry, &run.record().session);
        self.keep_run(Arc::clone(&run));
        let task = Task {
            run: Arc::clone(&run),
            entry,
            audit: self.audit.clone(),
            start,
        };
        run.update(|_| {});
        let queued = self.queues.add(&body, task);
        if let Err(problem) = &queued {
            run.give_back();
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

    /// Answers the question of a run. For a proposal, `question` is the hash that the person saw.
    ///
    /// # Errors
    ///
    /// The run asks something else, or nothing.
    pub fn decide(&self, id: &RunId, question: &str, yes: bool, by: &str) -> Result<Arc<RunView>, Problem> {
        let run = self.here(id)?;
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

    /// Returns a run that this server can control.
    fn here(&self, id: &RunId) -> Result<Arc<HostedRun>, Problem> {
        let run = self.hosted_run(id)?;
        if run.is_elsewhere() {
            return Err(StoreError::Taken(LogName::Run(id.clone()).words()).into());
        }
        Ok(run)
    }

    fn going(&self, id: &RunId) -> Result<Arc<HostedRun>, Problem> {
        let run = self.here(id)?;
        if run.view().state.is_ended() {
            return Err(Problem::conflict("the run has ended"));
        }
        Ok(run)
    }

    /// Stops a run: the robot before anything else. Waits for nothing, unless another server carries the run out: that one
    /// gets the stop through the store. A run that has ended is no error.
    ///
    /// # Errors
    ///
    /// There is no such run. That the audit log could not be written is said after the robot was stopped.
    pub fn stop(&self, id: &RunId, by: &str) -> Result<Arc<RunView>, Problem> {
        let run = self.hosted_run(id)?;
        run.control().stop();
        if run.is_elsewhere() {
            self.stop_elsewhere(id, run.epoch())?;
        }
        self.audit.add(by, Deed::Stopped { run: Some(id.clone()) })?;
        Ok(run.view())
    }

    /// Stops all robots, before anything else; those of other servers through the store. Returns the number of runs that
    /// were going on.
    ///
    /// # Errors
    ///
    /// That the audit log could not be written, or that other servers could not be reached, is said after the robots of
    /// this one were stopped.
    pub fn stop_all(&self, by: &str) -> Result<usize, Problem> {
        let here = self.stop_here();
        let elsewhere = self.stop_all_elsewhere();
        self.audit.add(by, Deed::Stopped { run: None })?;
        Ok(here + elsewhere?)
    }

    /// Stops the robots of this server; returns the number of runs that were going on.
    pub(crate) fn stop_here(&self) -> usize {
        let going = self.going_here();
        going.iter().for_each(|run| run.control().stop());
        going.len()
    }

    /// Takes up an interrupted run from its log, on the same robot.
    ///
    /// # Errors
    ///
    /// The run is not interrupted, or its log cannot be read.
    pub fn resume(&self, id: &RunId, by: &str) -> Result<Arc<RunView>, Problem> {
        let run = self.here(id)?;
        let view = run.view();
        let is_resumable = view.state == RunState::Interrupted || view.end.as_ref().is_some_and(|end| end.resumable);
        if !view.state.is_ended() || !is_resumable {
            return Err(Problem::conflict("the run cannot be resumed"));
        }
        let record = run.record().clone();
        let _beginning = self.beginning.lock(&record.session);
        let held = self.held(&record.session)?;
        self.refuse_during_run(&record.session)?;
        let snapshot = held.snapshot();
        let next = snapshot.view.accepted.iter().find(|accepted| accepted.pending);
        if !next.is_some_and(|next| next.number == record.number && next.plan == record.plan) {
            return Err(
                Problem::conflict("the plan of the run does not wait for a robot any more")
                    .hint("it was undone, or carried out by another run"),
            );
        }
        let entry = self.robot(&record.robot)?.clone();
        // From here on nobody else adds to the log.
        let rights = self.rights(id, &entry, held)?;
        let (header, events) = self.run_log(id)?;
        let planner = self.domains.planner(&header.domain)?;
        let Some(Event::Began { environment, .. }) = events.first() else {
            return Err(Problem::conflict("the log of the run has no beginning"));
        };
        let world = environment::read(planner.domain(), environment, "the log", "", &json::Path::default());
        let world = world.map_err(|error| Problem::conflict(error.to_string()))?;
        self.audit.add(by, Deed::Continued { run: id.clone() })?;
        let run = HostedRun::begin(record, Arc::clone(&self.feed), rights);
        let world = Box::new(world);
        self.queue(run, entry, Start::Log { events, world })
    }
}
