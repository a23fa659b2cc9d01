//! A Python object as a robot.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use longstep::domain::Domain as LoadedDomain;
use longstep_core::environment::{Observation, World as ReadWorld};
use longstep_core::model::PredicateId;
use longstep_core::verify::VerifiedPlan;
use longstep_robot::{Description, Handle, Order, Progress, Robot, RobotError, Scope, StopSwitch};
use pyo3::exceptions::{PyException, PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};

use crate::argument::{class_of, strings};
use crate::failure::Failure;
use crate::interpreter::attach;
use crate::observation::{self, Source};
use crate::stopping::{Raised, Stopping};
use crate::world::World;

/// Returns the exception for a step that failed and leaves the robot usable.
pub(crate) fn step_failed(py: Python<'_>, reason: &str) -> PyErr {
    let raise = || py.import("longstep._errors")?.getattr("StepFailed")?.call1((reason,));
    match raise() {
        Ok(exception) => PyErr::from_value(exception),
        Err(_) => PyRuntimeError::new_err(reason.to_owned()),
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
    /// The world before the plan, with all entities.
    world: ReadWorld,
    stopping: Arc<Stopping>,
    raised: Raised,
}

impl PythonRobot {
    /// Takes a robot. Its attribute `reports`, if it has one, names the predicates that it reports besides states. A method
    /// `begin_plan` says that it counts events anew with each plan.
    pub(crate) fn new(robot: &Bound<'_, PyAny>, domain: &Arc<LoadedDomain>, world: &ReadWorld) -> PyResult<Self> {
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
            description.reports = strings(&reports, "the attribute `reports` of a robot")?;
        }
        description.counts_events = robot.hasattr("begin_plan")?;
        let raised = Raised::default();
        Ok(Self {
            robot: robot.clone().unbind(),
            domain: Arc::clone(domain),
            description,
            orders: 0,
            ended: BTreeMap::new(),
            world: world.clone(),
            stopping: Stopping::new(robot.clone().unbind(), raised.clone()),
            raised,
        })
    }

    /// Returns the place of the exception that ends a run.
    pub(crate) fn raised(&self) -> Raised {
        self.raised.clone()
    }

    /// Returns the stop of the robot, for the end of the run.
    pub(crate) fn stopping(&self) -> &Arc<Stopping> {
        &self.stopping
    }

    /// Returns the name of the robot's class.
    pub(crate) fn name(&self) -> &str {
        &self.description.name
    }

    /// Returns the hint for a robot that reports events and does not count them anew with each plan, if it is one.
    pub(crate) fn hint_about_events(&self, world: &ReadWorld) -> Option<String> {
        let domain = world.domain();
        let is_event = |name: &String| {
            let mut predicates = (0..domain.predicates.len()).map(PredicateId::new);
            predicates.any(|id| domain.predicate(id).name == *name && domain.words(id).event)
        };
        let event = self.description.reports.iter().find(|name| is_event(name))?;
        (!self.description.counts_events).then(|| {
            format!("`{event}` is an event: add a method `begin_plan(world)`, which begins to count events anew")
        })
    }

    /// Checks that the robot senses if the plan does.
    pub(crate) fn check_senses(&self, plan: &VerifiedPlan) -> Result<(), Failure> {
        let domain = plan.world().domain();
        let mut sensing = plan.steps().iter().map(|step| domain.action(step.action));
        let Some(action) = sensing.find(|action| !action.senses.is_empty()) else {
            return Ok(());
        };
        let senses = attach(|py| self.robot.bind(py).hasattr("sense").unwrap_or(false));
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
        if self.stopping.is_requested() {
            Err(RobotError::Stopped)
        } else {
            Ok(())
        }
    }

    /// Keeps an exception, stops the robot, and returns the error for the run.
    fn fail(&mut self, error: PyErr) -> RobotError {
        let mut reason = error.to_string();
        self.raised.keep(error);
        if let Err(error) = self.stopping.confirm() {
            reason = format!("{reason}; its `stop` failed: {error}");
        }
        RobotError::Gone {
            reason,
            messages: String::new(),
        }
    }

    /// Returns true for an exception of a robot that was stopped from another thread meanwhile: it ends the step, and the run
    /// ends with the reason of the stop. Ctrl-C is none.
    fn follows_from_stop(&self, error: &PyErr) -> bool {
        self.stopping.is_requested() && attach(|py| error.is_instance_of::<PyException>(py))
    }

    fn perform(&self, order: &Order) -> PyResult<Progress> {
        attach(|py| {
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
    let expected = outcomes.join(", ");
    let text: String = returned.extract().map_err(|_| {
        let class = class_of(returned);
        PyTypeError::new_err(format!("`sense` must return one of {expected} as a str, not {class}"))
    })?;
    let outcome = outcomes.iter().position(|outcome| *outcome == text);
    if outcome.is_none() {
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
            reason: match error.value(py).to_string() {
                empty if empty.is_empty() => format!("{} without a reason", class_of(error.value(py).as_any())),
                reason => reason,
            },
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
        let end = match self.perform(order) {
            Ok(end) => end,
            // The events of the run have it, as the reason why the step failed.
            Err(error) if self.follows_from_stop(&error) => {
                return Err(RobotError::Refused {
                    method: order.action.clone(),
                    reason: error.to_string(),
                });
            }
            Err(error) => return Err(self.fail(error)),
        };
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
        let seen = attach(|py| {
            py.check_signals()?;
            let seen = self.robot.bind(py).call_method0("observe")?;
            observation::read(&seen, Source::Robot, &self.world)
        });
        seen.map_err(|error| {
            if self.follows_from_stop(&error) {
                RobotError::Stopped
            } else {
                self.fail(error)
            }
        })
    }

    fn stop(&mut self) -> Result<(), RobotError> {
        self.stopping.confirm().map_err(|reason| RobotError::Refused {
            method: "stop".to_owned(),
            reason,
        })
    }

    fn stop_switch(&self) -> StopSwitch {
        self.stopping.switch()
    }

    fn begin_plan(&mut self, world: &ReadWorld) {
        if self.description.counts_events {
            let world = World {
                world: world.clone(),
                domain: Arc::clone(&self.domain),
            };
            let begun = attach(|py| self.robot.bind(py).call_method1("begin_plan", (world,)).map(|_| ()));
            if let Err(error) = begun {
                self.fail(error);
            }
        }
    }

    fn wait(&mut self, limit: Duration) {
        std::thread::sleep(limit);
        if let Err(error) = attach(|py| py.check_signals()) {
            self.fail(error);
        }
    }
}
