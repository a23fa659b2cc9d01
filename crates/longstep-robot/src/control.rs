//! The control of a run: stop, pause and continue, from any thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::robot::Robot;
use crate::stop::StopRequest;

/// The control of a run, from any thread. Clones control the same run.
///
/// A pause lets the orders under way end, and ends [`drive`](crate::drive()); another run may use the robot then. A stop beats
/// a pause, also one that is reached.
///
/// ```
/// use longstep_robot::RunControl;
/// let control = RunControl::default();
/// let elsewhere = control.clone();
/// elsewhere.pause();
/// assert!(control.is_pause_requested());
/// control.resume();
/// assert!(!elsewhere.is_pause_requested() && !elsewhere.is_stop_requested());
/// ```
#[derive(Debug, Clone, Default)]
pub struct RunControl {
    stop: StopRequest,
    pause: Arc<AtomicBool>,
}

impl From<StopRequest> for RunControl {
    /// Returns the control of the run that a request stops.
    fn from(stop: StopRequest) -> Self {
        Self {
            stop,
            pause: Arc::default(),
        }
    }
}

impl RunControl {
    /// Returns the control of runs on this robot.
    pub fn of(robot: &dyn Robot) -> Self {
        StopRequest::of(robot).into()
    }

    /// Returns the request that stops the run, and its robot while it is opened.
    pub fn stop_request(&self) -> &StopRequest {
        &self.stop
    }

    /// Stops the robot before anything else, then the run. A robot that another run uses during a pause is stopped too.
    pub fn stop(&self) {
        self.stop.stop();
    }

    /// Asks for a pause.
    pub fn pause(&self) {
        self.pause.store(true, Ordering::SeqCst);
    }

    /// Withdraws the request for a pause. A run that is paused goes on with the next [`drive`](crate::drive()).
    pub fn resume(&self) {
        self.pause.store(false, Ordering::SeqCst);
    }

    /// Returns true after a request to stop.
    pub fn is_stop_requested(&self) -> bool {
        self.stop.is_requested()
    }

    /// Returns true after a request to pause that was not withdrawn.
    pub fn is_pause_requested(&self) -> bool {
        self.pause.load(Ordering::SeqCst)
    }
}
