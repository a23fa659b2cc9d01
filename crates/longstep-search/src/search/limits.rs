//! Limits of a search: numbers of states and units of work, never seconds, so the result does not depend on the machine.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Work units of one search by default: grounding, relevance analysis and all runs.
pub const EFFORT: u64 = Effort::NORMAL.units();

/// The work that a search may take, in millions of units (`longstep_model::effort`). A million takes 20 to 40 ms.
///
/// ```
/// use longstep_search::search::{Effort, Limits};
/// let effort: Effort = "large".parse().unwrap();
/// assert_eq!(effort, "500".parse().unwrap());
/// assert!(Limits::from(effort).any > Limits::default().any);
/// assert!("enormous".parse::<Effort>().is_err() && "0".parse::<Effort>().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "u32", into = "u32")]
pub struct Effort(u32);

impl Effort {
    /// A tenth of a second or two.
    pub const SMALL: Self = Self(10);
    /// The default: at most one or two seconds.
    pub const NORMAL: Self = Self(50);
    /// At most ten or twenty seconds.
    pub const LARGE: Self = Self(500);
    /// The largest effort: minutes, and a few gigabytes of memory.
    pub const MOST: Self = Self(10_000);

    /// Returns the units of work.
    pub const fn units(self) -> u64 {
        self.0 as u64 * 1_000_000
    }

    /// Scales a number that is meant for the normal effort.
    fn scaled(self, number: usize) -> usize {
        (number as u64 * u64::from(self.0) / u64::from(Self::NORMAL.0)) as usize
    }
}

impl Default for Effort {
    fn default() -> Self {
        Self::NORMAL
    }
}

/// A text or a number that is no effort.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "must be `small`, `normal`, `large`, or a number from 1 to {} (millions of units of work)",
    Effort::MOST
)]
pub struct EffortError;

impl TryFrom<u32> for Effort {
    type Error = EffortError;

    fn try_from(millions: u32) -> Result<Self, EffortError> {
        match millions {
            1.. if millions <= Self::MOST.0 => Ok(Self(millions)),
            _ => Err(EffortError),
        }
    }
}

impl From<Effort> for u32 {
    fn from(effort: Effort) -> Self {
        effort.0
    }
}

impl FromStr for Effort {
    type Err = EffortError;

    fn from_str(text: &str) -> Result<Self, EffortError> {
        match text {
            "small" => Ok(Self::SMALL),
            "normal" => Ok(Self::NORMAL),
            "large" => Ok(Self::LARGE),
            number => Self::try_from(number.parse::<u32>().map_err(|_| EffortError)?),
        }
    }
}

impl fmt::Display for Effort {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

/// Limits of a search as numbers of evaluated states, and as units of work.
///
/// ```
/// use longstep_search::search::{Effort, Limits};
/// let limits = Limits::from(Effort::SMALL).with_any(10);
/// assert_eq!((limits.any, limits.effort), (10, Effort::SMALL));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// States for a plan in the focused task, which has only the most direct operators.
    pub direct: usize,
    /// States for the proof that no plan is cheaper than the one that was found.
    pub proof: usize,
    /// States for a shortest plan if there is no direct one.
    pub shortest: usize,
    /// States for any plan, and as many again to improve it.
    pub any: usize,
    /// Units of work for the whole search; its runs have fixed parts of them.
    pub effort: Effort,
}

impl From<Effort> for Limits {
    fn from(effort: Effort) -> Self {
        Self {
            direct: effort.scaled(4_000),
            proof: effort.scaled(400),
            shortest: effort.scaled(1_500),
            any: effort.scaled(100_000),
            effort,
        }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::from(Effort::default())
    }
}

impl Limits {
    /// Sets the states for a plan in the focused task.
    #[must_use]
    pub fn with_direct(self, direct: usize) -> Self {
        Self { direct, ..self }
    }

    /// Sets the states for the proof that no plan is cheaper.
    #[must_use]
    pub fn with_proof(self, proof: usize) -> Self {
        Self { proof, ..self }
    }

    /// Sets the states for a shortest plan.
    #[must_use]
    pub fn with_shortest(self, shortest: usize) -> Self {
        Self { shortest, ..self }
    }

    /// Sets the states for any plan, and as many again to improve it.
    #[must_use]
    pub fn with_any(self, any: usize) -> Self {
        Self { any, ..self }
    }

    /// Sets the units of work for the whole search, and no limit on states. [`Limits::from`] scales those too.
    #[must_use]
    pub fn with_effort(self, effort: Effort) -> Self {
        Self { effort, ..self }
    }

    /// Work units of one run for a shortest plan or a proof: a state of a task with 20,000 operators takes a thousand times
    /// the work of one with 20 operators.
    pub(super) fn run_for_shortest(&self) -> u64 {
        self.effort.units() / 25 * 4
    }

    /// Work units of one run for any plan, or to improve it.
    pub(super) fn run_for_any(&self) -> u64 {
        // At most two runs of each kind fail one after the other, which takes 80 % of the units. The rest is for
        // grounding and relevance analysis.
        self.effort.units() / 25 * 6
    }
}
