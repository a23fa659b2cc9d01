//! Shares with confidence intervals.

use serde::{Deserialize, Serialize};

/// A share as a fraction of counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Rate {
    /// Number of hits.
    pub hits: usize,
    /// Number of trials.
    pub of: usize,
}

/// The 97.5th percentile of the normal distribution, for 95 % confidence intervals.
const Z: f64 = 1.959_963_984_540_054;

impl Rate {
    /// Counts the items for which `holds` is true.
    pub fn count<T>(all: impl IntoIterator<Item = T>, holds: impl Fn(&T) -> bool) -> Self {
        let mut rate = Self::default();
        for one in all {
            rate.of += 1;
            rate.hits += usize::from(holds(&one));
        }
        rate
    }

    /// The share; 0 if there are no trials.
    pub fn share(self) -> f64 {
        match self.of {
            0 => 0.0,
            of => self.hits as f64 / of as f64,
        }
    }

    /// The 95 % confidence interval by Wilson's score method. It stays within 0 and 1, and is valid for small samples
    /// and for shares of 0 and 1. (E. B. Wilson, 1927.)
    ///
    /// ```
    /// use longstep_eval::Rate;
    /// let (low, high) = Rate { hits: 27, of: 28 }.interval();
    /// assert_eq!((format!("{low:.3}"), format!("{high:.3}")), ("0.823".to_owned(), "0.994".to_owned()));
    /// ```
    pub fn interval(self) -> (f64, f64) {
        if self.of == 0 {
            return (0.0, 1.0);
        }
        let (n, p) = (self.of as f64, self.share());
        let z2 = Z * Z;
        let middle = p + z2 / (2.0 * n);
        let half = Z * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
        let scale = 1.0 + z2 / n;
        (((middle - half) / scale).max(0.0), ((middle + half) / scale).min(1.0))
    }
}
