//! A comparison as text, Markdown and HTML.

use super::{Change, Comparison};
use crate::rate::Rate;
use crate::report::{
    Measure, Page, amount, duration, escaped, interval, markdown_escaped, markdown_row, percent, points, whole,
};

/// Number of changed attempts that the terminal lists, for each direction.
const NAMED: usize = 10;

/// A row: name, first run, second run, difference.
type Line = [String; 4];

/// Rows for shares, with their counts.
fn shares(comparison: &Comparison) -> impl Iterator<Item = Line> {
    let shown = |rate: Rate| match rate.of {
        0 => "none".to_owned(),
        of => format!("{} ({}/{of})", percent(rate), rate.hits),
    };
    comparison
        .measures
        .iter()
        .map(move |(first, second): &(Measure, Measure)| {
            let difference = match (first.rate.of, second.rate.of) {
                (0, _) | (_, 0) => String::new(),
                _ => points(first.rate, second.rate),
            };
            [first.name.to_owned(), shown(first.rate), shown(second.rate), difference]
        })
}

/// Rows for costs.
fn costs(comparison: &Comparison) -> [Line; 5] {
    let (first, second) = comparison.costs;
    let part = |before: f64, after: f64| {
        if before > 0.0 {
            format!("{:+.0} %", (after / before - 1.0) * 100.0)
        } else {
            String::new()
        }
    };
    let count = |name: &str, before: u64, after: u64| {
        [
            name.to_owned(),
            amount(before),
            amount(after),
            part(before as f64, after as f64),
        ]
    };
    let (few, many) = comparison.edits;
    [
        [
            "median time".to_owned(),
            duration(first.total_ms),
            duration(second.total_ms),
            part(first.total_ms, second.total_ms),
        ],
        count("tokens in prompts", first.prompt_tokens, second.prompt_tokens),
        count("tokens in answers", first.completion_tokens, second.completion_tokens),
        count("calls", first.calls, second.calls),
        [
            "edits for each plan".to_owned(),
            format!("{few:.2}"),
            format!("{many:.2}"),
            format!("{:+.2}", many - few),
        ],
    ]
}

/// The numbers of changed attempts and the p value.
fn verdict(comparison: &Comparison) -> String {
    let (mended, broken) = (comparison.mended.len(), comparison.broken.len());
    format!(
        "{mended} from wrong to right, {broken} from right to wrong; p = {} (McNemar, exact, two-sided)",
        chance(comparison.chance)
    )
}

fn chance(p: f64) -> String {
    if p < 0.0001 {
        "less than 0.0001".to_owned()
    } else {
        format!("{p:.4}")
    }
}

/// Both lists of changed attempts, with the labels of the right and the wrong result.
fn changes(comparison: &Comparison) -> [(&'static str, [&'static str; 2], &[Change]); 2] {
    [
        ("From wrong to right", ["Right now", "Was wrong"], &comparison.mended),
        ("From right to wrong", ["Was right", "Wrong now"], &comparison.broken),
    ]
}

pub(super) fn text(comparison: &Comparison) -> Vec<String> {
    let mut lines = vec![comparison.title.clone(), String::new()];
    lines.extend(comparison.notes.iter().map(|note| format!("  {note}")));
    let line = |[name, before, after, difference]: Line| {
        format!("  {name:<20}{before:>18}{after:>18}  {difference}")
            .trim_end()
            .to_owned()
    };
    lines.extend(shares(comparison).map(line));
    lines.extend(costs(comparison).map(line));
    lines.push(String::new());
    lines.push(format!("  {}", verdict(comparison)));
    for (heading, _, changes) in changes(comparison) {
        if changes.is_empty() {
            continue;
        }
        lines.push(format!("  {heading}"));
        let named = changes.iter().take(NAMED);
        lines.extend(named.map(|change| format!("    {}: {}", change.label, change.why)));
        if changes.len() > NAMED {
            lines.push(format!("    and {} more", changes.len() - NAMED));
        }
    }
    if !comparison.settings.is_empty() {
        lines.push("  Differences in the settings".to_owned());
        let settings = comparison.settings.iter();
        lines.extend(settings.map(|(name, before, after)| format!("    {name}: {before} -> {after}")));
    }
    lines
}

pub(super) fn markdown(comparison: &Comparison) -> String {
    let escaped = markdown_escaped;
    let (first, second) = &comparison.names;
    let (first, second) = (escaped(first), escaped(second));
    let row = |line: Line| markdown_row(line.iter().map(|cell| escaped(cell)));
    let mut lines = vec![format!("# {}", escaped(&comparison.title)), String::new()];
    for note in &comparison.notes {
        lines.extend([escaped(note), String::new()]);
    }
    let rule = |columns: usize| markdown_row(std::iter::repeat_n("---".to_owned(), columns));
    lines.push(markdown_row([
        "measure".to_owned(),
        first.clone(),
        second.clone(),
        "difference".to_owned(),
    ]));
    lines.push(rule(4));
    lines.extend(shares(comparison).map(row));
    lines.extend(costs(comparison).map(row));
    lines.extend([String::new(), format!("{}.", verdict(comparison)), String::new()]);
    for (heading, [right, wrong], changes) in changes(comparison) {
        if changes.is_empty() {
            continue;
        }
        lines.extend([format!("## {heading}"), String::new()]);
        lines.extend(changes.iter().map(|change| {
            format!(
                "- **{}**: \u{201c}{}\u{201d} {wrong}: {}. {right}: {}.",
                escaped(&change.label),
                escaped(&change.says),
                escaped(&change.why),
                escaped(&change.right)
            )
        }));
        lines.push(String::new());
    }
    if !comparison.settings.is_empty() {
        lines.extend(["## Differences in the settings".to_owned(), String::new()]);
        lines.push(markdown_row([String::new(), first, second]));
        lines.push(rule(3));
        let settings = comparison.settings.iter();
        lines.extend(
            settings.map(|(name, before, after)| markdown_row([(*name).to_owned(), escaped(before), escaped(after)])),
        );
    }
    lines.join("\n").trim_end().to_owned() + "\n"
}

pub(super) fn html(comparison: &Comparison) -> String {
    let (first, second) = &comparison.names;
    let table = |rows: String| {
        format!(
            "<div class=\"scroll\" tabindex=\"0\" role=\"region\" \
             aria-label=\"Measures\"><table><thead><tr><th></th><th \
             scope=\"col\">{}</th><th scope=\"col\">{}</th><th scope=\"col\">difference</th></tr></thead><tbody>{rows}\
             </tbody></table></div>\n",
            escaped(first),
            escaped(second)
        )
    };
    let row = |[name, before, after, difference]: Line, notes: [String; 2]| {
        let note = |note: &str| {
            if note.is_empty() {
                String::new()
            } else {
                format!(" <small>{note}</small>")
            }
        };
        format!(
            "<tr><th scope=\"row\">{name}</th><td>{before}{}</td><td>{after}{}</td><td>{difference}</td></tr>\n",
            note(&notes[0]),
            note(&notes[1])
        )
    };
    let intervals = comparison.measures.iter().map(|(first, second)| {
        let shown = |rate: Rate| match rate.of {
            0 => String::new(),
            _ => interval(rate),
        };
        [shown(first.rate), shown(second.rate)]
    });
    let mut rows: String = shares(comparison)
        .zip(intervals)
        .map(|(line, notes)| row(line, notes))
        .collect();
    rows.extend(costs(comparison).map(|line| row(line, [String::new(), String::new()])));
    let mut body: String = comparison
        .notes
        .iter()
        .map(|note| format!("<p>{}</p>\n", escaped(note)))
        .collect();
    body += &format!("<section>{}</section>\n", table(rows));
    for (heading, [right, wrong], changes) in changes(comparison) {
        let entry = |change: &Change| {
            format!(
                "<li><b>{}</b><p class=\"says\">{}</p><dl><dt>{wrong}</dt><dd>{}</dd><dt>{right}</dt><dd>{}\
                 </dd></dl></li>\n",
                escaped(&change.label),
                escaped(&change.says),
                escaped(&change.why),
                escaped(&change.right)
            )
        };
        let entries: String = changes.iter().map(entry).collect();
        if !entries.is_empty() {
            body += &format!(
                "<section><h2>{heading} ({})</h2><ul class=\"wrong\">\n{entries}</ul></section>\n",
                changes.len()
            );
        }
    }
    if !comparison.settings.is_empty() {
        let row = |(name, before, after): &(&str, String, String)| {
            format!(
                "<tr><th scope=\"row\">{name}</th><td>{}</td><td>{}</td></tr>\n",
                escaped(before),
                escaped(after)
            )
        };
        let rows: String = comparison.settings.iter().map(row).collect();
        body += &format!(
            "<section><h2>Differences in the settings</h2><table class=\"settings\"><tbody>{rows}</tbody></table></section>\n"
        );
    }
    whole(&Page {
        title: comparison.title.clone(),
        about: verdict(comparison),
        body,
    })
}
