//! One run from its beginning to its end, on the thread of its robot.

use std::sync::Arc;

use longstep_core::environment::World;
use longstep_core::execution::{Aim, Event, Execution, Resumed, Stop};
use longstep_core::verify::VerifiedPlan;
use longstep_robot::{Opened, RunHeader, RunStart, check_resumed, preflight};

use super::hosted::HostedRun;
use super::robots::RobotEntry;
use super::view::{EndView, RunState};
use super::watch::Watching;
use crate::audit::{Audit, Deed};
use crate::hosted::EndedRun;
use crate::problem::Problem;
use crate::store::Durability;

/// A run that waits for its robot.
pub(crate) struct Task {
    pub(crate) run: Arc<HostedRun>,
    pub(crate) entry: RobotEntry,
    pub(crate) audit: Audit,
    pub(crate) start: Start,
}

/// How a run begins.
pub(crate) enum Start {
    /// With a plan that was approved.
    Plan {
        plan: Box<VerifiedPlan>,
        aim: Aim,
        /// The domain as a log names it.
        domain: String,
    },
    /// From the log of a run that was interrupted; with the world of its beginning.
    Log { events: Vec<Event>, world: Box<World> },
}

/// An execution that has begun.
pub(crate) struct Begun {
    pub(crate) execution: Execution,
    is_dry: bool,
    /// True if its plan was approved, and not a rest of it.
    is_approved: bool,
}

impl Task {
    pub(crate) fn run(&self) -> &Arc<HostedRun> {
        &self.run
    }

    /// Returns the world in which the run begins.
    pub(crate) fn world(&self) -> &World {
        match &self.start {
            Start::Plan { plan, .. } => plan.world(),
            Start::Log { world, .. } => world,
        }
    }

    /// Opens the robot.
    pub(super) fn open(&self) -> Result<Opened, Problem> {
        self.run.update(|view| view.state = RunState::Opening);
        let request = self.run.control().stop_request();
        let start = match &self.start {
            Start::Plan { .. } => RunStart::New,
            Start::Log { events, .. } => RunStart::of_log(events),
        };
        let opened = (self.entry.open)(self.world(), request, start)?;
        request.attach(opened.robot.stop_switch());
        Ok(opened)
    }

    /// Begins the execution on a robot, and its log.
    pub(super) fn begin(&self, opened: &Opened) -> Result<Begun, Problem> {
        let Opened { is_dry, autonomy, .. } = opened;
        let (robot, is_dry) = (opened.robot.as_ref(), *is_dry);
        let execution = match &self.start {
            Start::Plan { plan, aim, domain } => {
                let mut settings = self.entry.settings_in(plan.world(), robot, autonomy)?;
                if is_dry {
                    settings = settings.for_dry_run();
                }
                preflight(robot, plan, &settings.skills).map_err(|error| Problem::conflict(error.to_string()))?;
                let execution =
                    Execution::new(plan, aim, settings).map_err(|error| Problem::conflict(error.to_string()))?;
                let header = RunHeader::new(&self.entry.reference, domain).with_dry_run(is_dry);
                let line = serde_json::to_string(&header).unwrap_or_default() + "\n";
                self.run.rights()?.log.append(&line, Durability::Now)?;
                execution
            }
            Start::Log { events, world } => {
                if is_dry {
                    return Err(Problem::conflict("an interrupted run goes on for real only"));
                }
                let resumed = Execution::resume(world.domain(), events, Resumed::default());
                let execution = resumed.map_err(|error| Problem::conflict(error.to_string()))?;
                check_resumed(&execution, robot)?;
                execution
            }
        };
        self.run.update(|view| view.dry_run = is_dry);
        Ok(Begun {
            execution,
            is_dry,
            is_approved: matches!(self.start, Start::Plan { .. }),
        })
    }

    pub(super) fn watcher(&self, begun: &Begun) -> Watching<'_> {
        Watching::new(&self.run, &begun.execution, begun.is_approved)
    }

    /// Ends a run that did not begin: nothing has moved.
    pub(super) fn end_unbegun(&self, why: &str) {
        self.finish(EndView {
            done: false,
            text: format!("{why}; nothing has moved"),
            resumable: matches!(self.start, Start::Log { .. }),
        });
    }

    /// Ends a run: the session goes on in the observed world.
    pub(super) fn end(&self, begun: &Begun, stop: Option<&Stop>) {
        let execution = &begun.execution;
        if !begun.is_dry {
            let ended = EndedRun {
                number: self.run.record().number,
                is_reached: stop.is_none(),
                statements: execution.statements(),
            };
            let rights = self.run.rights().map_err(Problem::from);
            let ended = rights.and_then(|rights| rights.session.run_ended(ended));
            if let Err(problem) = ended {
                self.run.update(|view| view.notices.push(problem.message));
            }
        }
        let text = match stop {
            Some(stop) => stop.sentence(execution.world()),
            None if begun.is_dry => "the plan would reach the goal; nothing was sent".to_owned(),
            None if execution.rests_on_promises() => {
                "the goal is reached if what was not shown is as promised".to_owned()
            }
            None => "the goal is reached in the observed world".to_owned(),
        };
        self.finish(EndView {
            done: stop.is_none(),
            text,
            resumable: !begun.is_dry && stop.is_some_and(Stop::is_resumable),
        });
    }

    fn finish(&self, end: EndView) {
        let record = self.run.record();
        let deed = Deed::Ended {
            run: record.id.clone(),
            end: if end.done { "done".to_owned() } else { end.text.clone() },
        };
        let noted = self.audit.add(&record.by, deed);
        // Before the end is shown: another server may go on with the session then.
        self.run.give_back();
        self.run.update(|view| {
            view.state = if end.done { RunState::Done } else { RunState::Stopped };
            view.question = None;
            view.feedback = None;
            view.end = Some(end);
            view.notices.extend(noted.err().map(|problem| problem.message));
        });
    }
}
