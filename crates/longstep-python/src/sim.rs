//! A simulated robot with seeded mishaps.

use std::sync::{Mutex, PoisonError};

use longstep_robot::{Order, Progress, Robot, RobotError, Scope, Sim as OwnSim, SimOptions};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::argument::strings;
use crate::failure::Failure;
use crate::json;
use crate::robot::step_failed;
use crate::world::World;

/// A simulated robot in a world: it does what the domain says, and slips now and then if it is asked to.
///
/// Of the first `horizon` steps (12 without one), `faults` (0 to 100) go wrong in one of the `kinds`: `fails`, `no-effect`, `slips`,
/// `moved` and `undone`. The same `seed` gives the same mishaps.
///
/// >>> world = longstep.World({"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
/// ...     "object_states": {"<pen>": "on_something(<desk>)"}})
/// >>> robot = longstep.Sim(world)
/// >>> robot.perform("move-hand", "<pen>")
/// >>> robot.observe()["states"]["<pen>"]
/// ['on_something(<desk>)']
#[pyclass(frozen, module = "longstep")]
pub(crate) struct Sim {
    sim: Mutex<OwnSim>,
}

// The documentation of the class names it.
const _: () = assert!(SimOptions::HORIZON == 12, "the default of `horizon` has changed");

#[pymethods]
impl Sim {
    /// Begins in a world. Of the first `horizon` steps, `faults` go wrong, each in one of the `kinds`.
    #[new]
    #[pyo3(signature = (world, /, *, faults=0, kinds=None, horizon=None, seed=0))]
    fn new(
        world: &Bound<'_, World>,
        faults: u32,
        kinds: Option<&Bound<'_, PyAny>>,
        horizon: Option<u32>,
        seed: u64,
    ) -> PyResult<Self> {
        let mut options = vec![format!("faults={faults}"), format!("seed={seed}"), "ticks=1".to_owned()];
        let kinds = kinds.map(|kinds| strings(kinds, "kinds")).transpose()?;
        options.extend(kinds.map(|kinds| format!("kinds={}", kinds.join("+"))));
        options.extend(horizon.map(|horizon| format!("horizon={horizon}")));
        let options: Result<SimOptions, _> = options.join(",").parse();
        let options = options.map_err(|error| {
            let kinds = "kinds are `fails`, `no-effect`, `slips`, `moved` and `undone`";
            Failure::unreadable(error.to_string()).hint(format!("{kinds}; faults go from 0 to 100"))
        })?;
        let sim = OwnSim::new(world.get().world.clone(), &options);
        Ok(Self {
            sim: Mutex::new(sim.map_err(|error| Failure::failed(error.to_string()))?),
        })
    }

    /// The predicates that `observe` lists besides the states of entities.
    #[getter]
    fn reports(&self) -> Vec<String> {
        self.lock().describe().reports.clone()
    }

    /// Prepares for a plan that begins in a world: takes its values, and begins to count events, such as a wiped table, anew.
    fn begin_plan(&self, world: &Bound<'_, World>) {
        self.lock().begin_plan(&world.get().world);
    }

    /// Performs a step.
    ///
    /// Raises `ValueError` for an action, an entity or a type of an argument that no plan of this world can have.
    #[pyo3(signature = (action, /, *arguments))]
    fn perform(&self, action: &str, arguments: &Bound<'_, PyTuple>) -> PyResult<()> {
        self.carry_out(action, arguments, Vec::new()).map(|_| ())
    }

    /// Performs a sensing step; returns one of the `outcomes`.
    #[pyo3(signature = (outcomes, action, /, *arguments))]
    fn sense(&self, outcomes: &Bound<'_, PyAny>, action: &str, arguments: &Bound<'_, PyTuple>) -> PyResult<String> {
        let outcomes = strings(outcomes, "outcomes")?;
        let found = self.carry_out(action, arguments, outcomes.clone())?;
        let outcome = found.and_then(|index| outcomes.into_iter().nth(index));
        outcome.ok_or_else(|| PyRuntimeError::new_err(format!("`{action}` senses nothing")))
    }

    /// Returns what the robot sees.
    fn observe<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let seen = self.lock().observe(&Scope::All);
        json::object(py, &seen.map_err(|error| PyRuntimeError::new_err(error.to_string()))?)
    }

    /// Stops the robot; it performs nothing more.
    fn stop(&self) -> PyResult<()> {
        let stopped = self.lock().stop();
        stopped.map_err(|error| PyRuntimeError::new_err(error.to_string()))
    }
}

impl Sim {
    fn lock(&self) -> std::sync::MutexGuard<'_, OwnSim> {
        self.sim.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Performs a step, and returns the index of the outcome that was sensed.
    fn carry_out(
        &self,
        action: &str,
        arguments: &Bound<'_, PyTuple>,
        outcomes: Vec<String>,
    ) -> PyResult<Option<usize>> {
        let mut order = Order::new(1, action, strings(arguments, "the arguments of a step")?);
        order.outcomes = outcomes;
        match self.performed(&order) {
            Ok(Progress::Failed { reason }) => Err(step_failed(arguments.py(), &reason)),
            Ok(Progress::Done { outcome }) => Ok(outcome),
            Ok(Progress::Running(_)) => Ok(None),
            Err(RobotError::InvalidOrder { reason, .. }) => Err(PyValueError::new_err(reason)),
            Err(error @ RobotError::Unsupported { .. }) => Err(PyValueError::new_err(error.to_string())),
            Err(error) => Err(PyRuntimeError::new_err(error.to_string())),
        }
    }

    /// Performs an order to its end. Runs no code in Python: another thread may wait for the lock with the interpreter, to stop.
    fn performed(&self, order: &Order) -> Result<Progress, RobotError> {
        let mut sim = self.lock();
        let handle = sim.start(order)?;
        loop {
            match sim.poll(handle)? {
                Progress::Running(_) => {}
                end => return Ok(end),
            }
        }
    }
}
