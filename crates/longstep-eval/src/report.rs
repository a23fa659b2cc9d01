//! Reports of a run: an HTML page, a Markdown document, and text for the terminal.
//!
//! All three are functions of [`Results`] alone: equal results give equal bytes. The page is one file that loads
//! nothing, and all data in it is escaped. It is readable without its script, which only opens attempts on top of the
//! page instead of below it.

mod charts;
mod detail;
mod grid;
mod groups;
mod mark;
mod markdown;
mod markup;
mod page;
mod paper;
mod settings;
mod tables;
#[cfg(test)]
pub(crate) mod tests;
mod text;
mod words;

use longstep_core::visible;

use crate::attempt::Attempt;
use crate::folder::Results;
use crate::rate::Rate;
use crate::summary::Summary;

pub(crate) use groups::label;
pub(crate) use markdown::{escaped as markdown_escaped, row as markdown_row};
pub(crate) use markup::{Page, escaped, whole};
pub(crate) use settings::settings;
pub(crate) use words::{amount, came, duration, interval, percent, points, reason};

/// The report as one HTML file.
pub fn html(results: &Results) -> String {
    page::page(results)
}

/// The report as a Markdown document.
pub fn markdown(results: &Results) -> String {
    markdown::document(results)
}

/// The report as text for the terminal.
pub fn text(results: &Results) -> String {
    printable(&text::lines(results))
}

/// Makes lines safe for the terminal: control characters in a model's text are escaped, and no line becomes two.
pub(crate) fn printable(lines: &[String]) -> String {
    lines
        .iter()
        .map(|line| visible::line(line).into_owned() + "\n")
        .collect()
}

/// A share in reports.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Measure {
    /// The name.
    pub(crate) name: &'static str,
    /// The definition.
    pub(crate) about: &'static str,
    /// The share.
    pub(crate) rate: Rate,
    /// True if higher is better.
    pub(crate) wanted: bool,
}

/// The shares of a summary that apply to its attempts.
pub(crate) fn measures(summary: &Summary) -> Vec<Measure> {
    let measure = |name, about, rate, wanted| Measure {
        name,
        about,
        rate,
        wanted,
    };
    let mut all = vec![
        measure("correct", "the expected result", summary.correct, true),
        measure(
            "executable",
            "a plan of which every step can be carried out",
            summary.executable,
            true,
        ),
        measure(
            "first shot",
            "the first reply was such a plan, without repair or a round",
            summary.first_shot,
            true,
        ),
        measure(
            "asked rightly",
            "a question or a refusal where that was expected",
            summary.asked_rightly,
            true,
        ),
        measure(
            "asked needlessly",
            "a question where a plan was expected",
            summary.asked_needlessly,
            false,
        ),
        measure("chains right", "every step of a chain is correct", summary.chains, true),
        measure(
            "claims right",
            "the claimed environment is the simulated one",
            summary.claims_right,
            true,
        ),
    ];
    let asks = summary.asked_rightly.of > 0 || summary.asked_needlessly.hits > 0;
    all.retain(|measure| measure.rate.of > 0 && (measure.wanted || asks));
    all
}

/// The incorrect attempts, each with its place in the run.
pub(crate) fn not_correct(results: &Results) -> Vec<(usize, &Attempt)> {
    let all = results.attempts.iter().enumerate();
    all.filter(|(_, attempt)| !attempt.correct).collect()
}
