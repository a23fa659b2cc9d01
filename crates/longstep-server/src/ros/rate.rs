//! A bound on the number of requests in a time.

use std::time::{Duration, Instant};

/// A bucket of tokens that fills again with time: each request takes one.
#[derive(Debug)]
pub(super) struct Bucket {
    size: f64,
    per_second: f64,
    tokens: f64,
    filled: Instant,
}

impl Bucket {
    /// Returns a full bucket.
    pub(super) fn new(size: u32, per_second: f64, now: Instant) -> Self {
        Self {
            size: f64::from(size),
            per_second,
            tokens: f64::from(size),
            filled: now,
        }
    }

    /// Takes a token; false if there is none.
    pub(super) fn take(&mut self, now: Instant) -> bool {
        let passed: Duration = now.saturating_duration_since(self.filled);
        self.filled = now;
        self.tokens = (self.tokens + passed.as_secs_f64() * self.per_second).min(self.size);
        let has_one = self.tokens >= 1.0;
        if has_one {
            self.tokens -= 1.0;
        }
        has_one
    }
}
