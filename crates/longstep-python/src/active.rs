//! The runs that are under way: one for each robot.

use std::sync::{Mutex, MutexGuard, PoisonError};

use longstep_robot::RunControl;
use pyo3::prelude::*;

/// A run that is under way.
struct Run {
    /// The process that carries it out, and not one that was forked from it.
    process: u32,
    /// The identity of the robot.
    robot: usize,
    control: RunControl,
}

static RUNS: Mutex<Vec<Run>> = Mutex::new(Vec::new());

fn runs() -> MutexGuard<'static, Vec<Run>> {
    RUNS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The place of a run among those under way. Dropped when the run ends; the robot must live as long.
pub(crate) struct Active {
    process: u32,
    robot: usize,
}

impl Active {
    /// Adds a run; none if another one uses the robot.
    pub(crate) fn begin(robot: &Bound<'_, PyAny>, control: &RunControl) -> Option<Self> {
        let (process, robot) = (std::process::id(), robot.as_ptr() as usize);
        let mut runs = runs();
        if runs.iter().any(|run| (run.process, run.robot) == (process, robot)) {
            return None;
        }
        runs.push(Run {
            process,
            robot,
            control: control.clone(),
        });
        Some(Self { process, robot })
    }
}

impl Drop for Active {
    fn drop(&mut self) {
        runs().retain(|run| (run.process, run.robot) != (self.process, self.robot));
    }
}

/// Stops all runs of this process.
pub(crate) fn stop_all() {
    let process = std::process::id();
    let own: Vec<RunControl> = {
        let runs = runs();
        let own = runs.iter().filter(|run| run.process == process);
        own.map(|run| run.control.clone()).collect()
    };
    for control in own {
        control.stop();
    }
}
