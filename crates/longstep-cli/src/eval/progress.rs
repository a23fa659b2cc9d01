//! Progress of a run on stderr.

use std::sync::Mutex;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use longstep_eval::attempt::Attempt;
use longstep_eval::run::Lines;
use longstep_llm::Progress;

use crate::output::{self, Style, remark};

/// A progress bar with the number of correct results; hidden if stderr is not a terminal.
pub(super) struct Bar {
    bar: ProgressBar,
    /// Correct attempts, and all attempts.
    counts: Mutex<(usize, usize)>,
}

impl Bar {
    pub(super) fn new(units: usize, done: usize, known: &[Attempt]) -> Self {
        let bar = ProgressBar::with_draw_target(Some(units as u64), ProgressDrawTarget::stderr());
        let template = "{msg} {wide_bar} {pos}/{len}, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        // Units of an earlier run do not count for the estimated time.
        bar.set_position(done as u64);
        bar.reset_eta();
        if done > 0 {
            remark!("Resuming after {done} of {units}");
        }
        let right = known.iter().filter(|attempt| attempt.correct).count();
        let shown = Self {
            bar,
            counts: Mutex::new((right, known.len())),
        };
        shown.show();
        shown
    }

    pub(super) fn done(&self, lines: &Lines) {
        if let Ok(mut counts) = self.counts.lock() {
            counts.0 += lines.iter().filter(|(attempt, _)| attempt.correct).count();
            counts.1 += lines.len();
        }
        self.bar.inc(1);
        self.show();
    }

    pub(super) fn tell(&self, progress: &Progress) {
        if let Progress::Warning(text) = progress {
            self.bar.suspend(|| remark!("{} {text}", "warning:".yellow().bold()));
        }
    }

    fn show(&self) {
        if let Ok(counts) = self.counts.lock() {
            output::progress(&self.bar, &format!("{} of {} correct", counts.0, counts.1));
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
