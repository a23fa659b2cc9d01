//! The messages of a request: the same for every model.

use std::collections::BTreeSet;

use serde_json::json;

use super::sayable::{fact_word, other_predicates};
use super::{Examples, answer};
use crate::coverage::Gap;
use crate::dialogue::{
    ConstraintKind, Message, Role, Round, fixed_turns, object, plain_line, scene, scene_and_instruction,
};
use crate::environment::World;
use crate::goal::QUESTION;
use crate::model::{Domain, Parameter, PredicateId};

/// The form of its answer, for a server, behind the system text. An embedded model has learned it.
const JSON_FORM: &str = "\n\nWrite the answer as a JSON object with three keys: \"goal\", the whole goal as a text in this language, \
    empty if you ask; \"left_out\", the words that the goal does not say, each with its \"text\", copied from the instruction, \
    and its \"kind\"; and \"question\", which is empty unless you have to ask.\n\n\
    Of the kinds, time is a moment or a deadline (at noon, by tomorrow); amount is a definite quantity, number of times or duration \
    (two litres, twice, for ten minutes); manner is how something is done, or how much in vague words (quickly, a bit); condition is a \
    case that cannot be a CONDITION here; message is what somebody is to be told where no goal has a text; wish is something further \
    that no goal says. Courtesy, remarks, the names of people who are spoken to, and where a thing is now are not left out. A text in a \
    goal stands in double quotes, in the words of the person.";

/// Returns the fixed messages, then the scene with the instruction, then the later rounds; and the number of the fixed ones.
pub(super) fn messages(
    domain: &Domain,
    world: &World,
    instruction: &str,
    rounds: &[Round],
    kind: ConstraintKind,
    examples: Examples,
) -> (Vec<Message>, usize) {
    let mut messages = fixed_turns(domain);
    messages[0].text.push_str(&language(domain));
    if examples == Examples::Few {
        messages = few(&messages);
    }
    if kind == ConstraintKind::JsonSchema {
        messages[0].text.push_str(JSON_FORM);
        messages[0].text.push_str(&numbers(domain));
        for answer in messages.iter_mut().skip(2).step_by(2) {
            answer.text = in_form(&answer.text, kind);
        }
    }
    let fixed = messages.len();
    let scene = scene(world);
    // The scene has everyday names alone.
    let said = |words: &str| plain_line(&world.with_everyday_names(words));
    messages.push(Message::new(
        Role::User,
        scene_and_instruction(&scene, &said(instruction)),
    ));
    for round in rounds {
        messages.push(Message::new(Role::Assistant, in_form(&round.reply, kind)));
        messages.push(Message::new(Role::User, said(&round.message)));
    }
    (messages, fixed)
}

/// Leaves out examples beyond [`Examples::FEW`], first those whose answers show no form of a goal that none before them shows.
fn few(messages: &[Message]) -> Vec<Message> {
    let mut shown = BTreeSet::new();
    let mut is_new = |index: &usize| {
        let known = shown.len();
        shown.extend(words(&messages[2 * index + 2].text));
        shown.len() > known
    };
    let (mut kept, rest): (Vec<usize>, Vec<usize>) = (0..messages.len() / 2).partition(&mut is_new);
    kept.extend(rest);
    kept.truncate(Examples::FEW);
    kept.sort_unstable();
    let places = kept.iter().flat_map(|index| [2 * index + 1, 2 * index + 2]);
    std::iter::once(0)
        .chain(places)
        .filter_map(|place| messages.get(place).cloned())
        .collect()
}

/// Returns the calls in an answer by their word and the number of commas, so that `put(X, Y)` and `put(X, Y, HAND)` are two; of a question,
/// that it is one.
fn words(answer: &str) -> Vec<(&str, usize)> {
    if answer.starts_with(QUESTION) {
        return vec![(QUESTION, 0)];
    }
    let (mut all, mut open) = (Vec::new(), Vec::new());
    for (at, letter) in answer.char_indices() {
        match letter {
            '(' => {
                let before = &answer[..at];
                let word = before.rsplit(|own: char| !own.is_alphanumeric() && own != '_').next();
                open.push((word.unwrap_or_default(), 0));
            }
            ',' => open.last_mut().into_iter().for_each(|(_, commas)| *commas += 1),
            ')' => all.extend(open.pop()),
            _ => {}
        }
    }
    all
}

/// Converts an answer to the form for this kind of model.
fn in_form(answer: &str, kind: ConstraintKind) -> String {
    if kind == ConstraintKind::Grammar || object::<serde_json::Value>(answer).is_ok() {
        return answer.to_owned();
    }
    let (goal, question) = match answer.strip_prefix(QUESTION) {
        Some(question) => ("", question),
        None => (answer, ""),
    };
    let (goal, left_out) = answer::split(goal);
    let left_out: Vec<_> = left_out
        .iter()
        .map(|own| json!({"text": own.text, "kind": own.kind.name()}))
        .collect();
    json!({"goal": goal, "left_out": left_out, "question": question}).to_string()
}

/// Returns the goal language beyond plain goals, at the end of the system text. The adapter has learned these bytes.
fn language(domain: &Domain) -> String {
    let mut text = String::from(
        "\n\nBeyond plain goals:\n\
        - A then B: first A, then B\n\
        - never GOAL: this must not come about on the way; always GOAL: this holds and must go on holding; untouched(THING): leave it alone; _ in it is anything\n",
    );
    let states = other_states(domain);
    if !states.is_empty() {
        text.push_str(&format!("- behind never and always also: {}\n", states.join(", ")));
    }
    text.push_str(
        "- never GOAL until GOAL: only until then\n\
        - instead of a name: all KIND, all KIND where STATE or STATE, all KIND except NAME, any KIND, any of (NAME, NAME), 2 of KIND, all but 1 of KIND\n\
        - instead of an amount: now + 2, now * 2\n\
        - if CONDITION then GOAL else GOAL",
    );
    let conditions = conditions(domain);
    let listed = |form: &String| domain.prompts.goal.contains(form);
    if !conditions.is_empty() && !conditions.iter().all(listed) {
        text.push_str(&format!("; a CONDITION is one of: {}", conditions.join(", ")));
    }
    text.push_str("\n- left out KIND: the words that none of these can say, at the end, and their KIND: ");
    text.push_str(&Gap::ALL.map(Gap::name).join(", "));
    text
}

/// Returns how the numbers of the domain are asked for.
fn numbers(domain: &Domain) -> String {
    let changing = domain.functions.iter().filter(|function| function.changes);
    let forms: Vec<String> = changing
        .map(|function| {
            let unit = function.unit.as_ref().map_or(String::new(), |unit| format!(" {unit}"));
            format!("{} >= 3{unit}", form_of(&function.word, &function.parameters))
        })
        .collect();
    if forms.is_empty() {
        String::new()
    } else {
        format!("\n\nNumbers are compared with <, <=, =, >= or >: {}", forms.join(", "))
    }
}

/// Returns the forms of what can be sensed.
fn conditions(domain: &Domain) -> Vec<String> {
    let sensed = domain
        .states
        .iter()
        .filter(|word| domain.is_sensed(word.atom.predicate));
    sensed.map(|word| format!("{}(THING)", word.word)).collect()
}

/// Returns the forms of the facts that no goal word is about.
fn other_states(domain: &Domain) -> Vec<String> {
    let form = |id: PredicateId| form_of(&fact_word(domain, id), &domain.predicate(id).parameters);
    other_predicates(domain).into_iter().map(form).collect()
}

/// Returns a word with its parameters, as a person would fill them in: `level(TANK)`.
fn form_of(word: &str, parameters: &[Parameter]) -> String {
    let names: Vec<String> = parameters.iter().map(|own| own.name.to_uppercase()).collect();
    format!("{word}({})", names.join(", "))
}
