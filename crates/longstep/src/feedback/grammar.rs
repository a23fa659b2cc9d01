//! Structured output for feedback: a grammar and a JSON schema of the offered changes.

use indexmap::IndexMap;
use serde_json::{Value, json};

use super::language::{JOINT, everyday};
use super::offer::{Called, Offers};
use crate::dialogue::answer_grammar::{Form, any_text, closed, list, listed, one_of};
use crate::environment::World;

/// Answer for feedback that concerns the goal.
pub(super) const GOAL: &str = "goal";

/// Answer for feedback that asks for something beside the goal.
pub(super) const FURTHER: &str = "further";

/// Maximum number of changes in an answer.
pub(super) const MOST: usize = 4;

/// Returns a grammar in llguidance's Lark dialect for a whole answer about a plan of `length` steps.
pub(super) fn grammar(world: &World, offers: &Offers, length: usize) -> String {
    let mut answers = Vec::new();
    if offers.goal {
        answers.push(Form::text(GOAL));
        answers.push(Form::text(FURTHER));
    }
    let wishes = wishes(world, offers, length);
    if !wishes.is_empty() {
        answers.push(Form::Either(wishes).separated(Form::text(JOINT), MOST));
    }
    answers.push(Form::question());
    Form::Either(answers).grammar()
}

fn wishes(world: &World, offers: &Offers, length: usize) -> Vec<Form> {
    let mut forms = Vec::new();
    let mut by_place: IndexMap<&[usize], Vec<&Called>> = IndexMap::new();
    for (call, places) in &offers.inserts {
        by_place.entry(places).or_default().push(call);
    }
    for (at, inserted) in by_place {
        let (calls, at) = (calls(world, inserted), places(at, length));
        forms.push(Form::Row(vec![Form::text("insert "), calls, Form::text(" "), at]));
    }
    if !offers.drops.is_empty() {
        forms.push(Form::Row(vec![Form::text("drop "), steps(&offers.drops)]));
    }
    let mut by_calls: IndexMap<&[Called], Vec<usize>> = IndexMap::new();
    for (step, others) in &offers.replaces {
        by_calls.entry(others).or_default().push(*step);
    }
    for (others, replaced) in by_calls {
        let (calls, replaced) = (calls(world, others), steps(&replaced));
        forms.push(Form::Row(vec![
            Form::text("replace "),
            replaced,
            Form::text(" with "),
            calls,
        ]));
    }
    for (step, at) in &offers.moves {
        let (step, at) = (steps(&[*step]), places(at, length));
        forms.push(Form::Row(vec![Form::text("move "), step, Form::text(" "), at]));
    }
    forms
}

fn calls<'a>(world: &World, calls: impl IntoIterator<Item = &'a Called>) -> Form {
    let calls = calls.into_iter();
    Form::texts(calls.map(|(action, arguments)| everyday(world, *action, arguments)))
}

fn steps(steps: &[usize]) -> Form {
    Form::texts(steps.iter().map(|step| (step + 1).to_string()))
}

fn places(places: &[usize], length: usize) -> Form {
    Form::texts(places.iter().flat_map(|at| place_texts(*at, length)))
}

/// Returns the notations of a position between steps.
fn place_texts(at: usize, length: usize) -> Vec<String> {
    let after = (at > 0).then(|| format!("after {at}"));
    let before = (at < length).then(|| format!("before {}", at + 1));
    after.into_iter().chain(before).collect()
}

/// Returns a JSON schema for a whole answer: `{"question": "", "goal": false, "further":
/// false, "edits": ["drop 5"]}`.
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
        ("further", json!({"type": "boolean"})),
        ("edits", list(one_of(listed(texts).as_deref()))),
    ])
}
