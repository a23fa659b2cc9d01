//! The clock of the durations in answers.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

/// A source of the current time, for the durations in answers ([`Timings`](crate::report::Timings)).
///
/// This library reads no clock of its own. Nothing but durations depends on the clock, so a plan is a function of the
/// other inputs. Clones share one source.
///
/// # Example
///
/// ```
/// use std::time::Instant;
/// use longstep::{Clock, Planner};
/// let began = Instant::now();
/// let planner = Planner::shipped("household")?.with_clock(Clock::new(move || began.elapsed()));
/// let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
///     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
/// let solution = planner.solution(&world, &planner.goal(&world, "put(pen, shelf)")?)?;
/// assert!(solution.answer.timings_ms.search > 0.0);
/// # Ok::<(), longstep::Error>(())
/// ```
#[derive(Clone, Default)]
pub struct Clock(Option<Arc<dyn Fn() -> Duration + Send + Sync>>);

impl Clock {
    /// Creates a clock from a function that returns the time since a fixed moment.
    ///
    /// See the [example](Self#example).
    pub fn new(now: impl Fn() -> Duration + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(now)))
    }

    /// Creates a clock that stands still: every duration is zero.
    ///
    /// ```
    /// use std::time::Duration;
    /// use longstep::Clock;
    /// assert_eq!(Clock::none().now(), Duration::ZERO);
    /// assert_eq!(Clock::new(|| Duration::from_secs(3)).now(), Duration::from_secs(3));
    /// ```
    pub const fn none() -> Self {
        Self(None)
    }

    /// Returns the time since the fixed moment of this clock.
    pub fn now(&self) -> Duration {
        self.0.as_ref().map_or(Duration::ZERO, |now| now())
    }

    /// Returns the milliseconds from one reading of this clock to another; zero if the clock was set back.
    pub(crate) fn milliseconds(from: Duration, to: Duration) -> f64 {
        milliseconds(to.saturating_sub(from))
    }
}

/// Returns a duration in milliseconds as answers have it: rounded to microseconds, which is precise enough.
///
/// ```
/// use std::time::Duration;
/// assert_eq!(longstep::report::milliseconds(Duration::from_nanos(1_234_567)), 1.235);
/// ```
pub fn milliseconds(duration: Duration) -> f64 {
    (duration.as_secs_f64() * 1_000_000.0).round() / 1000.0
}

impl fmt::Debug for Clock {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(if self.0.is_some() { "Clock" } else { "Clock::none()" })
    }
}
