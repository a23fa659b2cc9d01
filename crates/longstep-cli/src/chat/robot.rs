//! The robot of a conversation: `/run` and `/observe`.

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use anyhow::Result;
use longstep::session::{ObserveError, Observed};
use longstep_core::environment::{Observation, World};
use longstep_files::read_text;
use longstep_robot::{Opened, RunControl, RunHeader, RunLog, RunStart, Scope, StopRequest, drive};

use super::input::Lines;
use super::{Chat, screen};
use crate::arguments::ExecutionArguments;
use crate::failure::Failure;
use crate::output::{self, Style, counted, print_line, remark};
use crate::run::{self, Decide, Question, View};
use crate::show;
use crate::signals::{self, Armed};

/// The time for a run to end after SIGTERM, before the program ends in any case.
const GRACE: Duration = Duration::from_secs(5);

/// A robot that is open from its first use to the end of the conversation.
pub(super) struct ChatRobot<'a> {
    named: &'a str,
    arguments: &'a ExecutionArguments,
    /// Held by a run, and by SIGTERM, which closes the robot before it ends the program.
    opened: Arc<Mutex<Option<Opened>>>,
}

fn lock(opened: &Mutex<Option<Opened>>) -> MutexGuard<'_, Option<Opened>> {
    opened.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Closes the robot when the run under way has ended.
fn close(opened: &Mutex<Option<Opened>>) {
    let begun = Instant::now();
    while begun.elapsed() < GRACE {
        if let Ok(mut opened) = opened.try_lock() {
            drop(opened.take());
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

impl<'a> ChatRobot<'a> {
    pub(super) fn new(named: &'a str, arguments: &'a ExecutionArguments) -> Result<Self> {
        let opened: Arc<Mutex<Option<Opened>>> = Arc::default();
        let closing = Arc::clone(&opened);
        signals::end_with(move || close(&closing))
            .map_err(|error| Failure::unreadable(format!("cannot watch for signals: {error}")))?;
        Ok(Self {
            named,
            arguments,
            opened,
        })
    }

    /// Returns the robot, opened in a world if it is not open yet. The request stops it from then on.
    fn ready<'o>(
        &self,
        opened: &'o mut Option<Opened>,
        world: &World,
        request: &StopRequest,
    ) -> Result<&'o mut Opened> {
        let own = match opened.take() {
            // A dry run begins anew in the world of the conversation.
            Some(own) if !own.is_dry => {
                request.attach(own.robot.stop_switch());
                own
            }
            _ => run::open(self.named, world, self.arguments.live, request, RunStart::New)?,
        };
        Ok(opened.insert(own))
    }
}

/// The person at the prompt of the conversation.
struct Asked<'l> {
    lines: &'l mut Lines,
    request: StopRequest,
}

impl Decide for Asked<'_> {
    fn decide(&mut self, question: Question<'_>) -> Option<bool> {
        match self.lines.decide(question, &self.request) {
            Ok(decision) => decision,
            Err(error) => {
                remark!("{error}");
                None
            }
        }
    }
}

fn unfit(error: ObserveError) -> Failure {
    let hint = match &error {
        ObserveError::OutOfTurn(_) => "accept the plan, or cancel it with `/undo`, first",
        _ => "docs/guide/robots.md has the form of observations",
    };
    Failure::unreadable(error.to_string()).hint(hint)
}

impl Chat<'_> {
    fn robot(&self) -> Result<&ChatRobot<'_>> {
        self.robot.as_ref().ok_or_else(|| {
            let name = screen::session_name(self.folder.path());
            Failure::unreadable("this conversation has no robot")
                .hint(format!(
                    "begin with `longstep chat --robot sim`, or go on with: longstep chat --resume {name} --robot sim"
                ))
                .into()
        })
    }

    /// Carries out the accepted plans that no robot has carried out yet, until one of them stops.
    pub(super) fn run_plans(&mut self, lines: &mut Lines) -> Result<()> {
        self.robot()?;
        if self.session.proposal().is_some() || self.session.question().is_some() {
            return Err(Failure::unreadable("an instruction is in progress")
                .hint("accept its plan, or cancel it with `/undo`, first")
                .into());
        }
        let pending = self.session.pending();
        if pending.is_empty() {
            return Err(Failure::unreadable("the robot has carried out every accepted plan")
                .hint("give an instruction and accept its plan")
                .into());
        }
        for number in pending {
            if !self.run_plan(number, lines)? {
                break;
            }
        }
        Ok(())
    }

    /// Carries out one accepted plan; returns true if its goal is reached.
    fn run_plan(&mut self, number: usize, lines: &mut Lines) -> Result<bool> {
        let robot = self.robot()?;
        let shared = Arc::clone(&robot.opened);
        let mut opened = lock(&shared);
        let request = StopRequest::default();
        let armed = Armed::new(&request);
        let accepted = &self.session.accepted()[number];
        let plan = accepted.plan.clone();
        let own = robot.ready(&mut opened, self.session.robot_world(), &request)?;
        own.robot.begin_plan(plan.world());
        let aim = run::aim_of(accepted.goal.as_ref(), &accepted.before);
        let teach = "nothing has moved; begin again with `--skills FILE`";
        let mut execution = run::execution(robot.arguments, own, &plan, &aim, teach)?;
        let (body, is_dry) = (own.robot.as_mut(), own.is_dry);
        let path = run::new_log(self.folder.path(), "run")?;
        let header = RunHeader::new(robot.named, self.session.domain().origin.as_str()).with_dry_run(is_dry);
        let log = RunLog::create(&path, &header).map_err(|error| Failure::unreadable(error.to_string()))?;
        print_line!("{} {}", format!("Running plan {number}:").bold(), accepted.instruction);
        run::announce(&path, is_dry);
        let asked = Asked {
            lines,
            request: request.clone(),
        };
        // The person accepted the plan, and asked for the run.
        let mut view = View::new(log, asked, false, is_dry).of_approved();
        let before = self.session.robot_world().environment().clone();
        let stop = drive(&mut execution, body, &mut view, &RunControl::from(request.clone())).into_stop();
        view.end();
        drop((view, armed));
        if is_dry {
            run::end(&execution, stop.as_ref(), is_dry);
            show::hint("the plan still waits; begin again with `--live` to move the robot");
            return Ok(false);
        }
        let carried_out = self
            .session
            .carried_out(number, stop.is_none(), &execution.statements());
        carried_out.map_err(unfit)?;
        self.folder.keep(&mut self.session)?;
        run::end(&execution, stop.as_ref(), is_dry);
        if stop.is_some() {
            self.look_after_stop(&mut opened)?;
        }
        show::changes(&before, self.session.world().environment());
        output::blank();
        if stop.is_some() {
            show::hint("`/run` tries again from here; the next instruction begins in the world as it is now");
        }
        Ok(stop.is_none())
    }

    /// Observes the world after a run that stopped. A robot that the stop ended is opened again at its next use.
    fn look_after_stop(&mut self, opened: &mut Option<Opened>) -> Result<()> {
        let Some(own) = opened else {
            return Ok(());
        };
        let mut seen = own.robot.observe(&Scope::All);
        if seen.is_err() {
            // Nothing moves any more, whatever the robot confirms; the run has said so.
            let _ = own.robot.stop();
            *opened = own.revived();
            if let Some(again) = opened {
                seen = again.robot.observe(&Scope::All);
            }
        }
        match seen {
            Ok(observation) => {
                self.session.observed(&observation).map_err(unfit)?;
                self.folder.keep(&mut self.session)?;
            }
            Err(_) => screen::notice("The world may differ where the robot was under way; `/observe` looks again"),
        }
        Ok(())
    }

    /// Observes the world with the robot, or reads an observation from a file.
    pub(super) fn observe(&mut self, file: &str) -> Result<()> {
        let statements = match file {
            "" => self.observation()?,
            _ => observation_in(Path::new(file))?,
        };
        let observed = self.session.observed(&statements).map_err(unfit)?;
        // The observation is saved before it is reported.
        self.folder.keep(&mut self.session)?;
        self.tell_observed(&observed);
        Ok(())
    }

    fn tell_observed(&self, observed: &Observed) {
        screen::observed(observed);
        let left = self.session.pending().len();
        if left > 0 && self.robot.is_some() {
            let plans = counted(left, "accepted plan");
            screen::notice(&format!(
                "The robot has not carried out {plans}; `/run` does it from here"
            ));
        }
        let endings = self.session.endings();
        if !endings.is_empty() {
            screen::ended(&self.session, &endings);
        }
    }

    fn observation(&self) -> Result<Observation> {
        if self.robot.is_none() {
            return Err(Failure::unreadable("this conversation has no robot that could look")
                .hint("read an observation with `/observe FILE`, or begin with `--robot ROBOT`")
                .into());
        }
        let robot = self.robot()?;
        let mut opened = lock(&robot.opened);
        let request = StopRequest::default();
        let _armed = Armed::new(&request);
        let own = robot.ready(&mut opened, self.session.robot_world(), &request)?;
        if own.is_dry {
            return Err(
                Failure::unreadable("a dry run observes nothing: this robot is not a simulation")
                    .hint("begin again with `--live`, or read an observation with `/observe FILE`")
                    .into(),
            );
        }
        let body = own.robot.as_mut();
        run::observing(body)?;
        let seen = body.observe(&Scope::All);
        if seen.as_ref().is_err_and(longstep_robot::RobotError::is_final) {
            let _ = body.stop();
            *opened = own.revived();
        }
        Ok(seen.map_err(|error| run::robot_failure(&error))?)
    }
}

fn observation_in(path: &Path) -> Result<Observation> {
    let text = read_text(path)?;
    let read = serde_json::from_str(&text);
    Ok(read.map_err(|error| {
        Failure::unreadable(format!("{}: {error}", path.display())).hint(
            r#"an observation is like {"states": {"<cup>": "on_something(<shelf>)"}}; docs/guide/robots.md describes it"#,
        )
    })?)
}
