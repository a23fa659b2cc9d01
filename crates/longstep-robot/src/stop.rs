//! Requests to stop a run.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use crate::robot::{Robot, StopSwitch};

/// A request to stop a run, from any thread. Clones stop the same run.
///
/// A request exists before its robot: one that comes while the robot is being opened stops it as soon as there is
/// something to stop ([`StopRequest::attach`]).
///
/// ```
/// use std::sync::Arc;
/// use std::sync::atomic::{AtomicBool, Ordering};
/// use longstep_robot::{StopRequest, StopSwitch};
/// let request = StopRequest::default();
/// request.stop();
/// let pressed = Arc::new(AtomicBool::new(false));
/// let seen = Arc::clone(&pressed);
/// request.attach(StopSwitch::new(move || seen.store(true, Ordering::SeqCst)));
/// assert!(request.is_requested() && pressed.load(Ordering::SeqCst));
/// ```
#[derive(Debug, Clone, Default)]
pub struct StopRequest {
    requested: Arc<AtomicBool>,
    switch: Arc<Mutex<Option<StopSwitch>>>,
}

impl StopRequest {
    /// Returns the request for runs on this robot.
    pub fn of(robot: &dyn Robot) -> Self {
        let request = Self::default();
        request.attach(robot.stop_switch());
        request
    }

    /// Attaches the switch of the robot; presses it if the request came before.
    pub fn attach(&self, switch: StopSwitch) {
        *self.switch.lock().unwrap_or_else(PoisonError::into_inner) = Some(switch);
        if self.is_requested() {
            self.press();
        }
    }

    /// Stops the robot before anything else, then the run.
    pub fn stop(&self) {
        // The flag first, which takes no time: an error of the robot that the switch causes is known to follow from it.
        self.requested.store(true, Ordering::SeqCst);
        self.press();
    }

    /// Returns true after a request.
    pub fn is_requested(&self) -> bool {
        self.requested.load(Ordering::SeqCst)
    }

    fn press(&self) {
        let switch = self.switch.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if let Some(switch) = switch {
            switch.press();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stop_request_before_attach_still_stops_the_robot() {
        for early in [true, false] {
            let pressed = Arc::new(AtomicBool::new(false));
            let seen = Arc::clone(&pressed);
            let request = StopRequest::default();
            if early {
                request.stop();
            }
            request.attach(StopSwitch::new(move || seen.store(true, Ordering::SeqCst)));
            assert_eq!(pressed.load(Ordering::SeqCst), early);
            request.stop();
            assert!(request.is_requested() && pressed.load(Ordering::SeqCst));
        }
    }
}
