//! Progress on stderr.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use longstep_llm::Progress;
use longstep_llm::store::PullProgress;

use crate::output::{self, Style, remark};

/// A line with the model's progress; hidden if stderr is not a terminal.
pub(crate) struct Spinner {
    bar: ProgressBar,
}

impl Spinner {
    pub(crate) fn new() -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(100));
        Self { bar }
    }

    pub(crate) fn show(&self, progress: &Progress) {
        match progress {
            Progress::Loading => output::progress(&self.bar, "Loading the model"),
            Progress::ReadingPrompt { done, total } => {
                let percent = 100 * done / (*total).max(1);
                output::progress(&self.bar, &format!("Reading the prompt ({percent}%)"));
            }
            Progress::Writing { .. } => output::progress(&self.bar, "Generating"),
            Progress::Waiting => output::progress(&self.bar, "Waiting for the server"),
            Progress::Warning(text) => {
                self.bar.suspend(|| remark!("{} {text}", "warning:".yellow().bold()));
            }
            _ => {}
        }
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
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
        Self { bar }
    }

    pub(crate) fn show(&self, progress: &PullProgress) {
        match progress {
            PullProgress::Note(text) => self.bar.suspend(|| remark!("{text}")),
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
        self.bar.finish_and_clear();
    }
}
