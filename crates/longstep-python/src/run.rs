//! Runs: a verified plan carried out on a robot, monitored and mended.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use longstep_core::environment::Observation;
use longstep_core::execution::{Approval, BeginError, Execution, Settings, Stop, Trust, Watch};
use longstep_robot::{
    Driven, Robot as _, RobotError, RunControl, RunHeader, RunLog, drive, observed_reports, preflight,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use serde_json::Value;

use crate::active::Active;
use crate::argument::{callable, class_of};
use crate::beside::{Beside, Callables};
use crate::control::Control;
use crate::failure::Failure;
use crate::interpreter::{Call, detach};
use crate::json;
use crate::plan::Plan;
use crate::robot::PythonRobot;
use crate::stopping::Raised;
use crate::world::World;

/// The wait between two looks at the control of a run that is paused.
const PAUSE: Duration = Duration::from_millis(20);

/// The end of a run. Immutable.
#[pyclass(frozen, module = "longstep")]
pub(crate) struct Run {
    world: Py<World>,
    stop: Option<String>,
    is_resumable: bool,
    changes: u32,
    events: String,
    /// The hash of the plan with which the run began.
    pub(crate) plan: String,
    /// The world after the run as far as it was seen, for a session.
    pub(crate) statements: Observation,
}

#[pymethods]
impl Run {
    /// True if the goal is reached in the observed world.
    #[getter]
    pub(crate) fn is_done(&self) -> bool {
        self.stop.is_none()
    }

    /// The reason of a stop; none if the goal is reached.
    #[getter]
    fn stopped(&self) -> Option<&str> {
        self.stop.as_deref()
    }

    /// True if `longstep run --resume` can continue the run from its log: there is one, and the reason of the stop does not
    /// speak against the plan.
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

    /// The events in order, as the lines of a log after its first one, without their times.
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

/// Carries out a verified plan on a robot; every step is compared with what the robot observes.
///
/// The rest of the plan is mended when the world differs, at most `changes` times. `ask` decides about the plan and its
/// changes (`approve="changes"`), or before every step as well (`"each-step"`); without it nothing moves unless `approve` is
/// `"never"`. The end needs facts that were `observed`, or takes the `promised` effects of steps. The robot observes after
/// `"each-step"`, or `"on-failure"` alone. `log` is a new file for the events.
///
/// `control` stops the run, and lets it wait, from other threads. `watch` takes every event as it happens, as a dict.
///
/// An exception of the robot, of `ask` or of `watch`, and Ctrl-C, stop the robot and are raised then; only `StepFailed` is a
/// failed step. An exception of the robot's `stop` is raised with the earlier one, or the reason of the stop, as its context.
/// Raises `TypeError` for anything but a verified plan, and `LongstepError` if the robot does not fit, or another run uses it,
/// before anything moves.
///
/// >>> world = longstep.World({"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
/// ...     "object_states": {"<pen>": "on_something(<desk>)"}})
/// >>> plan = longstep.solve(world, "put(pen, shelf)").verified()
/// >>> run = longstep.run(plan, longstep.Sim(world), approve="never")
/// >>> run.is_done, run.world.environment()["object_states"]
/// (True, {'<pen>': 'on_something(<shelf>)'})
#[pyfunction]
#[pyo3(signature = (
    plan, robot, /, *, approve="changes", ask=None, trust="observed", observe="each-step", changes=8, log=None, control=None,
    watch=None
))]
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
    control: Option<Bound<'_, Control>>,
    watch: Option<Py<PyAny>>,
) -> PyResult<Run> {
    let _call = Call::begin(py);
    let plan = plan.cast::<Plan>().map_err(|_| {
        let class = class_of(plan);
        PyTypeError::new_err(format!(
            "only a verified longstep.Plan is carried out, not {class}; `verify(...).verified()` returns one"
        ))
    })?;
    let plan = plan.get();
    let settings = settings(approve, trust, observe)?.with_changes(changes);
    let callables = Callables {
        ask: callable(py, ask, "ask")?,
        watch: callable(py, watch, "watch")?,
    };
    let object = robot;
    let mut robot = PythonRobot::new(object, plan.domain(), plan.plan.world())?;
    let control = control.map_or_else(|| Ok(RunControl::default()), |control| control.get().take())?;
    let _active = Active::begin(object, &control).ok_or_else(|| {
        Failure::failed("nothing has moved: another run uses this robot")
            .hint("wait until that run has ended, or stop it with `Control.stop`".to_owned())
    })?;
    let (raised, stopping) = (robot.raised(), Arc::clone(robot.stopping()));
    let is_logged = log.is_some();
    let done = detach(py, || -> Result<_, Failure> {
        let mut execution = begun(plan, &robot, settings)?;
        let log = log.map(|path| RunLog::create(&path, &RunHeader::new(robot.name(), plan.origin())));
        let log = log
            .transpose()
            .map_err(|error| Failure::unreadable(error.to_string()).hint("name a new file with `log`".to_owned()))?;
        let mut beside = Beside::new(plan, callables, log, raised.clone());
        let driven = driven(&mut execution, &mut robot, &mut beside, &control, &raised);
        Ok((execution, driven, beside.into_events()))
    });
    detach(py, || stopping.end());
    let (execution, stop, events) = done?;
    let reason = stop.as_ref().map(|stop| stop.sentence(execution.world()));
    if let Some(error) = raised.take(py, reason.as_deref())? {
        return Err(error);
    }
    Ok(Run {
        is_resumable: is_logged && stop.as_ref().is_some_and(Stop::is_resumable),
        stop: reason,
        changes: execution.changes(),
        world: Py::new(py, plan.world_of(execution.after()))?,
        events: Value::from(events).to_string(),
        plan: plan.hash(),
        statements: execution.statements(),
    })
}

/// Drives an execution to its end, through the pauses of its control. Returns the reason of a stop.
fn driven(
    execution: &mut Execution,
    robot: &mut PythonRobot,
    beside: &mut Beside,
    control: &RunControl,
    raised: &Raised,
) -> Option<Stop> {
    // A request that came before the run stops it here, before anything moves.
    control.stop_request().attach(robot.stop_switch());
    if !control.is_stop_requested() {
        robot.begin_plan(execution.world());
    }
    loop {
        match drive(execution, robot, beside, control) {
            Driven::Paused => {
                while control.is_pause_requested() && !control.is_stop_requested() {
                    robot.wait(PAUSE);
                    // Ctrl-C; it has stopped the robot.
                    if raised.is_kept() {
                        control.stop();
                    }
                }
            }
            ended => return ended.into_stop(),
        }
    }
}

/// Begins the execution of a plan on a robot that understands every step. Nothing has moved when this fails.
fn begun(plan: &Plan, robot: &PythonRobot, settings: Settings) -> Result<Execution, Failure> {
    let world = plan.plan.world();
    let reports = observed_reports(robot, world).map_err(|error| {
        let hint = error.hint().map(str::to_owned);
        Failure::failed(error.to_string()).hint(hint.or_else(|| robot.hint_about_events(world)))
    })?;
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
