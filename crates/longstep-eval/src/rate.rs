//! Shares with their intervals.

use serde::{Deserialize, Serialize};

/// How many of how many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Rate {
    /// So many did.
    pub hits: usize,
    /// Of so many.
    pub of: usize,
}

/// The 97.5th percentile of the normal distribution: what a 95 % interval needs.
const Z: f64 = 1.959_963_984_540_054;

impl Rate {
    /// Counts those for which it holds.
    pub fn count<T>(all: impl IntoIterator<Item = T>, holds: impl Fn(&T) -> bool) -> Self {
        let mut rate = Self::default();
        for one in all {
            rate.of += 1;
            rate.hits += usize::from(holds(&one));
        }
        rate
    }

    /// The share, 0 of none.
    pub fn share(self) -> f64 {
        match self.of {
            0 => 0.0,
            of => self.hits as f64 / of as f64,
        }
    }

    /// Wilson's score interval of 95 %: where the share lies that would be found with very many. It does not leave 0 to
    /// 1, and is sensible for few attempts and for shares of 0 and 1. (E. B. Wilson, 1927.)
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
