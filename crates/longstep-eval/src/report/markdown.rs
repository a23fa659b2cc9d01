//! The report as a Markdown document.

use longstep_core::visible;

use super::grid::{self, Grid};
use super::mark::Mark;
use super::words::expected;
use super::{amount, came, duration, groups, interval, label, measures, not_correct, paper, percent, reason, settings};
use crate::attempt::Attempt;
use crate::folder::Results;
use crate::summary::Summary;

pub(super) fn document(results: &Results) -> String {
    let summary = Summary::of(&results.attempts, &results.timings);
    let plan = &results.plan;
    let mut lines = vec![
        format!("# Suite {}, {}", escaped(&plan.suite), escaped(&plan.model)),
        String::new(),
        format!("{}.", escaped(&settings::line(plan))),
        String::new(),
    ];
    lines.extend(measured(&summary));
    if paper::is_paper(results) {
        lines.extend(table(results));
    }
    if paper::has_rounds(results) {
        lines.extend(rounds(results));
    }
    if !summary.failures.is_empty() {
        lines.push("## Failures".to_owned());
        lines.push(String::new());
        lines.extend(head(&["kind", "attempts"]));
        let kinds = summary.failures.iter();
        lines.extend(kinds.map(|(kind, count)| row([kind.name().to_owned(), count.to_string()])));
        lines.push(String::new());
    }
    for (heading, groups) in groups::groupings(results) {
        lines.push(format!("## {heading}"));
        lines.push(String::new());
        lines.extend(head(&["", "correct", "95 %", "executable", "95 %"]));
        for group in groups {
            let (correct, executable) = (group.correct, group.executable);
            lines.push(row([
                escaped(&group.name),
                format!("{} ({}/{})", percent(correct), correct.hits, correct.of),
                interval(correct),
                format!("{} ({}/{})", percent(executable), executable.hits, executable.of),
                interval(executable),
            ]));
        }
        lines.push(String::new());
    }
    lines.extend(wrong(results));
    lines.push("## Settings".to_owned());
    lines.push(String::new());
    lines.extend(head(&["", "value"]));
    lines.extend(
        settings::settings(plan)
            .into_iter()
            .map(|(name, value)| row([name.to_owned(), escaped(&value)])),
    );
    lines.join("\n") + "\n"
}

fn measured(summary: &Summary) -> Vec<String> {
    let mut lines = head(&["measure", "share", "of", "95 % interval", "definition"]);
    lines.extend(measures(summary).into_iter().map(|measure| {
        let rate = measure.rate;
        row([
            measure.name.to_owned(),
            percent(rate),
            format!("{}/{}", rate.hits, rate.of),
            interval(rate),
            measure.about.to_owned(),
        ])
    }));
    let cost = summary.cost;
    lines.push(String::new());
    lines.push(format!(
        "Median time {}, {} in total. Median tokens {} in the prompts and {} in the answers, {} of the prompts' \
         from the cache; {} calls. {:.2} edits for each plan.",
        duration(cost.total_ms),
        duration(cost.sum_seconds * 1000.0),
        amount(cost.prompt_tokens),
        amount(cost.completion_tokens),
        amount(cost.cached_tokens),
        amount(cost.calls),
        summary.edits
    ));
    lines.push(String::new());
    lines
}

/// The table of trials, with the paper's row at its end.
fn table(results: &Results) -> Vec<String> {
    let mut lines = vec!["## Scenario by scenario".to_owned(), String::new()];
    lines.extend(by_case(
        results,
        "",
        |attempt| Mark::of(attempt).sign().to_owned(),
        (paper::first_row(results), |case| {
            paper::trials(case).map(|right| format!("{right}/5"))
        }),
    ));
    lines.push(String::new());
    let legend = Mark::ALL.iter().map(|mark| format!("{} {}", mark.sign(), mark.name()));
    lines.push(format!("{}.", legend.collect::<Vec<_>>().join(", ")));
    if let Some(agreement) = paper::agreement(results) {
        lines.push(String::new());
        lines.push(format!("{}.", escaped(&agreement.sentence())));
    }
    lines.push(String::new());
    lines
}

fn rounds(results: &Results) -> Vec<String> {
    let mut lines = vec!["## Rounds of feedback".to_owned(), String::new()];
    if paper::is_paper(results) {
        lines.extend(by_case(
            results,
            "rounds",
            |attempt| {
                if attempt.executable {
                    attempt.rounds.to_string()
                } else {
                    format!("{} ✗", attempt.rounds)
                }
            },
            ("The paper", |case| paper::rounds(case).map(|rounds| rounds.to_string())),
        ));
    } else {
        lines.extend(head(&["attempt", "rounds", "executable"]));
        let needed = results.attempts.iter().filter(|attempt| attempt.rounds > 0);
        lines.extend(needed.map(|attempt| {
            let yes = if attempt.executable { "yes" } else { "no" };
            row([
                escaped(&label(results, attempt)),
                attempt.rounds.to_string(),
                yes.to_owned(),
            ])
        }));
    }
    lines.push(String::new());
    lines
}

/// A table with a column for each case, a cell for each attempt, and the paper's row at its end.
fn by_case(
    results: &Results,
    corner: &str,
    cell: impl Fn(&Attempt) -> String,
    (name, paper): (&str, impl Fn(&str) -> Option<String>),
) -> Vec<String> {
    let Grid { cases, rows } = grid::grid(results);
    let mut lines = head(&[&[corner], &cases[..]].concat());
    for one in &rows {
        let cells = one
            .cells
            .iter()
            .map(|shown| shown.map_or_else(String::new, |(_, attempt)| cell(attempt)));
        lines.push(row(std::iter::once(escaped(&one.name)).chain(cells)));
    }
    let cells = cases.iter().map(|case| paper(case).unwrap_or_default());
    lines.push(row(std::iter::once(name.to_owned()).chain(cells)));
    lines
}

fn wrong(results: &Results) -> Vec<String> {
    let wrong = not_correct(results);
    if wrong.is_empty() {
        return Vec::new();
    }
    let mut lines = vec!["## Incorrect attempts".to_owned(), String::new()];
    lines.extend(wrong.into_iter().map(|(_, attempt)| {
        format!(
            "- **{}**: \u{201c}{}\u{201d} Expected: {}. Result: {}. Reason: {}.",
            escaped(&label(results, attempt)),
            escaped(&attempt.says),
            escaped(&expected(&attempt.expected)),
            escaped(&came(attempt)),
            escaped(&reason(attempt))
        )
    }));
    lines.push(String::new());
    lines
}

/// The header and the delimiter row of a table.
fn head(names: &[&str]) -> Vec<String> {
    let escaped = names.iter().map(|name| escaped(name));
    vec![row(escaped), row(names.iter().map(|_| "---".to_owned()))]
}

/// A row of a table.
pub(crate) fn row(cells: impl IntoIterator<Item = String>) -> String {
    let cells: Vec<String> = cells.into_iter().collect();
    format!("| {} |", cells.join(" | "))
}

/// Escapes text for one line of Markdown. Invisible characters become visible escapes.
pub(crate) fn escaped(text: &str) -> String {
    let mut markdown = String::new();
    let line = text.replace(['\n', '\r'], " ");
    for letter in visible::line(&line).chars() {
        match letter {
            '&' => markdown.push_str("&amp;"),
            '<' => markdown.push_str("&lt;"),
            '>' => markdown.push_str("&gt;"),
            '|' | '*' | '_' | '`' | '[' | ']' | '\\' | '#' | '~' => markdown.extend(['\\', letter]),
            other => markdown.push(other),
        }
    }
    markdown
}
