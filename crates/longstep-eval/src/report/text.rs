//! The report as text for the terminal.

use super::grid::{self, Grid};
use super::mark::Mark;
use super::{amount, duration, interval, measures, not_correct, paper, percent, settings};
use crate::folder::Results;
use crate::summary::Summary;

/// Number of kinds of failures to list.
const KINDS: usize = 6;

/// Largest number of rows to list.
const ROWS: usize = 5;

pub(super) fn lines(results: &Results) -> Vec<String> {
    let summary = Summary::of(&results.attempts, &results.timings);
    let plan = &results.plan;
    let mut lines = vec![
        format!("Suite {}, {}", plan.suite, plan.model),
        format!("  {}", settings::line(plan)),
        String::new(),
    ];
    for measure in measures(&summary) {
        let rate = measure.rate;
        lines.push(format!(
            "  {:<17}{:>7}  {:<9} 95 %: {}",
            measure.name,
            percent(rate),
            format!("{}/{}", rate.hits, rate.of),
            interval(rate)
        ));
    }
    let cost = summary.cost;
    lines.push(format!("  {:<17}{:>7.2}  for each plan", "edits", summary.edits));
    lines.push(format!(
        "  {:<17}{:>7}  median; {} in total; {} + {} tokens, {} calls",
        "time",
        duration(cost.total_ms),
        duration(cost.sum_seconds * 1000.0),
        amount(cost.prompt_tokens),
        amount(cost.completion_tokens),
        amount(cost.calls)
    ));
    if !summary.failures.is_empty() {
        let mut failures = summary.failures.clone();
        // The sort is stable: equally frequent kinds keep their order.
        failures.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let named = failures.iter().take(KINDS);
        let named: Vec<String> = named.map(|(kind, count)| format!("{} {count}", kind.name())).collect();
        lines.push(format!("  Failures: {}", named.join(", ")));
    }
    if paper::is_paper(results) {
        lines.push(String::new());
        lines.extend(table(results));
    } else {
        let wrong = not_correct(results).len();
        lines.push(format!("  {wrong} of {} are not correct", results.attempts.len()));
    }
    lines
}

/// The table of trials, with the paper's row at its end.
fn table(results: &Results) -> Vec<String> {
    let Grid { cases, rows } = grid::grid(results);
    let row = |name: &str, cells: Vec<String>| {
        let cells: String = cells.iter().map(|cell| format!("{cell:>4}")).collect();
        format!("  {name:<22}{cells}")
    };
    let or_none = |value: Option<String>| value.unwrap_or_else(|| "-".to_owned());
    let mut lines = vec![row("Scenario", cases.iter().map(|case| (*case).to_owned()).collect())];
    let rounds = paper::has_rounds(results);
    for one in rows.iter().take(ROWS) {
        let signs = one
            .cells
            .iter()
            .map(|cell| cell.map(|(_, a)| Mark::of(a).letter().to_string()));
        lines.push(row(&one.name, signs.map(or_none).collect()));
        if rounds {
            let counts = one.cells.iter().map(|cell| cell.map(|(_, a)| a.rounds.to_string()));
            lines.push(row("  rounds", counts.map(or_none).collect()));
        }
    }
    if rows.len() > ROWS {
        lines.push(format!("  and {} rows more", rows.len() - ROWS));
    }
    let paper: Vec<String> = if rounds {
        cases
            .iter()
            .map(|case| or_none(paper::rounds(case).map(|n| n.to_string())))
            .collect()
    } else {
        cases
            .iter()
            .map(|case| or_none(paper::trials(case).map(|n| format!("{n}/5"))))
            .collect()
    };
    lines.push(row(if rounds { "The paper's rounds" } else { "The paper" }, paper));
    if let Some(agreement) = paper::agreement(results) {
        lines.push(format!("  {}", agreement.sentence()));
    }
    let legend = Mark::ALL
        .iter()
        .map(|mark| format!("{} {}", mark.letter(), mark.name()));
    lines.push(format!("  {}", legend.collect::<Vec<_>>().join(", ")));
    lines
}
