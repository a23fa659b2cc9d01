//! The measured speed of models, for estimates before a long call.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use longstep::dialogue::Forecast;
use serde::{Deserialize, Serialize};

use crate::Progress;
use longstep_files::{read_bounded, write_whole};

/// The file of speeds in the cache.
const FILE: &str = "speeds.json";
/// Limit for that file, in bytes.
const FILE_LIMIT: u64 = 1 << 20;
/// Models that the file remembers.
const MODELS: usize = 100;
/// Fewest tokens that give a speed.
const LEAST: usize = 32;
/// Shortest time that gives a speed.
const SHORTEST: Duration = Duration::from_secs(2);

/// Tokens a second.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Speed {
    /// Reading of a prompt; none for servers, which do not report it.
    #[serde(default)]
    pub read: Option<f64>,
    /// Generation.
    #[serde(default)]
    pub write: Option<f64>,
}

impl Speed {
    /// Returns the time for a prompt and a usual answer, as far as the speeds are known; none if neither is.
    pub fn estimate(&self, forecast: &Forecast) -> Option<Duration> {
        let of = |tokens: u64, speed: Option<f64>| {
            let speed = speed.filter(|speed| speed.is_finite() && *speed > 0.0)?;
            Some(tokens as f64 / speed)
        };
        let reading = of(forecast.prompt, self.read);
        let writing = of(forecast.usual_answer, self.write);
        let seconds = match (reading, writing) {
            (None, None) => return None,
            (reading, writing) => reading.unwrap_or(0.0) + writing.unwrap_or(0.0),
        };
        Duration::try_from_secs_f64(seconds).ok()
    }
}

/// Measures a model's calls, and keeps the last speed of every model in the cache.
#[derive(Debug)]
pub struct Pace {
    file: PathBuf,
    model: String,
    known: BTreeMap<String, Speed>,
    reading: Option<Span>,
    writing: Option<Span>,
}

/// Tokens at two times.
#[derive(Debug, Clone, Copy)]
struct Span {
    first: (Instant, usize),
    last: (Instant, usize),
}

impl Span {
    fn extend(span: &mut Option<Self>, now: Instant, tokens: usize) {
        let at = (now, tokens);
        match span {
            Some(span) => span.last = at,
            None => *span = Some(Self { first: at, last: at }),
        }
    }

    /// Returns tokens a second; none before there is enough to measure.
    fn speed(&self) -> Option<f64> {
        let (time, tokens) = (self.last.0 - self.first.0, self.last.1.saturating_sub(self.first.1));
        (tokens >= LEAST && time >= SHORTEST).then(|| tokens as f64 / time.as_secs_f64())
    }
}

impl Pace {
    /// Loads the speeds of earlier runs. A file that cannot be read is the same as none: speeds are a convenience.
    pub fn load(cache: &Path, model: &str) -> Self {
        let file = cache.join(FILE);
        let bytes = read_bounded(&file, FILE_LIMIT).unwrap_or_default();
        Self {
            known: serde_json::from_slice(&bytes).unwrap_or_default(),
            model: model.to_owned(),
            file,
            reading: None,
            writing: None,
        }
    }

    /// Returns the speed of this call where it is known, else that of the last run.
    pub fn speed(&self) -> Speed {
        let last = self.known.get(&self.model).copied().unwrap_or_default();
        Speed {
            read: self.read_now().or(last.read),
            write: self.writing.and_then(|span| span.speed()).or(last.write),
        }
    }

    /// Returns the measured speed of reading this very prompt.
    pub fn read_now(&self) -> Option<f64> {
        self.reading.and_then(|span| span.speed())
    }

    /// Takes the progress of a call into account.
    pub fn observe(&mut self, progress: &Progress) {
        let now = Instant::now();
        match progress {
            Progress::Forecast(_) => (self.reading, self.writing) = (None, None),
            Progress::ReadingPrompt { done, .. } => Span::extend(&mut self.reading, now, *done),
            Progress::Writing { tokens } => Span::extend(&mut self.writing, now, *tokens),
            Progress::Answered => self.keep(),
            _ => {}
        }
    }

    /// Saves the speed if this call gave one.
    fn keep(&mut self) {
        let speed = self.speed();
        (self.reading, self.writing) = (None, None);
        if self.known.get(&self.model) == Some(&speed) || speed == Speed::default() {
            return;
        }
        if self.known.len() >= MODELS && !self.known.contains_key(&self.model) {
            self.known.clear();
        }
        self.known.insert(self.model.clone(), speed);
        if let Ok(text) = serde_json::to_vec(&self.known) {
            // Without the file, the next run has no estimate before it begins to read.
            let _ = write_whole(&self.file, &text);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pace_estimate_needs_a_measured_speed() {
        let forecast = Forecast {
            prompt: 5000,
            usual_answer: 700,
            answer: 1900,
            correction: 0,
            context: None,
        };
        for (read, write, seconds) in [
            (None, None, None),
            (Some(50.0), None, Some(100.0)),
            (None, Some(7.0), Some(100.0)),
            (Some(50.0), Some(7.0), Some(200.0)),
            (Some(0.0), Some(f64::NAN), None),
        ] {
            let found = Speed { read, write }.estimate(&forecast).map(|time| time.as_secs_f64());
            assert_eq!(found, seconds, "{read:?} {write:?}");
        }
    }

    #[test]
    fn pace_load_ignores_a_damaged_file() {
        let folder = tempfile::tempdir().unwrap();
        for text in ["", "{", "{\"m\": 3}", "{\"m\": {\"read\": \"x\"}}"] {
            std::fs::write(folder.path().join(FILE), text).unwrap();
            assert_eq!(Pace::load(folder.path(), "m").speed(), Speed::default(), "{text}");
        }
        std::fs::write(folder.path().join(FILE), r#"{"m": {"read": 20.5}}"#).unwrap();
        assert_eq!(Pace::load(folder.path(), "m").speed().read, Some(20.5));
        assert_eq!(Pace::load(folder.path(), "other").speed().read, None);
    }
}
