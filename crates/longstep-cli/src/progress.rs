//! Progress on stderr.

use std::cell::RefCell;
use std::fmt::Write;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use longstep_llm::Progress;
use longstep_llm::store::PullProgress;

use crate::output::{self, Style, remark};

/// The time after which a wait is mentioned where no line can be drawn again, and between two mentions.
const PATIENCE: Duration = Duration::from_secs(20);

/// The time from which a wait is shown in seconds.
const NOTABLE: Duration = Duration::from_secs(2);

/// The progress of a model: one line that is drawn again and again, or now and then a line where that cannot be done.
pub(crate) struct Spinner {
    /// None where no line can be drawn again.
    bar: Option<ProgressBar>,
    wait: RefCell<Wait>,
}

/// The current wait: its phase, its start, and the time of its last mention.
#[derive(Debug)]
struct Wait {
    phase: Phase,
    since: Instant,
    /// The tokens of the prompt that were known at the beginning.
    known: usize,
    mentioned: Instant,
}

/// A part of a model's call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    None,
    Loading,
    Reading,
    Writing,
    Server,
}

impl Phase {
    fn of(progress: &Progress) -> Option<Self> {
        match progress {
            Progress::Loading => Some(Self::Loading),
            Progress::ReadingPrompt { .. } => Some(Self::Reading),
            Progress::Writing { .. } => Some(Self::Writing),
            Progress::Waiting => Some(Self::Server),
            _ => None,
        }
    }
}

impl Spinner {
    pub(crate) fn new() -> Self {
        let now = Instant::now();
        let wait = Wait {
            phase: Phase::None,
            since: now,
            known: 0,
            mentioned: now,
        };
        Self {
            bar: output::can_redraw().then(redrawn_line),
            wait: RefCell::new(wait),
        }
    }

    pub(crate) fn show(&self, progress: &Progress) {
        if let Progress::Warning(text) = progress {
            remark!("{} {text}", "warning:".yellow().bold());
        }
        let Some(phase) = Phase::of(progress) else { return };
        let mut wait = self.wait.borrow_mut();
        let now = Instant::now();
        if wait.phase != phase {
            (wait.phase, wait.since) = (phase, now);
            if let Progress::ReadingPrompt { done, .. } = progress {
                wait.known = *done;
            }
            if let Some(bar) = &self.bar {
                bar.reset_elapsed();
            }
        }
        let message = message(progress, wait.known, now - wait.since);
        match &self.bar {
            Some(bar) => output::progress(bar, &message),
            None if now - wait.mentioned >= PATIENCE => {
                wait.mentioned = now;
                remark!("{message}");
            }
            None => {}
        }
    }
}

/// Begins a line at the bottom of the terminal, with the seconds of the wait.
fn redrawn_line() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}{waited}") {
        bar.set_style(style.with_key("waited", |state: &ProgressState, text: &mut dyn Write| {
            if state.elapsed() >= NOTABLE {
                // Writing to a line never fails.
                let _ = write!(text, ", {} s", state.elapsed().as_secs());
            }
        }));
    }
    output::begin_progress(&bar);
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

/// The sentence for a wait. A prompt of which little is known is read for the first time: its fixed part is saved.
fn message(progress: &Progress, known: usize, waited: Duration) -> String {
    match progress {
        Progress::Loading => "Loading the model".to_owned(),
        Progress::ReadingPrompt { done, total } => {
            let percent = 100 * done / (*total).max(1);
            let is_first = known < total / 2;
            let read = done.saturating_sub(known);
            let rest = total.saturating_sub(*done);
            let left = if waited >= NOTABLE && read > 0 {
                Duration::try_from_secs_f64(waited.as_secs_f64() * rest as f64 / read as f64).ok()
            } else {
                None
            };
            let left = left.map_or(String::new(), |left| format!(", {} s left", left.as_secs().max(1)));
            if is_first {
                format!("Reading for the first time: {percent} %{left}")
            } else {
                format!("Reading the prompt: {percent} %{left}")
            }
        }
        Progress::Writing { .. } => "Generating".to_owned(),
        _ => "Waiting for the server".to_owned(),
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            output::end_progress(bar);
        }
    }
}

/// A progress bar for a download. Without a terminal only notes are printed.
pub(crate) struct Download {
    bar: ProgressBar,
}

impl Download {
    pub(crate) fn new(bytes: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(bytes), ProgressDrawTarget::stderr());
        let template = "{msg} {wide_bar} {bytes}/{total_bytes} {bytes_per_sec} {eta}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        output::begin_progress(&bar);
        Self { bar }
    }

    pub(crate) fn show(&self, progress: &PullProgress) {
        match progress {
            PullProgress::Note(text) => remark!("{text}"),
            PullProgress::Bytes { done, .. } => self.bar.set_position(*done),
            PullProgress::Part { number, of } => {
                output::progress(&self.bar, &format!("Package {number} of {of}"));
                let length = self.bar.length().unwrap_or_default();
                self.bar
                    .set_position(length * u64::from(number.saturating_sub(1)) / u64::from((*of).max(1)));
            }
            PullProgress::Joining { done, .. } => {
                output::progress(&self.bar, "Joining packages");
                self.bar.set_position(*done);
            }
            _ => {}
        }
    }
}

impl Drop for Download {
    fn drop(&mut self) {
        output::end_progress(&self.bar);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_message_states_percent_and_remaining_time() {
        let reading = |done, total| Progress::ReadingPrompt { done, total };
        for (progress, known, seconds, expected) in [
            (Progress::Loading, 0, 9, "Loading the model"),
            (reading(0, 1000), 0, 0, "Reading for the first time: 0 %"),
            (reading(250, 1000), 0, 10, "Reading for the first time: 25 %, 30 s left"),
            (reading(900, 1000), 800, 3, "Reading the prompt: 90 %, 3 s left"),
            (reading(1000, 1000), 800, 3, "Reading the prompt: 100 %, 1 s left"),
            (reading(0, 0), 0, 3, "Reading the prompt: 0 %"),
            (Progress::Writing { tokens: 3 }, 0, 3, "Generating"),
        ] {
            assert_eq!(message(&progress, known, Duration::from_secs(seconds)), expected);
        }
    }
}
