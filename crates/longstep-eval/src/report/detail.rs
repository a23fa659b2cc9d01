//! One attempt in detail.

use super::label;
use super::mark::Mark;
use super::markup::escaped;
use super::words::{amount, duration, expected, several};
use crate::attempt::{Attempt, Edit, PlanLine, Timing};
use crate::folder::Results;
use longstep::dialogue::Reading;

/// The id of an attempt on the page.
pub(super) fn id(place: usize) -> String {
    format!("attempt-{place}")
}

/// A small square that links to an attempt.
pub(super) fn square(results: &Results, place: usize, attempt: &Attempt) -> String {
    let mark = Mark::of(attempt);
    let name = escaped(&format!("{}: {}", label(results, attempt), mark.name()));
    format!(
        "<a class=\"square {}\" href=\"#{}\" title=\"{name}\" aria-label=\"{name}\">{}</a>",
        mark.class(),
        id(place),
        mark.sign()
    )
}

/// A link to an attempt.
pub(super) fn link(results: &Results, place: usize, attempt: &Attempt) -> String {
    format!("<a href=\"#{}\">{}</a>", id(place), escaped(&label(results, attempt)))
}

/// The details of an attempt.
pub(super) fn article(results: &Results, place: usize, attempt: &Attempt) -> String {
    let mark = Mark::of(attempt);
    let mut parts = vec![format!(
        "<h3><span class=\"square {}\" aria-hidden=\"true\">{}</span> {}</h3><p class=\"says\">{}</p>",
        mark.class(),
        mark.sign(),
        escaped(&label(results, attempt)),
        escaped(&attempt.says)
    )];
    parts.push(facts(attempt, results.timings.get(&attempt.key)));
    parts.push(list(
        "Reasons why it is not correct",
        attempt.why.iter().map(|why| escaped(why)),
    ));
    parts.push(list(
        "Violations of the plan",
        attempt.violations.iter().map(|one| escaped(one)),
    ));
    parts.push(plan(&attempt.plan));
    parts.push(list("Edits by repair", attempt.edits.iter().map(edit)));
    parts.push(readings(attempt));
    parts.push(dialogue(attempt));
    format!(
        "<article class=\"attempt\" id=\"{}\">{}<p class=\"back\"><a href=\"#grid\">Back to the \
         grid</a></p></article>\n",
        id(place),
        parts.concat()
    )
}

fn facts(attempt: &Attempt, timing: Option<&Timing>) -> String {
    let mut facts = vec![
        ("Expected", expected(&attempt.expected)),
        ("Understood", attempt.understood.join(" & ")),
        ("Asked", attempt.question.clone()),
        ("Outcome", outcome(attempt)),
    ];
    let failures: Vec<&str> = attempt.failures.iter().map(|kind| kind.name()).collect();
    facts.push(("Failures", failures.join(", ")));
    facts.push(("Scene", attempt.scene.clone()));
    facts.push(("Tags", attempt.tags.join(", ")));
    let timing_of = |show: fn(&Timing) -> String| timing.map_or_else(String::new, show);
    let cost = format!(
        "{}, {}; {} tokens in prompts{}, {} in answers{}",
        several(u64::from(attempt.calls), "call"),
        several(u64::from(attempt.rounds), "round"),
        amount(attempt.prompt_tokens),
        timing_of(|timing| format!(" ({} of them cached)", amount(timing.cached_tokens))),
        amount(attempt.completion_tokens),
        timing_of(|timing| {
            let (total, model) = (duration(timing.total_ms), duration(timing.model_ms));
            format!("; {total}, of which the model {model}")
        })
    );
    facts.push(("Cost", cost));
    let shown = facts.into_iter().filter(|(_, value)| !value.is_empty());
    let shown: String = shown
        .map(|(name, value)| format!("<dt>{name}</dt><dd>{}</dd>", escaped(&value)))
        .collect();
    format!("<dl>{shown}</dl>")
}

fn outcome(attempt: &Attempt) -> String {
    let mut words = attempt.outcome.name().replace('_', " ");
    words += match (attempt.correct, attempt.executable) {
        (true, _) => ", correct",
        (false, true) => ", executable, not correct",
        (false, false) => ", not correct",
    };
    if let Some(right) = attempt.claim_right {
        words += if right {
            "; the claimed environment is the simulated one"
        } else {
            "; the claimed environment is not the simulated one"
        };
    }
    words
}

/// A list of markup under a heading; empty without items.
fn list(heading: &str, items: impl Iterator<Item = String>) -> String {
    let items: String = items.map(|item| format!("<li>{item}</li>")).collect();
    if items.is_empty() {
        items
    } else {
        format!("<h4>{heading}</h4><ul>{items}</ul>")
    }
}

fn plan(lines: &[PlanLine]) -> String {
    let line = |line: &PlanLine| {
        let number = line.step.map_or_else(String::new, |step| (step + 1).to_string());
        let changes: Vec<String> = line.changes.iter().map(|change| escaped(change)).collect();
        format!(
            "<tr><td class=\"number\">{number}</td><td><code style=\"margin-left:{}rem\">{}</code><br><span \
             class=\"quiet\">{}</span></td><td>{}</td></tr>",
            line.depth,
            escaped(&line.text),
            escaped(&line.explanation),
            changes.join("<br>")
        )
    };
    let rows: String = lines.iter().map(line).collect();
    if rows.is_empty() {
        rows
    } else {
        format!(
            "<h4>Plan</h4><div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Plan\"><table \
         class=\"plan\"><thead><tr><th></th><th>Step</th><th>What becomes so</th></tr></thead><tbody>{rows}</tbody>\
         </table></div>"
        )
    }
}

fn edit(edit: &Edit) -> String {
    let call = |call: &Option<String>| format!("<code>{}</code>", escaped(call.as_deref().unwrap_or_default()));
    let (before, after) = (call(&edit.before), call(&edit.after));
    let what = match (&edit.before, &edit.after) {
        (Some(_), Some(_)) if edit.before == edit.after => format!("{before} moved"),
        (Some(_), Some(_)) => format!("{after} instead of {before}"),
        (Some(_), None) => format!("{before} dropped"),
        (None, _) => format!("{after} inserted"),
    };
    format!(
        "Line {}: {what}<br><span class=\"quiet\">{}</span>",
        edit.at + 1,
        escaped(&edit.why)
    )
}

/// The answers of the model that were weighed.
fn readings(attempt: &Attempt) -> String {
    let lines: Vec<String> = attempt.readings.iter().flat_map(Reading::lines).collect();
    if lines.is_empty() {
        String::new()
    } else {
        format!(
            "<h4>How it was understood</h4><pre>{}</pre>",
            escaped(&lines.join("\n"))
        )
    }
}

/// The model's replies and the feedback, alternating.
fn dialogue(attempt: &Attempt) -> String {
    let mut parts = Vec::new();
    for place in 0..attempt.replies.len().max(attempt.corrections.len()) {
        let number = match attempt.replies.len() {
            1 => String::new(),
            _ => format!(" {}", place + 1),
        };
        if let Some(reply) = attempt.replies.get(place) {
            parts.push(format!("<h4>Reply{number}</h4><pre>{}</pre>", escaped(reply)));
        }
        if let Some(correction) = attempt.corrections.get(place) {
            parts.push(format!(
                "<h4>What it was told{number}</h4><pre class=\"told\">{}</pre>",
                escaped(correction)
            ));
        }
    }
    parts.concat()
}
