//! The options of a simulated robot: `seed=7,faults=2,pace=200`.

use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use super::mishap::Mishap;

/// The options of a [`Sim`](super::Sim).
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct SimOptions {
    /// The seed of everything that is random.
    pub seed: u64,
    /// The number of mishaps.
    pub faults: u32,
    /// Mishaps happen within this number of orders.
    pub horizon: u32,
    /// The kinds of mishaps; empty for all.
    pub kinds: Vec<Mishap>,
    /// A step takes up to this number of ticks.
    pub ticks: u32,
    /// The time of a tick.
    pub pace: Duration,
    /// The share of the entities that an observation sees, in percent.
    pub sees: u32,
    /// The file that keeps the state of the simulated world.
    pub state: Option<PathBuf>,
}

impl Default for SimOptions {
    fn default() -> Self {
        Self {
            seed: 0,
            faults: 0,
            horizon: Self::HORIZON,
            kinds: Vec::new(),
            ticks: 1,
            pace: Duration::ZERO,
            sees: 100,
            state: None,
        }
    }
}

/// An option that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no option of `sim`; write `sim` or `sim:OPTION=VALUE,...` with seed, faults (0 to 100), horizon (1 to 10000), \
     kinds (fails+no-effect+slips+moved+undone), ticks (1 to 1000), pace (ms, 0 to 60000), sees (percent) or state (a file)"
)]
pub struct SimOptionsError(String);

impl FromStr for SimOptions {
    type Err = SimOptionsError;

    fn from_str(text: &str) -> Result<Self, SimOptionsError> {
        let mut options = Self::default();
        for part in text.split(',').filter(|part| !part.trim().is_empty()) {
            options
                .set(part.trim())
                .ok_or_else(|| SimOptionsError(part.trim().to_owned()))?;
        }
        Ok(options)
    }
}

impl SimOptions {
    /// The number of orders within which mishaps happen, unless [`horizon`](Self::horizon) says another one.
    pub const HORIZON: u32 = 12;

    fn set(&mut self, part: &str) -> Option<()> {
        let (name, value) = part.split_once('=')?;
        let number = |low: u32, high: u32| value.parse().ok().filter(|number| (low..=high).contains(number));
        match name {
            "seed" => self.seed = value.parse().ok()?,
            "faults" => self.faults = number(0, 100)?,
            "horizon" => self.horizon = number(1, 10_000)?,
            "kinds" => self.kinds = value.split('+').map(Mishap::named).collect::<Option<_>>()?,
            "ticks" => self.ticks = number(1, 1_000)?,
            "pace" => self.pace = Duration::from_millis(u64::from(number(0, 60_000)?)),
            "sees" => self.sees = number(0, 100)?,
            "state" if !value.is_empty() => self.state = Some(PathBuf::from(value)),
            _ => return None,
        }
        Some(())
    }
}
