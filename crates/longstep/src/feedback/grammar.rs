//! Structured output for feedback: a grammar and a JSON schema of the offered changes.

use indexmap::IndexMap;
use serde_json::{Value, json};

use super::language::{JOINT, everyday};
use super::offer::{Called, Offers};
use crate::environment::World;
use crate::goal::{QUESTION, quoted};
use crate::model::Domain;

/// Answer for feedback that concerns the goal.
pub(super) const GOAL: &str = "goal";

/// Maximum number of changes in an answer.
pub(super) const MOST: usize = 4;

/// Limits of enumerations that servers accept: number of values, and total length in bytes.
const ENUM_LIMIT: usize = 500;
const ENUM_BYTES: usize = 12_000;

/// Returns a grammar in llguidance's Lark dialect for a whole answer about a plan of `length` steps.
pub(super) fn grammar(domain: &Domain, world: &World, offers: &Offers, length: usize) -> String {
    let mut starts = Vec::new();
    let mut rules = String::new();
    if offers.goal {
        starts.push(quoted(GOAL));
    }
    let wishes = wishes(domain, world, offers, length);
    if !wishes.is_empty() {
        let mut more = String::new();
        for _ in 1..if offers.several { MOST } else { 1 } {
            more = format!(" ({} wish{more})?", quoted(JOINT));
        }
        starts.push(format!("wish{more}"));
        rules.push_str(&format!("wish: {}\n", wishes.join("\n  | ")));
    }
    if offers.question || starts.is_empty() {
        starts.push("question".to_owned());
        rules.push_str(&format!(
            "question: {} /[A-Za-z][A-Za-z0-9 ,'-]{{8,120}}\\?/\n",
            quoted(QUESTION)
        ));
    }
    format!("start: {}\n{rules}", starts.join(" | "))
}

fn wishes(domain: &Domain, world: &World, offers: &Offers, length: usize) -> Vec<String> {
    let any = |texts: Vec<String>| match &texts[..] {
        [one] => one.clone(),
        _ => format!("({})", texts.join(" | ")),
    };
    let number = |step: &usize| quoted(&(step + 1).to_string());
    let calls = |calls: &[&Called]| {
        any(calls
            .iter()
            .map(|(a, args)| quoted(&everyday(domain, world, *a, args)))
            .collect())
    };
    let place = |places: &[usize]| {
        any(places
            .iter()
            .flat_map(|at| told(*at, length))
            .map(|at| quoted(&at))
            .collect())
    };
    let mut rules = Vec::new();
    let mut by_place: IndexMap<&[usize], Vec<&Called>> = IndexMap::new();
    for (call, places) in &offers.inserts {
        by_place.entry(places).or_default().push(call);
    }
    for (places, inserted) in by_place {
        rules.push(format!("\"insert \" {} \" \" {}", calls(&inserted), place(places)));
    }
    if !offers.drops.is_empty() {
        rules.push(format!("\"drop \" {}", any(offers.drops.iter().map(number).collect())));
    }
    let mut by_calls: IndexMap<&[Called], Vec<usize>> = IndexMap::new();
    for (step, others) in &offers.replaces {
        by_calls.entry(others).or_default().push(*step);
    }
    for (others, steps) in by_calls {
        let others: Vec<&Called> = others.iter().collect();
        let steps = any(steps.iter().map(number).collect());
        rules.push(format!("\"replace \" {steps} \" with \" {}", calls(&others)));
    }
    for (step, places) in &offers.moves {
        rules.push(format!("\"move \" {} \" \" {}", number(step), place(places)));
    }
    rules
}

/// Returns the notations of a position between steps.
fn told(at: usize, length: usize) -> Vec<String> {
    let after = (at > 0).then(|| format!("after {at}"));
    let before = (at < length).then(|| format!("before {}", at + 1));
    after.into_iter().chain(before).collect()
}

/// Returns a JSON schema for a whole answer: `{"question": "", "goal": false, "edits": ["drop 5"]}`.
///
/// The schema enumerates the offered changes if servers can be expected to accept the list. The parser validates the
/// changes in any case.
pub(super) fn schema(domain: &Domain, world: &World, offers: &Offers, length: usize) -> Value {
    let call = |(action, arguments): &Called| everyday(domain, world, *action, arguments);
    let mut texts: Vec<String> = Vec::new();
    for (inserted, places) in &offers.inserts {
        let places = places.iter().filter_map(|at| told(*at, length).into_iter().next());
        texts.extend(places.map(|place| format!("insert {} {place}", call(inserted))));
    }
    texts.extend(offers.drops.iter().map(|step| format!("drop {}", step + 1)));
    for (step, others) in &offers.replaces {
        texts.extend(
            others
                .iter()
                .map(|other| format!("replace {} with {}", step + 1, call(other))),
        );
    }
    for (step, places) in &offers.moves {
        let places = places.iter().filter_map(|at| told(*at, length).into_iter().next());
        texts.extend(places.map(|place| format!("move {} {place}", step + 1)));
    }
    let bytes: usize = texts.iter().map(String::len).sum();
    let edit = if texts.is_empty() || texts.len() > ENUM_LIMIT || bytes > ENUM_BYTES {
        json!({"type": "string"})
    } else {
        json!({"type": "string", "enum": texts})
    };
    json!({
        "type": "object",
        "properties": {
            "question": {"type": "string"},
            "goal": {"type": "boolean"},
            "edits": {"type": "array", "items": edit},
        },
        "required": ["question", "goal", "edits"],
        "additionalProperties": false,
    })
}
