//! Structured output for feedback: a grammar and a JSON schema of the offered changes.

use indexmap::IndexMap;
use serde_json::{Value, json};

use super::language::{JOINT, everyday};
use super::offer::{Called, Offers};
use crate::dialogue::answer_grammar::{Grammar, any_text, closed, group, list, listed, one_of, quoted};
use crate::environment::World;

/// Answer for feedback that concerns the goal.
pub(super) const GOAL: &str = "goal";

/// Maximum number of changes in an answer.
pub(super) const MOST: usize = 4;

/// Returns a grammar in llguidance's Lark dialect for a whole answer about a plan of `length` steps.
pub(super) fn grammar(world: &World, offers: &Offers, length: usize) -> String {
    let mut grammar = Grammar::default();
    if offers.goal {
        grammar.start(quoted(GOAL));
    }
    let wishes = wishes(world, offers, length);
    if !wishes.is_empty() {
        let mut more = String::new();
        for _ in 1..if offers.several { MOST } else { 1 } {
            more = format!(" ({} wish{more})?", quoted(JOINT));
        }
        grammar.start(format!("wish{more}"));
        grammar.rule("wish", wishes);
    }
    if offers.question || grammar.is_empty() {
        grammar.question();
    }
    grammar.text()
}

fn wishes(world: &World, offers: &Offers, length: usize) -> Vec<String> {
    let mut rules = Vec::new();
    let mut by_place: IndexMap<&[usize], Vec<&Called>> = IndexMap::new();
    for (call, places) in &offers.inserts {
        by_place.entry(places).or_default().push(call);
    }
    for (places, inserted) in by_place {
        let calls = calls_rule(world, inserted);
        rules.push(format!("\"insert \" {calls} \" \" {}", places_rule(places, length)));
    }
    if !offers.drops.is_empty() {
        rules.push(format!("\"drop \" {}", steps_rule(&offers.drops)));
    }
    let mut by_calls: IndexMap<&[Called], Vec<usize>> = IndexMap::new();
    for (step, others) in &offers.replaces {
        by_calls.entry(others).or_default().push(*step);
    }
    for (others, steps) in by_calls {
        let calls = calls_rule(world, others);
        rules.push(format!("\"replace \" {} \" with \" {calls}", steps_rule(&steps)));
    }
    for (step, places) in &offers.moves {
        let step = steps_rule(&[*step]);
        rules.push(format!("\"move \" {step} \" \" {}", places_rule(places, length)));
    }
    rules
}

fn calls_rule<'a>(world: &World, calls: impl IntoIterator<Item = &'a Called>) -> String {
    let calls = calls.into_iter();
    let texts = calls.map(|(action, arguments)| quoted(&everyday(world, *action, arguments)));
    group(&texts.collect::<Vec<_>>())
}

fn steps_rule(steps: &[usize]) -> String {
    let numbers = steps.iter().map(|step| quoted(&(step + 1).to_string()));
    group(&numbers.collect::<Vec<_>>())
}

fn places_rule(places: &[usize], length: usize) -> String {
    let texts = places.iter().flat_map(|at| place_texts(*at, length));
    group(&texts.map(|text| quoted(&text)).collect::<Vec<_>>())
}

/// Returns the notations of a position between steps.
fn place_texts(at: usize, length: usize) -> Vec<String> {
    let after = (at > 0).then(|| format!("after {at}"));
    let before = (at < length).then(|| format!("before {}", at + 1));
    after.into_iter().chain(before).collect()
}

/// Returns a JSON schema for a whole answer: `{"question": "", "goal": false, "edits": ["drop 5"]}`.
///
/// The schema enumerates the offered changes if servers can be expected to accept the list. The parser validates the
/// changes in any case.
pub(super) fn schema(world: &World, offers: &Offers, length: usize) -> Value {
    let call = |(action, arguments): &Called| everyday(world, *action, arguments);
    let mut texts: Vec<String> = Vec::new();
    for (inserted, places) in &offers.inserts {
        let places = places
            .iter()
            .filter_map(|at| place_texts(*at, length).into_iter().next());
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
        let places = places
            .iter()
            .filter_map(|at| place_texts(*at, length).into_iter().next());
        texts.extend(places.map(|place| format!("move {} {place}", step + 1)));
    }
    closed(&[
        ("question", any_text()),
        ("goal", json!({"type": "boolean"})),
        ("edits", list(one_of(listed(texts).as_deref()))),
    ])
}
