//! The page's tables of all attempts.

use super::grid::{self, Grid, Row};
use super::mark::Mark;
use super::markup::{escaped, scrolling};
use super::{detail, paper};
use crate::attempt::Attempt;
use crate::folder::Results;
use crate::rate::Rate;

/// Largest number of cases for a table with a column for each; wider ones are unreadable.
const COLUMNS: usize = 20;

fn legend() -> String {
    let entry = |mark: &Mark| {
        format!(
            "<li><span class=\"square {}\" aria-hidden=\"true\">{}</span> {}</li>",
            mark.class(),
            mark.sign(),
            mark.name()
        )
    };
    let entries: String = Mark::ALL.iter().map(entry).collect();
    format!("<ul class=\"legend\">{entries}</ul>\n")
}

/// All attempts: in the form of the paper's table for the paper's scenarios, by scene otherwise.
pub(super) fn attempts(results: &Results) -> String {
    if results.attempts.is_empty() {
        return "<p>Nothing has been run yet.</p>\n".to_owned();
    }
    if !paper::is_paper(results) {
        return legend() + &scenes(results);
    }
    let grid = grid::grid(results);
    let cell = |cell: &Option<(usize, &Attempt)>| match cell {
        Some((place, attempt)) => format!("<td>{}</td>", detail::square(results, *place, attempt)),
        None => "<td></td>".to_owned(),
    };
    let sum = |row: &Row<'_>| {
        let attempts = row.cells.iter().flatten();
        let executable = Rate::count(attempts, |(_, attempt)| attempt.executable);
        format!("<td class=\"sum\">{}/{}</td>", executable.hits, executable.of)
    };
    let theirs = grid.cases.iter().map(|case| {
        let right = paper::trials(case);
        let class = if right == Some(5) { "right" } else { "" };
        let text = right.map_or_else(String::new, |right| format!("{right}/5"));
        format!("<td class=\"{class}\">{text}</td>")
    });
    let theirs: String = theirs.collect();
    let table = table(
        &grid,
        "Scenario",
        "executable",
        cell,
        sum,
        (
            paper::first_row(results),
            &format!("{theirs}<td class=\"sum\">5/14</td>"),
        ),
    );
    let note = if paper::has_rounds(results) {
        String::new()
    } else {
        agreement(results)
    };
    legend() + &scrolling("Scenarios and trials", &table) + &note
}

/// Rows in the form of the paper's tables, with the paper's row at the end.
fn table(
    grid: &Grid<'_>,
    corner: &str,
    last: &str,
    cell: impl Fn(&Option<(usize, &Attempt)>) -> String,
    sum: impl Fn(&Row<'_>) -> String,
    (whose, theirs): (&str, &str),
) -> String {
    let names: String = grid
        .cases
        .iter()
        .map(|case| format!("<th scope=\"col\">{}</th>", escaped(case)))
        .collect();
    let row = |row: &Row<'_>| {
        let cells: String = row.cells.iter().map(&cell).collect();
        format!(
            "<tr><th scope=\"row\">{}</th>{cells}{}</tr>\n",
            escaped(&row.name),
            sum(row)
        )
    };
    let rows: String = grid.rows.iter().map(row).collect();
    let theirs = if theirs.is_empty() {
        String::new()
    } else {
        format!("<tfoot><tr><th scope=\"row\">{whose}</th>{theirs}</tr></tfoot>")
    };
    format!(
        "<table class=\"grid\"><thead><tr><th scope=\"col\">{corner}</th>{names}<th \
         scope=\"col\">{last}</th></tr></thead>\n\
         <tbody>{rows}</tbody>{theirs}</table>"
    )
}

/// A small square for each attempt, grouped by case.
fn scenes(results: &Results) -> String {
    let square = |(place, attempt): &(usize, &Attempt)| detail::square(results, *place, attempt);
    let case = |(name, attempts): &(&str, Vec<(usize, &Attempt)>)| {
        let squares: String = attempts.iter().map(square).collect();
        format!("<span class=\"case\" title=\"{}\">{squares}</span>\n", escaped(name))
    };
    let scene = |scene: grid::Scene<'_>| {
        let all = scene.cases.iter().flat_map(|(_, attempts)| attempts);
        let correct = Rate::count(all, |(_, attempt)| attempt.correct);
        let cases: String = scene.cases.iter().map(case).collect();
        format!(
            "<div class=\"scene\"><h3>{} <small>{} of {} correct</small></h3><div \
             class=\"cases\">{cases}</div></div>\n",
            escaped(scene.name),
            correct.hits,
            correct.of
        )
    };
    grid::scenes(results).into_iter().map(scene).collect()
}

/// Rounds by case, in the form of the paper's second table; with many cases, the attempts by number of rounds.
pub(super) fn rounds(results: &Results) -> String {
    let mut grid = grid::grid(results);
    let paper = paper::is_paper(results);
    if !paper && (grid.cases.len() > COLUMNS || results.attempts.iter().any(|attempt| attempt.key.step > 0)) {
        return needed(results);
    }
    let count = |attempt: &Attempt| {
        if attempt.executable || !attempt.wants_plan() {
            attempt.rounds.to_string()
        } else {
            format!("{}&nbsp;✗", attempt.rounds)
        }
    };
    let cell = |cell: &Option<(usize, &Attempt)>| match cell {
        Some((place, attempt)) => {
            format!("<td><a href=\"#{}\">{}</a></td>", detail::id(*place), count(attempt))
        }
        None => "<td></td>".to_owned(),
    };
    let sum = |row: &Row<'_>| {
        let all: u32 = row.cells.iter().flatten().map(|(_, attempt)| attempt.rounds).sum();
        format!("<td class=\"sum\">{all}</td>")
    };
    let theirs: String = if paper {
        let known = |case: &&str| paper::rounds(case);
        let cells = grid.cases.iter().map(|case| {
            let rounds = known(case).map_or_else(String::new, |rounds| rounds.to_string());
            format!("<td>{rounds}</td>")
        });
        let cells: String = cells.collect();
        let all: u32 = grid.cases.iter().filter_map(known).sum();
        format!("{cells}<td class=\"sum\">{all}</td>")
    } else {
        String::new()
    };
    if let [row] = &mut grid.rows[..] {
        row.name = "This run".to_owned();
    }
    let corner = if paper { "Scenario" } else { "Case" };
    let table = table(&grid, corner, "sum", cell, sum, ("The paper", &theirs));
    let note =
        "<p class=\"quiet\">How often the model was told what was wrong; ✗ where that did not lead to a plan.</p>\n";
    scrolling("Rounds of feedback", &table) + note + &agreement(results)
}

/// The attempts that needed rounds: most of many cases need none.
fn needed(results: &Results) -> String {
    let most = results.attempts.iter().map(|attempt| attempt.rounds).max().unwrap_or(0);
    let row = |rounds: u32| {
        let all = results
            .attempts
            .iter()
            .enumerate()
            .filter(|(_, attempt)| attempt.rounds == rounds);
        let all: Vec<String> = all
            .map(|(place, attempt)| detail::square(results, place, attempt))
            .collect();
        let shown = if rounds == 0 { String::new() } else { all.concat() };
        format!(
            "<tr><th scope=\"row\">{rounds}</th><td class=\"number\">{}</td><td><div \
             class=\"cases\">{shown}</div></td></tr>\n",
            all.len()
        )
    };
    let rows: String = (0..=most).map(row).collect();
    format!(
        "<table><thead><tr><th scope=\"col\">rounds</th><th scope=\"col\" class=\"number\">attempts</th><th \
         scope=\"col\">which</th></tr></thead><tbody>{rows}</tbody></table>\n"
    )
}

fn agreement(results: &Results) -> String {
    paper::agreement(results).map_or_else(String::new, |agreement| {
        format!("<p>{}.</p>\n", escaped(&agreement.sentence()))
    })
}
