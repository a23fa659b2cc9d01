//! Durations.

use std::time::Instant;

use longstep::{Clock, report};

/// Milliseconds since `since`.
pub(crate) fn milliseconds(since: Instant) -> f64 {
    report::milliseconds(since.elapsed())
}

/// Returns a clock that begins now.
pub(crate) fn clock() -> Clock {
    let began = Instant::now();
    Clock::new(move || began.elapsed())
}
