//! Durations.

use std::time::Instant;

use longstep::Clock;

/// Milliseconds since `since`.
pub(crate) fn milliseconds(since: Instant) -> f64 {
    // Rounded to microseconds, which is precise enough.
    (since.elapsed().as_secs_f64() * 1_000_000.0).round() / 1000.0
}

/// Returns a clock that begins now.
pub(crate) fn clock() -> Clock {
    let began = Instant::now();
    Clock::new(move || began.elapsed())
}
