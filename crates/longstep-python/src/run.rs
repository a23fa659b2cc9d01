//! Runs: a verified plan carried out on a robot, monitored and mended.

use std::path::PathBuf;

use longstep_core::domain::phrase;
use longstep_core::execution::{
    Approval, BeginError, Event, Execution, Proposal, Settings, StepOrder, Stop, Subject, Trust, Unseen, Watch,
};
use longstep_core::plan::outline;
use longstep_robot::{
    Driven, Robot as _, RobotError, RunControl, RunHeader, RunLog, Watcher, drive, observed_reports, preflight,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use serde::Serialize;
use serde_json::Value;

use crate::failure::Failure;
use crate::json;
use crate::plan::{Plan, quoted};
use crate::robot::{PythonRobot, Raised};
use crate::world::World;

/// The end of a run. Immutable.
#[pyclass(frozen, module = "longstep")]
pub(crate) struct Run {
    world: Py<World>,
    stop: Option<String>,
    is_resumable: bool,
    changes: u32,
    events: String,
}

#[pymethods]
impl Run {
    /// True if the goal is reached in the observed world.
    #[getter]
    fn is_done(&self) -> bool {
        self.stop.is_none()
    }

    /// The reason of a stop; none if the goal is reached.
    #[getter]
    fn stopped(&self) -> Option<&str> {
        self.stop.as_deref()
    }

    /// True if `longstep run --resume` can continue the run from its log.
    #[getter]
    fn is_resumable(&self) -> bool {
        self.is_resumable
    }

    /// The number of changes of the plan.
    #[getter]
    fn changes(&self) -> u32 {
        self.changes
    }

    /// The world after the run, as far as it is known.
    #[getter]
    fn world(&self, py: Python<'_>) -> Py<World> {
        self.world.clone_ref(py)
    }

    /// The events in order, as the log of a run has them.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::parse(py, &self.events)
    }

    fn __repr__(&self) -> String {
        match &self.stop {
            None => "<longstep.Run done>".to_owned(),
            Some(why) => format!("<longstep.Run stopped: {why}>"),
        }
    }
}

/// The person and the log beside a run.
struct Beside {
    ask: Option<Py<PyAny>>,
    log: Option<RunLog>,
    events: Vec<Value>,
    /// The steps and the edits of the last change.
    change: (Vec<String>, Vec<String>),
    /// The words of the instruction that the plan ignores.
    left_out: Vec<String>,
    raised: Raised,
}

/// A question to the person.
#[derive(Serialize, Default)]
struct Question<'a> {
    kind: &'a str,
    text: String,
    steps: &'a [String],
    edits: &'a [String],
    left_out: &'a [String],
}

impl<'a> Question<'a> {
    /// Returns a question without lists.
    fn of(kind: &'a str, text: impl Into<String>) -> Self {
        Self {
            kind,
            text: text.into(),
            ..Self::default()
        }
    }
}

impl Beside {
    /// Asks the person; none without an answer.
    fn ask(&self, question: &Question<'_>) -> Option<bool> {
        let ask = self.ask.as_ref()?;
        let answer = Python::attach(|py| {
            let answer = ask.bind(py).call1((json::object(py, question)?,))?;
            answer.extract::<bool>()
        });
        answer.map_err(|error| self.raised.keep(error)).ok()
    }
}

impl Watcher for Beside {
    fn record(&mut self, _: &Execution, events: &[Event]) -> Result<(), String> {
        if let Some(log) = &mut self.log {
            log.append(events).map_err(|error| error.to_string())?;
        }
        for event in events {
            if let Event::Changed { steps, edits, .. } = event {
                self.change = (steps.clone(), edits.clone());
            }
            self.events
                .push(serde_json::to_value(event).map_err(|error| error.to_string())?);
        }
        Ok(())
    }

    fn approve(&mut self, execution: &Execution, proposal: &Proposal) -> Option<bool> {
        match &proposal.subject {
            Subject::Plan => {
                let plan = execution.plan();
                let rest = execution.cursor().rest();
                let lines = outline(plan.world(), rest.as_ref().map_or(plan.plan(), |rest| &rest.plan)).into_iter();
                let line = |own: longstep_core::plan::OutlineLine| own.step.map_or(own.text, |_| own.explanation);
                let steps: Vec<String> = lines.map(line).collect();
                let text = match &self.left_out[..] {
                    [] => "Go on with this plan?".to_owned(),
                    words => format!("Go on with this plan? It leaves out {}.", quoted(words)),
                };
                self.ask(&Question {
                    steps: &steps,
                    left_out: &self.left_out,
                    ..Question::of("plan", text)
                })
            }
            Subject::Change(_) => self.ask(&Question {
                steps: &self.change.0,
                edits: &self.change.1,
                ..Question::of("change", "Go on with this change?")
            }),
            Subject::Step(order) => {
                let text = format!("Do this step: {}?", phrase(&order.explanation));
                self.ask(&Question::of("step", text))
            }
            _ => None,
        }
    }

    fn judge(&mut self, _: &Execution, order: &StepOrder) -> Option<bool> {
        let step = phrase(&order.explanation);
        let text = format!("This step was under way when the run was interrupted: {step}. Was it done?");
        self.ask(&Question::of("judge", text))
    }

    fn confirm(&mut self, _: &Execution, unseen: &Unseen) -> Option<bool> {
        let text = format!("Nobody has seen it: {}. Is it so?", unseen.what);
        self.ask(&Question::of("confirm", text))
    }
}

/// Carries out a verified plan on a robot; every step is compared with what the robot observes.
///
/// The rest of the plan is mended when the world differs, at most `changes` times. `ask` decides about the plan and its
/// changes (`approve="changes"`), or before every step as well (`"each-step"`); without it nothing moves unless `approve` is
/// `"never"`. The end needs facts that were `observed`, or takes the `promised` effects of steps. The robot observes after
/// `"each-step"`, or `"on-failure"` alone. `log` is a new file for the events.
///
/// An exception of the robot or of `ask`, and Ctrl-C, stop the robot and are raised then; only `StepFailed` is a failed step.
/// Raises `TypeError` for anything but a verified plan, and `LongstepError` if the robot does not fit, before anything moves.
///
/// >>> world = longstep.World({"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
/// ...     "object_states": {"<pen>": "on_something(<desk>)"}})
/// >>> plan = longstep.solve(world, "put(pen, shelf)").verified()
/// >>> run = longstep.run(plan, longstep.Sim(world), approve="never")
/// >>> run.is_done, run.world.environment()["object_states"]
/// (True, {'<pen>': 'on_something(<shelf>)'})
#[pyfunction]
#[pyo3(signature = (plan, robot, /, *, approve="changes", ask=None, trust="observed", observe="each-step", changes=8, log=None))]
#[allow(clippy::too_many_arguments, reason = "keyword-only options of Python")]
pub(crate) fn run(
    py: Python<'_>,
    plan: &Bound<'_, PyAny>,
    robot: &Bound<'_, PyAny>,
    approve: &str,
    ask: Option<Py<PyAny>>,
    trust: &str,
    observe: &str,
    changes: u32,
    log: Option<PathBuf>,
) -> PyResult<Run> {
    let plan = plan.cast::<Plan>().map_err(|_| {
        let class = plan
            .get_type()
            .name()
            .map_or_else(|_| "?".to_owned(), |name| name.to_string());
        PyTypeError::new_err(format!(
            "only a verified longstep.Plan is carried out, not {class}; `verify(...).verified()` returns one"
        ))
    })?;
    let plan = plan.get();
    let settings = settings(approve, trust, observe)?.with_changes(changes);
    let mut robot = PythonRobot::new(robot, plan.domain())?;
    let raised = robot.raised();
    let name = robot.name().to_owned();
    let done = py.detach(|| -> Result<_, Failure> {
        let mut execution = begun(plan, &robot, settings)?;
        let log = log.map(|path| RunLog::create(&path, &RunHeader::new(&name, plan.origin())));
        let mut beside = Beside {
            ask,
            log: log.transpose().map_err(|error| {
                Failure::unreadable(error.to_string()).hint("name a new file with `log`".to_owned())
            })?,
            events: Vec::new(),
            change: Default::default(),
            left_out: plan.left_out(),
            raised: raised.clone(),
        };
        robot.begin_plan(plan.plan.world());
        let control = RunControl::of(&robot);
        let driven = drive(&mut execution, &mut robot, &mut beside, &control);
        Ok((execution, driven, beside.events))
    });
    if let Some(error) = raised.take() {
        return Err(error);
    }
    let (execution, driven, events) = done?;
    let stop = match driven {
        Driven::Stopped(stop) => Some(stop),
        Driven::Done | Driven::Paused => None,
    };
    Ok(Run {
        is_resumable: stop.as_ref().is_some_and(Stop::is_resumable),
        stop: stop.map(|stop| stop.sentence(execution.world())),
        changes: execution.changes(),
        world: Py::new(py, plan.world_of(execution.after()))?,
        events: Value::from(events).to_string(),
    })
}

/// Begins the execution of a plan on a robot that understands every step. Nothing has moved when this fails.
fn begun(plan: &Plan, robot: &PythonRobot, settings: Settings) -> Result<Execution, Failure> {
    let world = plan.plan.world();
    let reports = observed_reports(robot, world)
        .map_err(|error| Failure::failed(error.to_string()).hint(error.hint().map(str::to_owned)))?;
    let settings = settings.with_reports(reports);
    robot.check_senses(&plan.plan)?;
    let unfit = |error: RobotError| Failure::failed(error.to_string()).hint(error.hint().map(str::to_owned));
    preflight(robot, &plan.plan, &settings.skills).map_err(unfit)?;
    Execution::new(&plan.plan, &plan.aim(), settings).map_err(refused)
}

/// Returns the failure for a plan that is not carried out.
fn refused(error: BeginError) -> Failure {
    match error {
        BeginError::Goal(error) => error.into(),
        error => Failure::failed(format!("nothing has moved: {error}")),
    }
}

fn settings(approve: &str, trust: &str, observe: &str) -> PyResult<Settings> {
    let wrong = |option: &str, value: &str, values: &str| {
        Err(PyValueError::new_err(format!(
            "{option} must be {values}, not {value:?}"
        )))
    };
    let approval = match approve {
        "never" => Approval::Never,
        "changes" => Approval::Changes,
        "each-step" => Approval::EachStep,
        other => return wrong("approve", other, "\"never\", \"changes\" or \"each-step\""),
    };
    let trust = match trust {
        "observed" => Trust::Observed,
        "promised" => Trust::Promised,
        other => return wrong("trust", other, "\"observed\" or \"promised\""),
    };
    let watch = match observe {
        "each-step" => Watch::EachStep,
        "on-failure" => Watch::OnFailure,
        other => return wrong("observe", other, "\"each-step\" or \"on-failure\""),
    };
    Ok(Settings::default()
        .with_approval(approval)
        .with_trust(trust)
        .with_watch(watch))
}
