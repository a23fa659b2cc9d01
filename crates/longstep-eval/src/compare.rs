//! Comparison of two runs.
//!
//! Attempts are paired by their [`Key`]; attempts without a partner are counted and ignored, so both sides contain the
//! same instructions. The p value ([`mcnemar`]) assumes independent attempts. Trials of one case and steps of a chain
//! are not fully independent, so their p value is too small rather than too large.

mod mcnemar;
mod shown;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use crate::attempt::{Attempt, Key};
use crate::folder::Results;
use crate::report::{Measure, came, label, measures, printable, reason, settings};
use crate::summary::{Cost, Summary};

pub use mcnemar::mcnemar;

/// The comparison as text for the terminal.
pub fn text(a: &Results, b: &Results) -> String {
    printable(&shown::text(&Comparison::of(a, b)))
}

/// The comparison as a Markdown document.
pub fn markdown(a: &Results, b: &Results) -> String {
    shown::markdown(&Comparison::of(a, b))
}

/// The comparison as one HTML file that loads nothing.
pub fn html(a: &Results, b: &Results) -> String {
    shown::html(&Comparison::of(a, b))
}

/// A comparison of two runs.
struct Comparison {
    /// The title, one line.
    title: String,
    /// The names of the runs.
    names: (String, String),
    /// Caveats about the figures, as sentences.
    notes: Vec<String>,
    /// Measures of the paired attempts.
    measures: Vec<(Measure, Measure)>,
    /// Costs of the paired attempts.
    costs: (Cost, Cost),
    /// Edits per plan.
    edits: (f64, f64),
    /// Wrong in the first and right in the second.
    mended: Vec<Change>,
    /// Right in the first and wrong in the second.
    broken: Vec<Change>,
    /// The p value of this split.
    chance: f64,
    /// Settings that differ, with both values.
    settings: Vec<(&'static str, String, String)>,
}

/// An attempt with different results in the two runs.
struct Change {
    label: String,
    says: String,
    /// The reasons why it is not correct, from the run in which it is not.
    why: String,
    /// The result in the run in which it is correct.
    right: String,
}

impl Comparison {
    fn of(a: &Results, b: &Results) -> Self {
        let others: BTreeMap<&Key, &Attempt> = b.attempts.iter().map(|attempt| (&attempt.key, attempt)).collect();
        let both = a.attempts.iter();
        // Suites may use one id for different instructions.
        let pairs: Vec<(&Attempt, &Attempt)> = both
            .filter_map(|attempt| Some((attempt, *others.get(&attempt.key)?)))
            .collect();
        let change = |label: String, wrong: &Attempt, right: &Attempt| Change {
            label,
            says: wrong.says.clone(),
            why: reason(wrong),
            right: came(right),
        };
        let turned = |to: bool| pairs.iter().filter(move |(a, b)| a.correct != to && b.correct == to);
        let mended: Vec<Change> = turned(true)
            .map(|(first, second)| change(label(a, first), first, second))
            .collect();
        let broken: Vec<Change> = turned(false)
            .map(|(first, second)| change(label(b, second), second, first))
            .collect();
        let first = Summary::of(pairs.iter().map(|(first, _)| *first), &a.timings);
        let second = Summary::of(pairs.iter().map(|(_, second)| *second), &b.timings);
        Self {
            title: if a.plan.model == b.plan.model {
                format!("{}, twice", a.plan.model)
            } else {
                format!("{} and {}", a.plan.model, b.plan.model)
            },
            names: names(a, b),
            notes: notes(a, b, &pairs),
            measures: side_by_side(&first, &second),
            costs: (first.cost, second.cost),
            edits: (first.edits, second.edits),
            chance: mcnemar(mended.len(), broken.len()),
            mended,
            broken,
            settings: differing(a, b),
        }
    }
}

/// The names of the models, or "first run" and "second run" if these are equal.
fn names(a: &Results, b: &Results) -> (String, String) {
    let (first, second) = (&a.plan.model, &b.plan.model);
    if first == second {
        ("first run".to_owned(), "second run".to_owned())
    } else {
        (first.clone(), second.clone())
    }
}

fn notes(a: &Results, b: &Results, pairs: &[(&Attempt, &Attempt)]) -> Vec<String> {
    let mut notes = Vec::new();
    if a.plan.suite != b.plan.suite {
        notes.push(format!(
            "These are runs of different suites, {} and {}; only attempts with the same key are compared.",
            a.plan.suite, b.plan.suite
        ));
    } else if a.plan.suite_sha256 != b.plan.suite_sha256 {
        notes.push("The suite has changed between the runs.".to_owned());
    }
    let only = (a.attempts.len() - pairs.len(), b.attempts.len() - pairs.len());
    if only != (0, 0) {
        notes.push(format!(
            "Attempts in both runs: {}; only in the first, and not counted: {}; only in the second: {}.",
            pairs.len(),
            only.0,
            only.1
        ));
    }
    let reworded = pairs.iter().filter(|(first, second)| first.says != second.says).count();
    if reworded > 0 {
        notes.push(format!("In {reworded} of them the instruction is not the same."));
    }
    notes
}

/// The measures that apply to at least one of the runs.
fn side_by_side(first: &Summary, second: &Summary) -> Vec<(Measure, Measure)> {
    let (first, second) = (measures(first), measures(second));
    let of = |all: &[Measure], name: &str| all.iter().find(|measure| measure.name == name).copied();
    let none = |measure: Measure| Measure {
        rate: crate::rate::Rate::default(),
        ..measure
    };
    let mut pairs: Vec<(Measure, Measure)> = first
        .iter()
        .map(|measure| (*measure, of(&second, measure.name).unwrap_or_else(|| none(*measure))))
        .collect();
    let more = second.iter().filter(|measure| of(&first, measure.name).is_none());
    pairs.extend(more.map(|measure| (none(*measure), *measure)));
    pairs
}

fn differing(a: &Results, b: &Results) -> Vec<(&'static str, String, String)> {
    let pairs = settings(&a.plan).into_iter().zip(settings(&b.plan));
    pairs
        .filter(|((_, first), (_, second))| first != second)
        .map(|((name, first), (_, second))| (name, first, second))
        .collect()
}
