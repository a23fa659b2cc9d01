//! The control of a run from other threads.

use std::sync::atomic::{AtomicBool, Ordering};

use longstep_robot::RunControl;
use pyo3::prelude::*;

use crate::failure::Failure;
use crate::interpreter::{Call, detach};

/// The control of one run, for other threads and for callbacks: `longstep.run(..., control=control)`.
///
/// >>> world = longstep.World({"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
/// ...     "object_states": {"<pen>": "on_something(<desk>)"}})
/// >>> plan = longstep.solve(world, "put(pen, shelf)").verified()
/// >>> control = longstep.Control()
/// >>> stop_at_first_order = lambda event: event["event"] == "ordered" and control.stop()
/// >>> longstep.run(plan, longstep.Sim(world), approve="never", control=control, watch=stop_at_first_order).stopped
/// 'stopped at a request'
#[pyclass(frozen, module = "longstep")]
pub(crate) struct Control {
    control: RunControl,
    is_used: AtomicBool,
}

#[pymethods]
impl Control {
    /// Makes a control for one run.
    #[new]
    fn new() -> Self {
        Self {
            control: RunControl::default(),
            is_used: AtomicBool::new(false),
        }
    }

    /// Stops the robot, then the run. Before the run, it stops the run at its beginning; after the run, it does nothing.
    ///
    /// The robot's `stop` is called at once, in the thread that calls this, also while `perform` is at work in the thread of the
    /// run; it is called only once. The run ends when `perform`, `observe` or `ask` has returned; an exception of `perform` ends the
    /// step alone then, and the events have it. An exception of the robot's `stop` comes out of the run.
    fn stop(&self, py: Python<'_>) {
        let _call = Call::begin(py);
        detach(py, || self.control.stop());
    }

    /// Lets the run wait after the step that is under way, until `resume` or `stop`. The call of `run` does not return meanwhile.
    fn pause(&self) {
        self.control.pause();
    }

    /// Lets a run that waits go on. The world is observed before the next step.
    fn resume(&self) {
        self.control.resume();
    }

    fn __repr__(&self) -> &'static str {
        if self.control.is_stop_requested() {
            "<longstep.Control: stopped>"
        } else if self.control.is_pause_requested() {
            "<longstep.Control: paused>"
        } else {
            "<longstep.Control>"
        }
    }
}

impl Control {
    /// Returns the control for its run.
    pub(crate) fn take(&self) -> Result<RunControl, Failure> {
        if self.is_used.swap(true, Ordering::SeqCst) {
            return Err(
                Failure::failed("nothing has moved: this control belongs to another run")
                    .hint("make a `longstep.Control()` for each run".to_owned()),
            );
        }
        Ok(self.control.clone())
    }
}
