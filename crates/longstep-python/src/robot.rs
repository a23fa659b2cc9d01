//! A Python object as a robot.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use longstep::domain::Domain as LoadedDomain;
use longstep_core::environment::{Observation, World as ReadWorld};
use longstep_core::verify::VerifiedPlan;
use longstep_robot::{Description, Handle, Order, Progress, Robot, RobotError, Scope, StopSwitch};
use pyo3::exceptions::{PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};

use crate::failure::Failure;
use crate::json;
use crate::world::World;

/// Returns the exception for a step that failed and leaves the robot usable.
pub(crate) fn step_failed(py: Python<'_>, reason: &str) -> PyErr {
    let raise = || py.import("longstep._errors")?.getattr("StepFailed")?.call1((reason,));
    match raise() {
        Ok(exception) => PyErr::from_value(exception),
        Err(_) => PyRuntimeError::new_err(reason.to_owned()),
    }
}

/// The first exception of a robot; it ends the run and is raised after it.
#[derive(Clone, Default)]
pub(crate) struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    /// Keeps an exception, unless there is one already.
    pub(crate) fn keep(&self, error: PyErr) {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .get_or_insert(error);
    }

    /// Takes the exception.
    pub(crate) fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// A robot in Python: `perform(action, *arguments)`, `observe()` and `stop()`, and `sense(outcomes, action, *arguments)` if
/// plans sense.
///
/// A step is performed within the call, in the thread that carries the plan out. So the robot needs no locks, and Ctrl-C is
/// raised in its code, or between two steps.
pub(crate) struct PythonRobot {
    robot: Py<PyAny>,
    /// The domain of the plan.
    domain: Arc<LoadedDomain>,
    description: Description,
    orders: u64,
    /// The ends of orders that were not polled yet.
    ended: BTreeMap<Handle, Progress>,
    halted: Arc<AtomicBool>,
    is_stopped: bool,
    raised: Raised,
}

impl PythonRobot {
    /// Takes a robot. Its attribute `reports`, if it has one, names the predicates that it reports besides states. A method
    /// `begin_plan` says that it counts events anew with each plan.
    pub(crate) fn new(robot: &Bound<'_, PyAny>, domain: &Arc<LoadedDomain>) -> PyResult<Self> {
        for method in ["perform", "observe", "stop"] {
            if !robot.getattr_opt(method)?.is_some_and(|own| own.is_callable()) {
                let class = robot.get_type().name()?;
                return Err(PyTypeError::new_err(format!(
                    "a robot needs a method `{method}`, which {class} lacks"
                )));
            }
        }
        let mut description = Description::new(&robot.get_type().name()?.to_string());
        description.observes = true;
        if let Some(reports) = robot.getattr_opt("reports")? {
            description.reports = reports.extract()?;
        }
        description.counts_events = robot.hasattr("begin_plan")?;
        Ok(Self {
            robot: robot.clone().unbind(),
            domain: Arc::clone(domain),
            description,
            orders: 0,
            ended: BTreeMap::new(),
            halted: Arc::default(),
            is_stopped: false,
            raised: Raised::default(),
        })
    }

    /// Returns the place of the exception that ends a run.
    pub(crate) fn raised(&self) -> Raised {
        self.raised.clone()
    }

    /// Returns the name of the robot's class.
    pub(crate) fn name(&self) -> &str {
        &self.description.name
    }

    /// Checks that the robot senses if the plan does.
    pub(crate) fn check_senses(&self, plan: &VerifiedPlan) -> Result<(), Failure> {
        let domain = plan.world().domain();
        let mut sensing = plan.steps().iter().map(|step| domain.action(step.action));
        let Some(action) = sensing.find(|action| !action.senses.is_empty()) else {
            return Ok(());
        };
        let senses = Python::attach(|py| self.robot.bind(py).hasattr("sense").unwrap_or(false));
        if senses {
            return Ok(());
        }
        let message = format!(
            "the plan senses (`{}`), and the robot has no method `sense`",
            action.name
        );
        Err(Failure::failed(message)
            .hint("add `sense(outcomes, action, *arguments)`, which returns one of the outcomes".to_owned()))
    }

    fn check(&self) -> Result<(), RobotError> {
        if self.halted.load(Ordering::SeqCst) {
            Err(RobotError::Stopped)
        } else {
            Ok(())
        }
    }

    /// Keeps an exception, stops the robot, and returns the error for the run.
    fn fail(&mut self, error: PyErr) -> RobotError {
        let reason = error.to_string();
        self.raised.keep(error);
        drop(self.stop());
        RobotError::Gone {
            reason,
            messages: String::new(),
        }
    }

    fn perform(&self, order: &Order) -> PyResult<Progress> {
        Python::attach(|py| {
            py.check_signals()?;
            let robot = self.robot.bind(py);
            let words = std::iter::once(&order.action).chain(&order.arguments);
            let words = words.map(|word| PyString::new(py, word).into_any());
            let senses = !order.outcomes.is_empty();
            let mut arguments: Vec<Bound<'_, PyAny>> = words.collect();
            if senses {
                arguments.insert(0, order.outcomes.clone().into_pyobject(py)?.into_any());
            }
            let method = if senses { "sense" } else { "perform" };
            match robot.call_method1(method, PyTuple::new(py, arguments)?) {
                Ok(returned) if senses => sensed(&returned, &order.outcomes),
                Ok(returned) => performed(&returned),
                Err(error) => failed(py, error),
            }
        })
    }
}

/// Returns the end of a step without outcomes.
fn performed(returned: &Bound<'_, PyAny>) -> PyResult<Progress> {
    if returned.is_none() {
        return Ok(Progress::Done { outcome: None });
    }
    // A robot that returns False for a failure must not count as one that has performed the step.
    Err(PyTypeError::new_err(
        "`perform` must return None; raise `longstep.StepFailed(reason)` for a step that failed",
    ))
}

/// Returns the end of a sensing step.
fn sensed(returned: &Bound<'_, PyAny>, outcomes: &[String]) -> PyResult<Progress> {
    let text: String = returned.extract()?;
    let outcome = outcomes.iter().position(|outcome| *outcome == text);
    if outcome.is_none() {
        let expected = outcomes.join(", ");
        return Err(PyValueError::new_err(format!(
            "`sense` must return one of {expected}, not `{text}`"
        )));
    }
    Ok(Progress::Done { outcome })
}

/// Returns the end of a step that raised an exception: `StepFailed` leaves the robot usable.
fn failed(py: Python<'_>, error: PyErr) -> PyResult<Progress> {
    let class = py.import("longstep._errors")?.getattr("StepFailed")?;
    if error.matches(py, class)? {
        return Ok(Progress::Failed {
            reason: error.value(py).to_string(),
        });
    }
    Err(error)
}

impl Robot for PythonRobot {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn start(&mut self, order: &Order) -> Result<Handle, RobotError> {
        self.check()?;
        let end = self.perform(order).map_err(|error| self.fail(error))?;
        self.orders += 1;
        let handle = Handle::new(self.orders);
        self.ended.insert(handle, end);
        Ok(handle)
    }

    fn poll(&mut self, handle: Handle) -> Result<Progress, RobotError> {
        self.check()?;
        self.ended.remove(&handle).ok_or(RobotError::UnknownHandle(handle))
    }

    fn observe(&mut self, _: &Scope) -> Result<Observation, RobotError> {
        self.check()?;
        let seen = Python::attach(|py| {
            py.check_signals()?;
            json::text(&self.robot.bind(py).call_method0("observe")?)
        });
        let text = seen.map_err(|error| self.fail(error))?;
        serde_json::from_str(&text).map_err(|error| {
            let form =
                "`observe` must return {\"states\": {\"<cup>\": [\"on_something(<desk>)\"]}}, as in an environment";
            self.fail(PyValueError::new_err(format!("{form}: {error}")))
        })
    }

    fn stop(&mut self) -> Result<(), RobotError> {
        self.halted.store(true, Ordering::SeqCst);
        if std::mem::replace(&mut self.is_stopped, true) {
            return Ok(());
        }
        let stopped = Python::attach(|py| self.robot.bind(py).call_method0("stop").map(|_| ()));
        stopped.map_err(|error| {
            let reason = error.to_string();
            self.raised.keep(error);
            RobotError::Refused {
                method: "stop".to_owned(),
                reason,
            }
        })
    }

    fn stop_switch(&self) -> StopSwitch {
        let halted = Arc::clone(&self.halted);
        // The driver of the run calls `stop` of the robot, in its own thread.
        StopSwitch::new(move || halted.store(true, Ordering::SeqCst))
    }

    fn begin_plan(&mut self, world: &ReadWorld) {
        if self.description.counts_events {
            let world = World {
                world: world.clone(),
                domain: Arc::clone(&self.domain),
            };
            let begun = Python::attach(|py| self.robot.bind(py).call_method1("begin_plan", (world,)).map(|_| ()));
            if let Err(error) = begun {
                self.fail(error);
            }
        }
    }

    fn wait(&mut self, limit: Duration) {
        std::thread::sleep(limit);
        if let Err(error) = Python::attach(|py| py.check_signals()) {
            self.fail(error);
        }
    }
}
