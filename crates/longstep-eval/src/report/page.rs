//! A run as a page.

use super::grid::{self, Grid, Row};
use super::mark::Mark;
use super::markup::{Page, escaped, scrolling, section, whole};
use super::words::{came, expected};
use super::{
    amount, charts, detail, duration, groups, interval, measures, not_correct, paper, percent, reason, settings,
};
use crate::attempt::Attempt;
use crate::failure::Failure;
use crate::folder::Results;
use crate::rate::Rate;
use crate::summary::Summary;

/// With more cases than this, a table with a column for each is no longer looked at.
const COLUMNS: usize = 20;

pub(super) fn page(results: &Results) -> String {
    let summary = Summary::of(&results.attempts, &results.timings);
    let mut body = headline(&summary);
    if paper::is_paper(results) {
        let bars = charts::bars(&paper::shares(results, &summary));
        let note = "<p class=\"quiet\">Whiskers are 95 % intervals. The paper's 36 % is 5 of 14 scenarios; all five trials \
                    of a scenario came out alike.</p>\n";
        body += &section("paper", "Beside the paper", &(bars + note));
    }
    body += &section("grid", "Every attempt", &attempts(results));
    if paper::has_rounds(results) {
        body += &section("rounds", "Rounds of feedback", &rounds(results));
    }
    body += &section("failures", "What went wrong, by kind", &failures(results, &summary));
    body += &section("groups", "By what attempts have in common", &groupings(results));
    body += &section("cost", "Time and tokens", &cost(results, &summary));
    body += &section("wrong", "What is not correct", &wrong(results));
    body += &section("run", "What was run", &run(results));
    let all = results.attempts.iter().enumerate();
    let articles: String = all
        .map(|(place, attempt)| detail::article(results, place, attempt))
        .collect();
    body += &format!("<div id=\"attempts\">\n{articles}</div>\n");
    whole(&Page {
        title: format!("Suite {}, {}", results.plan.suite, results.plan.model),
        about: settings::line(&results.plan),
        body,
    })
}

fn headline(summary: &Summary) -> String {
    let mut tiles: Vec<String> = measures(summary)
        .into_iter()
        .map(|measure| {
            let rate = measure.rate;
            let class = if measure.wanted { "ours" } else { "unwanted" };
            format!(
                "<li title=\"{}\"><span class=\"name\">{}</span><b>{}</b>{}<small>{} of {}<br>95 %: {}</small></li>\n",
                measure.about,
                measure.name,
                percent(rate),
                charts::bar(rate, class),
                rate.hits,
                rate.of,
                interval(rate)
            )
        })
        .collect();
    let cost = summary.cost;
    let mut plain = |name: &str, figure: String, note: String| {
        tiles.push(format!(
            "<li><span class=\"name\">{name}</span><b>{figure}</b><small>{note}</small></li>\n"
        ));
    };
    plain(
        "median time",
        duration(cost.total_ms),
        format!("{} all together", duration(cost.sum_seconds * 1000.0)),
    );
    plain(
        "median tokens",
        amount(cost.prompt_tokens + cost.completion_tokens),
        format!(
            "{} in the prompts, {} in the answers",
            amount(cost.prompt_tokens),
            amount(cost.completion_tokens)
        ),
    );
    plain("edits", format!("{:.2}", summary.edits), "for each plan".to_owned());
    format!("<ul class=\"tiles\">\n{}</ul>\n", tiles.concat())
}

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

fn attempts(results: &Results) -> String {
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
        &format!("{theirs}<td class=\"sum\">5/14</td>"),
    );
    let note = match paper::agreement(results) {
        Some(agreement) => format!("<p>{}.</p>\n", escaped(&agreement.sentence())),
        None => String::new(),
    };
    legend() + &scrolling("Scenarios and trials", &table) + &note
}

/// Rows as in the paper's tables, with the paper's own below.
fn table(
    grid: &Grid<'_>,
    corner: &str,
    last: &str,
    cell: impl Fn(&Option<(usize, &Attempt)>) -> String,
    sum: impl Fn(&Row<'_>) -> String,
    theirs: &str,
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
    let theirs = match theirs.is_empty() {
        true => String::new(),
        false => format!("<tfoot><tr><th scope=\"row\">The paper</th>{theirs}</tr></tfoot>"),
    };
    format!(
        "<table class=\"grid\"><thead><tr><th scope=\"col\">{corner}</th>{names}<th scope=\"col\">{last}</th></tr></thead>\n\
         <tbody>{rows}</tbody>{theirs}</table>"
    )
}

/// A small square for each attempt, those of a case together.
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
            "<div class=\"scene\"><h3>{} <small>{} of {} correct</small></h3><div class=\"cases\">{cases}</div></div>\n",
            escaped(scene.name),
            correct.hits,
            correct.of
        )
    };
    grid::scenes(results).into_iter().map(scene).collect()
}

fn rounds(results: &Results) -> String {
    let mut grid = grid::grid(results);
    let paper = paper::is_paper(results);
    if !paper && (grid.cases.len() > COLUMNS || results.attempts.iter().any(|attempt| attempt.key.step > 0)) {
        return needed(results);
    }
    let count = |attempt: &Attempt| match attempt.executable || !attempt.wants_plan() {
        true => attempt.rounds.to_string(),
        false => format!("{}&nbsp;✗", attempt.rounds),
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
    let theirs: String = match paper {
        true => {
            let known = |case: &&str| paper::rounds(case);
            let cells = grid.cases.iter().map(|case| {
                let rounds = known(case).map_or_else(String::new, |rounds| rounds.to_string());
                format!("<td>{rounds}</td>")
            });
            let cells: String = cells.collect();
            let all: u32 = grid.cases.iter().filter_map(known).sum();
            format!("{cells}<td class=\"sum\">{all}</td>")
        }
        false => String::new(),
    };
    if let [row] = &mut grid.rows[..] {
        row.name = "This run".to_owned();
    }
    let corner = if paper { "Scenario" } else { "Case" };
    let table = table(&grid, corner, "sum", cell, sum, &theirs);
    let note =
        "<p class=\"quiet\">How often the model was told what was wrong; ✗ where that did not lead to a plan.</p>\n";
    scrolling("Rounds of feedback", &table) + note
}

/// Only the attempts that needed rounds: of many cases, most need none.
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
            "<tr><th scope=\"row\">{rounds}</th><td class=\"number\">{}</td><td class=\"cases\">{shown}</td></tr>\n",
            all.len()
        )
    };
    let rows: String = (0..=most).map(row).collect();
    format!(
        "<table><thead><tr><th scope=\"col\">rounds</th><th scope=\"col\" class=\"number\">attempts</th><th \
         scope=\"col\">which</th></tr></thead><tbody>{rows}</tbody></table>\n"
    )
}

fn failures(results: &Results, summary: &Summary) -> String {
    let mut failures = summary.failures.clone();
    failures.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let most = failures.first().map_or(0, |(_, count)| *count);
    let row = |(kind, count): &(Failure, usize)| {
        let with = results
            .attempts
            .iter()
            .enumerate()
            .filter(|(_, attempt)| attempt.failures.contains(kind));
        let links: Vec<String> = with
            .map(|(place, attempt)| detail::link(results, place, attempt))
            .collect();
        format!(
            "<details><summary><span class=\"name\">{}</span>{}<span class=\"figure\">{count}</span></summary><ul \
             class=\"links\"><li>{}</li></ul></details>\n",
            kind.name(),
            charts::count_bar(*count, most),
            links.join("</li><li>")
        )
    };
    let rows: String = failures.iter().map(row).collect();
    match rows.is_empty() {
        true => rows,
        false => format!(
            "<p class=\"quiet\">What the first reply lacked counts even where it was mended later. Open a kind to see its \
             attempts.</p>\n<div class=\"kinds\">\n{rows}</div>\n"
        ),
    }
}

fn groupings(results: &Results) -> String {
    let share = |rate: Rate| match rate.of {
        0 => "<td colspan=\"3\" class=\"quiet\">no plan expected</td>".to_owned(),
        of => format!(
            "<td class=\"number\">{}</td><td class=\"number\">{}/{of}</td><td class=\"quiet interval\">{}</td>",
            percent(rate),
            rate.hits,
            interval(rate)
        ),
    };
    let one = |(heading, groups): (&str, Vec<groups::Group>)| {
        let row = |group: &groups::Group| {
            format!(
                "<tr><th scope=\"row\">{}</th>{}{}</tr>\n",
                escaped(&group.name),
                share(group.correct),
                share(group.executable)
            )
        };
        let rows: String = groups.iter().map(row).collect();
        let table = format!(
            "<table><thead><tr><th></th><th scope=\"col\" colspan=\"3\">correct</th><th scope=\"col\" \
             colspan=\"3\">executable</th></tr></thead><tbody>{rows}</tbody></table>"
        );
        format!("<div><h3>{heading}</h3>{}</div>\n", scrolling(heading, &table))
    };
    let all: String = groups::groupings(results).into_iter().map(one).collect();
    match all.is_empty() {
        true => all,
        false => format!("<div class=\"columns\">{all}</div>\n"),
    }
}

fn cost(results: &Results, summary: &Summary) -> String {
    let cost = summary.cost;
    let rows = [
        ("median time", duration(cost.total_ms)),
        ("median time of the model", duration(cost.model_ms)),
        ("all together", duration(cost.sum_seconds * 1000.0)),
        ("median tokens in prompts", amount(cost.prompt_tokens)),
        ("of these from the cache", amount(cost.cached_tokens)),
        ("median tokens in answers", amount(cost.completion_tokens)),
        ("calls to the model", amount(cost.calls)),
    ];
    let rows: String = rows
        .iter()
        .map(|(name, value)| format!("<tr><th scope=\"row\">{name}</th><td class=\"number\">{value}</td></tr>\n"))
        .collect();
    let attempts = results.attempts.iter();
    let times: Vec<f64> = attempts
        .filter_map(|attempt| Some(results.timings.get(&attempt.key)?.total_ms))
        .collect();
    format!(
        "<div class=\"cost\"><table><tbody>{rows}</tbody></table>{}</div>\n",
        charts::histogram(&times)
    )
}

fn wrong(results: &Results) -> String {
    let entry = |(place, attempt): (usize, &Attempt)| {
        format!(
            "<li>{} <b>{}</b><p class=\"says\">{}</p><dl><dt>Expected</dt><dd>{}</dd><dt>Came</dt><dd>{}</dd><dt>Why\
             </dt><dd>{}</dd></dl></li>\n",
            detail::square(results, place, attempt),
            detail::link(results, place, attempt),
            escaped(&attempt.says),
            escaped(&expected(&attempt.expected)),
            escaped(&came(attempt)),
            escaped(&reason(attempt))
        )
    };
    let entries: String = not_correct(results).into_iter().map(entry).collect();
    match entries.is_empty() {
        true => entries,
        false => format!("<ul class=\"wrong\">\n{entries}</ul>\n"),
    }
}

fn run(results: &Results) -> String {
    let row =
        |(name, value): &(&str, String)| format!("<tr><th scope=\"row\">{name}</th><td>{}</td></tr>\n", escaped(value));
    let rows: String = settings::settings(&results.plan).iter().map(row).collect();
    format!(
        "<details><summary>Every setting</summary><table class=\"settings\"><tbody>{rows}</tbody></table></details>\n"
    )
}
