//! Times: seconds from the beginning, or a clock that counts since the epoch.

/// The least time, in seconds, that is one since the epoch: three years.
const EPOCH: f64 = 1e8;

/// The units of clocks: their name, and their part of a second.
const UNITS: [(&str, f64); 4] = [
    ("seconds", 1.0),
    ("milliseconds", 1e-3),
    ("microseconds", 1e-6),
    ("nanoseconds", 1e-9),
];

/// The clock of a recording. A recording that counts since the epoch begins at 0.
#[derive(Debug, Default)]
pub(super) struct Clock {
    /// The first time as it is written, with its unit; none in a recording that counts from its own beginning.
    epoch: Option<(f64, &'static (&'static str, f64))>,
    is_set: bool,
}

impl Clock {
    /// Returns the seconds of a time; the first time decides the unit.
    pub(super) fn seconds(&mut self, written: f64) -> f64 {
        if !self.is_set {
            self.is_set = true;
            // The units are a thousand times apart, and three years to three thousand years are the epoch of each.
            let unit = UNITS
                .iter()
                .find(|(_, part)| (EPOCH..EPOCH * 1e3).contains(&(written * part)));
            self.epoch = unit.map(|unit| (written, unit));
        }
        match self.epoch {
            Some((first, (_, part))) => (written - first) * part,
            None => written,
        }
    }

    /// Returns the seconds since the epoch at the time 0; 0 if the recording does not count since the epoch.
    pub(super) fn begins(&self) -> f64 {
        self.epoch.map_or(0.0, |(first, (_, part))| first * part)
    }

    pub(super) fn note(&self) -> Option<String> {
        let (_, (name, _)) = self.epoch?;
        Some(format!("times are {name} since the epoch; the first frame is at 0 s"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_since_the_epoch_begins_at_zero() {
        for (first, second, expected) in [
            (0.5, 0.75, [0.5, 0.75]),
            (-1.0, 1.0, [-1.0, 1.0]),
            (50_000.0, 50_001.0, [50_000.0, 50_001.0]),
            (1_772_000_000.0, 1_772_000_000.25, [0.0, 0.25]),
            (1_772_000_000_000.0, 1_772_000_000_250.0, [0.0, 0.25]),
            (1_772_000_000_000_000.0, 1_772_000_000_250_000.0, [0.0, 0.25]),
            (1_772_000_000_000_000_000.0, 1_772_000_000_250_000_000.0, [0.0, 0.25]),
        ] {
            let mut clock = Clock::default();
            let times = [clock.seconds(first), clock.seconds(second)];
            assert!(
                (times[0] - expected[0]).abs() < 1e-6 && (times[1] - expected[1]).abs() < 1e-6,
                "{times:?}"
            );
        }
    }
}
