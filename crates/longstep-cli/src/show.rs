//! Answers as text for the terminal.

use longstep::report::{self, Answer, Status};
use longstep_core::diagnostic::Diagnostic;
use longstep_core::domain::phrase;
use longstep_core::environment::Environment;
use longstep_core::plan::OutlineLine;
use longstep_core::visible;

use crate::output::{self, Line, Style, print_line};

/// The columns below which a terminal is narrow.
const NARROW: usize = 80;

/// Prints a heading.
pub(crate) fn heading(text: &str) {
    print_line!("{}", text.bold());
}

/// Selects whether an answer includes the changes of the world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Changes {
    Shown,
    Hidden,
}

/// Lines in place of the list of steps, with what they say already.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Body<'a> {
    /// The lines; none for the list of steps.
    pub(crate) lines: &'a [Line],
    /// The assumptions in them.
    pub(crate) assumed: &'a [String],
    /// True if they have the violations.
    pub(crate) has_violations: bool,
    /// The assumptions that the plan's file states.
    pub(crate) stated: &'a [String],
}

/// Prints an answer: the steps, the changes, the assumptions and the verdict.
pub(crate) fn answer(answer: &Answer, shown: Changes) {
    answer_with(answer, shown, Body::default());
}

/// Prints an answer with these lines in place of the list of steps.
pub(crate) fn answer_with(answer: &Answer, shown: Changes, body: Body<'_>) {
    if answer.status == Status::Question {
        not_represented(answer);
        print_line!("{} {}", "Question:".yellow().bold(), answer.plan.question);
        return;
    }
    let bad = |index| answer.violations.iter().any(|violation| violation.step == Some(index));
    match body.lines {
        [] => steps(&answer.outline, bad),
        lines => lines.iter().for_each(|line| print_line!("{line}")),
    }
    edits(answer);
    // The changes of a plan that is not executable are unknown.
    let possible = answer.status == Status::Verified && shown == Changes::Shown;
    if let (true, Some(before)) = (possible, &answer.plan.environment_before) {
        if let Some(after) = answer.plan.environment_after.as_ref().filter(|after| *after != before) {
            output::blank();
            heading("Changes");
            changes(before, after);
        }
        let endings = &answer.plan.endings;
        for (number, ending) in endings.iter().enumerate() {
            // Endings may differ in nothing that an environment shows: in what a step found before it changed it.
            if endings[..number].contains(ending) {
                continue;
            }
            output::blank();
            heading(&if ending.when.is_empty() {
                "Changes in every other case".to_owned()
            } else {
                format!("Changes when {}", ending.when.join(" and "))
            });
            if ending.environment_after == *before {
                print_line!("  {}", "none".dimmed())
            } else {
                changes(before, &ending.environment_after)
            }
        }
    }
    let groups: Vec<String> = answer.groups.iter().map(|group| group.says.clone()).collect();
    list("Groups", &groups);
    let chosen: Vec<String> = answer.choices.iter().flat_map(|choice| choice.says.clone()).collect();
    list("Chosen", &chosen);
    not_represented(answer);
    list("Assumptions", &without(&answer.assumptions, body.assumed));
    let stated = without(body.stated, body.assumed);
    list("Assumptions of the file", &without(&stated, &answer.assumptions));
    let differing: Vec<String> = answer
        .claims
        .differing
        .iter()
        .map(|d| {
            format!(
                "{}: claimed {}, simulated {}",
                d.entity,
                nothing(&d.claimed),
                nothing(&d.simulated)
            )
        })
        .collect();
    list("Claims that differ from the simulation", &differing);
    list("Notes", &answer.notes);
    let violations: Vec<String> = answer
        .violations
        .iter()
        .map(|violation| violation.message.clone())
        .collect();
    list("Violations", if body.has_violations { &[] } else { &violations });
    output::blank();
    verdict(answer);
}

/// Returns the texts of one list that another one does not have.
fn without(texts: &[String], others: &[String]) -> Vec<String> {
    texts.iter().filter(|text| !others.contains(text)).cloned().collect()
}

/// Prints the parts of the instruction that the plan ignores.
fn not_represented(answer: &Answer) {
    let gaps = answer.not_represented.iter();
    let gaps: Vec<String> = gaps.map(|gap| format!("\"{}\" ({})", gap.text, gap.kind)).collect();
    list("Not in the plan", &gaps);
    if !gaps.is_empty() && answer.status == Status::Question {
        output::blank();
    }
}

/// Prints the differences between two environments.
pub(crate) fn changes(before: &Environment, after: &Environment) {
    let changed = report::changes(before, after);
    let width = changed
        .iter()
        .map(|(identifier, ..)| visible::line(identifier).chars().count())
        .max();
    let width = width.unwrap_or(0);
    for (identifier, was, is) in changed {
        let or_nothing = |text: String| if text.is_empty() { "(no state)".to_owned() } else { text };
        let identifier = visible::line(&identifier);
        print_line!(
            "  {identifier:width$}  {} {} {}",
            or_nothing(was).dimmed(),
            "->".dimmed(),
            or_nothing(is)
        );
    }
}

/// Prints a finding and its hint on lines of their own; `kind` is the coloured word before it.
pub(crate) fn finding(kind: impl std::fmt::Display, finding: &Diagnostic) {
    let mut finding = finding.clone();
    let own_hint = finding.hint.take();
    print_line!("{kind} {finding}");
    if let Some(own_hint) = own_hint {
        hint(&own_hint);
    }
}

/// Prints a hint.
pub(crate) fn hint(text: &str) {
    print_line!("{} {text}", "hint:".cyan().bold());
}

fn edits(answer: &Answer) {
    if answer.edits.is_empty() {
        return;
    }
    output::blank();
    heading("Edits");
    for edit in &answer.edits {
        let number = edit.at + 1;
        let (before, after) = (
            edit.before.as_deref().unwrap_or(""),
            edit.after.as_deref().unwrap_or(""),
        );
        // For a call with hidden arguments, only the explanation names the objects.
        let step = answer
            .steps
            .get(edit.at)
            .filter(|step| edit.kind != "drop" && !step.implicit.is_empty());
        let about = step.map_or(String::new(), |step| format!(", {}", phrase(&step.explanation)));
        match edit.kind {
            "drop" => print_line!("  {} {before}", "-".red()),
            "replace" => print_line!("  {} {number}. {after} instead of {before}{about}", "~".yellow()),
            "move" => print_line!("  {} {number}. {after}{about}, moved to a later place", "~".yellow()),
            _ => print_line!("  {} {number}. {after}{about}", "+".green()),
        }
        print_line!("    {}", edit.why.dimmed());
    }
}

pub(crate) fn nothing(text: &str) -> &str {
    if text.is_empty() { "nothing" } else { text }
}

/// Prints the steps of a plan with their explanations; those for which `bad` is true in red. Steps in a branch, a loop
/// or a lane are indented.
pub(crate) fn steps(lines: &[OutlineLine], bad: impl Fn(usize) -> bool) {
    let length = |line: &OutlineLine| 2 * line.depth + visible::line(&line.text).chars().count();
    let explained = lines.iter().filter(|line| !line.explanation.is_empty());
    let width = explained.map(length).max().unwrap_or(0);
    let steps = lines
        .iter()
        .filter_map(|line| line.step)
        .max()
        .map_or(0, |last| last + 1);
    let digits = steps.to_string().len();
    let explanations = lines
        .iter()
        .map(|line| visible::line(&line.explanation).chars().count());
    let longest = digits + 6 + width + explanations.max().unwrap_or(0);
    let is_narrow = output::columns().is_some_and(|columns| columns < NARROW && longest > columns);
    for line in lines {
        let number = match line.step {
            Some(step) => format!("{:>digits$}.", step + 1),
            None => " ".repeat(digits + 1),
        };
        let indent = "  ".repeat(line.depth);
        let padding = " ".repeat(width.saturating_sub(length(line)));
        let (text, explanation) = (&line.text, line.explanation.dimmed());
        if is_narrow {
            // In a narrow terminal a step has its explanation below it.
            match line.step {
                Some(step) if bad(step) => print_line!("  {} {indent}{}", number.red(), text.red()),
                Some(_) => print_line!("  {} {indent}{text}", number.dimmed()),
                None => print_line!("  {number} {indent}{}", text.dimmed()),
            }
            if !line.explanation.is_empty() {
                print_line!("  {:1$} {indent}{explanation}", "", digits + 1);
            }
            continue;
        }
        match line.step {
            Some(step) if bad(step) => {
                print_line!("  {} {indent}{}{padding}  {explanation}", number.red(), text.red());
            }
            Some(_) => print_line!("  {} {indent}{text}{padding}  {explanation}", number.dimmed()),
            None => print_line!("  {number} {indent}{}", text.dimmed()),
        }
    }
}

/// Prints a list under a heading, unless it is empty.
pub(crate) fn list(title: &str, entries: &[String]) {
    if entries.is_empty() {
        return;
    }
    output::blank();
    print_line!("{}", title.bold());
    for entry in entries {
        print_line!("  - {entry}");
    }
}

fn verdict(answer: &Answer) {
    let count = match answer.steps.len() {
        0 => "nothing to do".to_owned(),
        1 => "1 step".to_owned(),
        many => format!("{many} steps"),
    };
    let times = &answer.timings_ms;
    let mut parts = Vec::new();
    if times.model > 0.0 {
        parts.push(format!("model {:.1} s", times.model / 1000.0));
    }
    if times.search > 0.0 {
        parts.push(format!("search {}", milliseconds(times.search)));
    }
    parts.push(format!("verification {}", milliseconds(times.verify)));
    let time = parts.join(", ");
    // `solve` has a goal, `repair` has a plan instead.
    let repaired = answer.goal.is_empty();
    match answer.status {
        Status::Verified => {
            let changed = match answer.edits.len() {
                0 => String::new(),
                1 => ", 1 edit".to_owned(),
                many => format!(", {many} edits"),
            };
            print_line!("{} {count}{changed} ({time})", "Verified:".green().bold());
        }
        Status::Invalid => {
            let found = answer.violations.len();
            let found = if found == 1 {
                "1 violation".to_owned()
            } else {
                format!("{found} violations")
            };
            print_line!("{} {found} ({time})", "Not valid:".red().bold());
        }
        Status::Unsolvable => {
            let reason = if repaired {
                "no edits make this plan valid"
            } else {
                "no plan reaches this goal"
            };
            print_line!("{} {reason} ({time})", "Unsolvable:".red().bold());
        }
        Status::GaveUp => {
            let reason = if repaired { "no repair" } else { "no plan" };
            print_line!(
                "{} {reason} found within the limits ({time})",
                "Gave up:".yellow().bold()
            );
        }
        Status::Question => {}
    }
}

fn milliseconds(value: f64) -> String {
    if value < 1.0 {
        format!("{value:.2} ms")
    } else {
        format!("{value:.1} ms")
    }
}

/// Prints an answer as one JSON object.
pub(crate) fn json(answer: &Answer) -> anyhow::Result<()> {
    output::json(answer)
}
