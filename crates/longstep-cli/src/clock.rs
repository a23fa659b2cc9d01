//! Durations.

use std::sync::OnceLock;
use std::time::Instant;

/// Milliseconds since `since`.
pub(crate) fn milliseconds(since: Instant) -> f64 {
    // Rounded to microseconds, which is precise enough.
    (since.elapsed().as_secs_f64() * 1_000_000.0).round() / 1000.0
}

/// Milliseconds since the first call.
pub(crate) fn stopwatch() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    milliseconds(*START.get_or_init(Instant::now))
}
