//! The goal as the instruction was understood, with the words that asked for each part, and the words that it leaves out.

use longstep::report::{Answer, PartAnswer};
use maud::{Markup, html};

/// Writes the instruction with the role of each part, and the goals. `sentences` are the goals for people, in the order
/// of [`Answer::goal`]; the goals themselves take their place where there are none.
pub(super) fn understood(instruction: &str, answer: &Answer, sentences: &[String]) -> Markup {
    let goals = if sentences.len() == answer.goal.len() {
        sentences
    } else {
        &answer.goal
    };
    html! {
        section.understood aria-labelledby="understood" {
            h2 #understood { "Understood as" }
            (marked(instruction, &answer.coverage))
            @if goals.is_empty() { p { "No goal." } }
            ol.goals {
                @for (number, goal) in goals.iter().enumerate() {
                    li id={ "goal-" (number + 1) } {
                        span.sentence { (goal) }
                        @let words = words_of(&answer.coverage, number);
                        @if !words.is_empty() {
                            span.quiet { " because of " @for (place, text) in words.iter().enumerate() { @if place > 0 { ", " } q { (text) } } }
                        }
                    }
                }
            }
            (list("Groups", answer.groups.iter().map(|group| group.says.as_str())))
            (list("Chosen for you", answer.choices.iter().flat_map(|choice| choice.says.iter().map(String::as_str))))
        }
    }
}

/// Returns the words that asked for a goal.
fn words_of(coverage: &[PartAnswer], goal: usize) -> Vec<&str> {
    let parts = coverage.iter().filter(|part| part.goals.contains(&goal));
    parts.map(|part| part.text.as_str()).collect()
}

/// Writes the instruction, with marks for the roles of its parts.
fn marked(instruction: &str, coverage: &[PartAnswer]) -> Markup {
    let whole = instruction.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut place = 0;
    let mut pieces: Vec<(&str, Option<&PartAnswer>)> = Vec::new();
    for part in coverage {
        let end = part.start + part.text.len();
        // Parts that do not fit the text, such as those of an answer to a question, are not shown in it.
        if part.start < place || whole.get(part.start..end) != Some(part.text.as_str()) {
            continue;
        }
        pieces.push((whole.get(place..part.start).unwrap_or_default(), None));
        pieces.push((&part.text, Some(part)));
        place = end;
    }
    pieces.push((whole.get(place..).unwrap_or_default(), None));
    html! {
        blockquote.words {
            @for (text, part) in pieces {
                @match part {
                    None => (text),
                    Some(part) => span.part.(part.role) title=(role(part)) {
                        (text)
                        @for goal in &part.goals { sup { span.unseen { " (goal " } (goal + 1) span.unseen { ")" } } }
                        @if part.role == "not_represented" { span.unseen { " (not in the plan)" } }
                    }
                }
            }
        }
    }
}

fn role(part: &PartAnswer) -> &'static str {
    match part.role {
        "goal" => "asks for a goal",
        "constraint" => "asks for a constraint",
        "not_represented" => "is not in the plan",
        _ => "background",
    }
}

/// Writes what the instruction says and the plan does not do, where nobody misses it.
pub(super) fn left_out(answer: &Answer) -> Markup {
    let gaps = &answer.not_represented;
    let gap_texts: Vec<&str> = gaps.iter().map(|gap| gap.text.as_str()).collect();
    let others = answer.plan.not_in_plan.iter();
    let others: Vec<&String> = others.filter(|text| !gap_texts.contains(&text.as_str())).collect();
    html! {
        @if !gaps.is_empty() || !others.is_empty() {
            section.left-out aria-labelledby="left-out" {
                h2 #left-out { "Not in the plan" }
                p { "The instruction says this, and the plan does not do it:" }
                ul {
                    @for gap in gaps { li { q { (gap.text) } " " span.quiet { (kind(gap.kind)) } } }
                    @for text in others { li { q { (text) } } }
                }
            }
        }
    }
}

/// Describes the kind of a gap.
fn kind(kind: &str) -> &str {
    match kind {
        "prohibition" => "(forbids something)",
        "quantity" => "(a number)",
        "condition" => "(a condition)",
        "order" => "(an order of things)",
        "quotation" => "(a quotation)",
        "name" => "(a name)",
        _ => "",
    }
}

/// Writes a list under a heading, unless it is empty.
pub(super) fn list<'a>(title: &str, entries: impl IntoIterator<Item = &'a str>) -> Markup {
    let entries: Vec<&str> = entries.into_iter().collect();
    html! {
        @if !entries.is_empty() {
            div.list { h3 { (title) } ul { @for entry in entries { li { (entry) } } } }
        }
    }
}
