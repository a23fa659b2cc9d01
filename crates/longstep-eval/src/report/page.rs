//! The report as an HTML page.

use super::markup::{Page, escaped, scrolling, section, whole};
use super::words::expected;
use super::{
    amount, came, charts, detail, duration, groups, interval, measures, not_correct, paper, percent, reason, settings,
    tables,
};
use crate::attempt::Attempt;
use crate::failure::Failure;
use crate::folder::Results;
use crate::rate::Rate;
use crate::summary::Summary;

pub(super) fn page(results: &Results) -> String {
    let summary = Summary::of(&results.attempts, &results.timings);
    let mut body = headline(&summary);
    if paper::is_paper(results) {
        let bars = charts::bars(&paper::shares(results, &summary));
        let note = "<p class=\"quiet\">Whiskers are 95 % intervals. The paper's 36 % is 5 of 14 scenarios; all five \
                    trials of a scenario came out alike.</p>\n";
        body += &section("paper", "Comparison with the paper", &(bars + note));
    }
    body += &section("grid", "Every attempt", &tables::attempts(results));
    if paper::has_rounds(results) {
        body += &section("rounds", "Rounds of feedback", &tables::rounds(results));
    }
    body += &section("failures", "Failures by kind", &failures(results, &summary));
    body += &section("groups", "Groups of attempts", &groupings(results));
    body += &section("cost", "Time and tokens", &cost(results, &summary));
    body += &section("wrong", "Incorrect attempts", &wrong(results));
    body += &section("run", "Settings", &run(results));
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
                "<li title=\"{}\"><span class=\"name\">{}</span><b>{}</b>{}<small>{} of {}<span \
                 class=\"interval\">{}</span></small></li>\n",
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
        format!("{} in total", duration(cost.sum_seconds * 1000.0)),
    );
    plain(
        "median tokens",
        amount(cost.prompt_tokens),
        format!("in the prompts; {} in the answers", amount(cost.completion_tokens)),
    );
    plain("edits", format!("{:.2}", summary.edits), "for each plan".to_owned());
    format!(
        "<ul class=\"tiles\">\n{}</ul>\n<p class=\"quiet\">Below each rate: the counts and the 95 % interval. \
         The whiskers show the same interval.</p>\n",
        tiles.concat()
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
    if rows.is_empty() {
        rows
    } else {
        format!(
            "<p class=\"quiet\">A mistake in the first reply counts even if it was corrected later. Open a kind \
         to see its attempts.</p>\n<div class=\"kinds\">\n{rows}</div>\n"
        )
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
    if all.is_empty() {
        all
    } else {
        format!("<div class=\"columns\">{all}</div>\n")
    }
}

fn cost(results: &Results, summary: &Summary) -> String {
    let cost = summary.cost;
    let rows = [
        ("median time", duration(cost.total_ms)),
        ("median time of the model", duration(cost.model_ms)),
        ("in total", duration(cost.sum_seconds * 1000.0)),
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
            "<li>{} <b>{}</b><p class=\"says\">{}</p><dl><dt>Expected</dt><dd>{}</dd><dt>Result</dt><dd>{}</dd><dt>Reason\
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
    if entries.is_empty() {
        entries
    } else {
        format!("<ul class=\"wrong\">\n{entries}</ul>\n")
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
