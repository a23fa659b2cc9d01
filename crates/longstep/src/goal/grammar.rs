//! The goals on offer as a grammar, and as a JSON schema.

use indexmap::IndexMap;
use serde_json::{Value, json};

use super::depends::Dependence;
use super::{GoalFact, Offer};
use super::{IF, JOINT, NOT, QUESTION, THEN};
use crate::environment::{EntityId, World};
use crate::model::{Domain, FormPiece, GoalWord};
use longstep_core::model::written_fact;

/// Where in an answer a goal stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// At the beginning.
    First {
        /// Whether a question may stand there instead.
        question: bool,
    },
    /// After another goal; the text begins with a blank.
    Next,
}

/// What may be said next in an answer.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ways<'a> {
    /// Goals.
    pub(crate) offers: &'a [Offer],
    /// What a goal may depend on.
    pub(crate) conditions: &'a [Dependence],
    /// The words with which the answer may go on after a goal.
    pub(crate) joints: &'a [&'static str],
    /// Whether it may also end there.
    pub(crate) may_end: bool,
}

/// A grammar in llguidance's Lark dialect for the next goal of an answer.
///
/// After the goal the answer may end, or go on with " &" when `more` is true. When nothing is on offer, only
/// a question is left to say.
pub fn grammar(domain: &Domain, world: &World, offers: &[Offer], place: Place, more: bool) -> String {
    let joints: &[&str] = if more { &[JOINT] } else { &[] };
    let ways = Ways {
        offers,
        joints,
        may_end: true,
        ..Ways::default()
    };
    written(domain, world, &ways, place)
}

/// The same with all that may be said.
pub(crate) fn written(domain: &Domain, world: &World, ways: &Ways<'_>, place: Place) -> String {
    let alternatives: Vec<String> = ways
        .offers
        .iter()
        .map(|offer| word_rule(domain.goal_word(offer.word), world, &offer.arguments))
        .collect();
    let question = format!("question: {} /[A-Za-z][A-Za-z0-9 ,'-]{{8,120}}\\?/\n", quoted(QUESTION));
    if alternatives.is_empty() {
        return format!("start: question\n{question}");
    }
    let goal = if ways.conditions.is_empty() {
        "goal more"
    } else {
        "goal more | condition"
    };
    let mut text = match place {
        Place::First { question: true } => format!("start: question | {goal}\n"),
        Place::First { question: false } => format!("start: {goal}\n"),
        Place::Next if ways.conditions.is_empty() => format!("start: \" \" {goal}\n"),
        Place::Next => format!("start: \" \" ({goal})\n"),
    };
    if place == (Place::First { question: true }) {
        text.push_str(&question);
    }
    let optional = if ways.may_end { "?" } else { "" };
    text.push_str(&match ways.joints {
        [] => "more: \"\"\n".to_owned(),
        [joint] => format!("more: {}{optional}\n", quoted(joint)),
        joints => {
            let joints: Vec<String> = joints.iter().map(|joint| quoted(joint)).collect();
            format!("more: ({}){optional}\n", joints.join(" | "))
        }
    });
    if !ways.conditions.is_empty() {
        text.push_str(&condition_rule(domain, world, ways.conditions));
    }
    text.push_str(&format!("goal: {}\n", alternatives.join("\n  | ")));
    text
}

/// The rule for the beginning of a goal that depends on something, up to "then".
fn condition_rule(domain: &Domain, world: &World, conditions: &[Dependence]) -> String {
    let name = |entity: EntityId| world.entity(entity).name.clone();
    let beginning = |depends: &Dependence| {
        let not = if depends.negated { NOT } else { "" };
        quoted(&format!("{IF}{not}{}{THEN}", written_fact(domain, depends.fact, &name)))
    };
    let alternatives: Vec<String> = conditions.iter().map(beginning).collect();
    format!("condition: {}\n", alternatives.join("\n  | "))
}

fn word_rule(word: &GoalWord, world: &World, arguments: &[Vec<EntityId>]) -> String {
    let mut parts = Vec::new();
    rule_from(&word.form, world, arguments, &mut parts);
    parts.join(" ")
}

/// The rule for the rest of a form, given the arguments that are possible from here on.
fn rule_from(form: &[FormPiece], world: &World, arguments: &[Vec<EntityId>], parts: &mut Vec<String>) {
    let Some((piece, rest)) = form.split_first() else {
        return;
    };
    let index = match piece {
        FormPiece::Text(text) => {
            if !text.is_empty() {
                parts.push(quoted(text));
            }
            return rule_from(rest, world, arguments, parts);
        }
        FormPiece::Parameter(index) => *index,
    };
    // Entities with the same possible continuations share one rule for them.
    let mut continuations: IndexMap<EntityId, Vec<Vec<EntityId>>> = IndexMap::new();
    for bindings in arguments {
        let mut others = bindings.clone();
        others[index] = EntityId::new(0);
        continuations.entry(bindings[index]).or_default().push(others);
    }
    let mut groups: IndexMap<Vec<Vec<EntityId>>, Vec<EntityId>> = IndexMap::new();
    for (entity, others) in continuations {
        groups.entry(others).or_default().push(entity);
    }
    let alternatives: Vec<String> = groups
        .into_iter()
        .map(|(others, entities)| {
            let names: Vec<String> = entities
                .iter()
                .map(|entity| quoted(&world.entity(*entity).name))
                .collect();
            let mut parts = vec![format!("({})", names.join(" | "))];
            rule_from(rest, world, &others, &mut parts);
            parts.join(" ")
        })
        .collect();
    parts.push(format!("({})", alternatives.join(" | ")));
}

/// A string of the grammar; JSON's escapes are the dialect's own.
pub(crate) fn quoted(text: &str) -> String {
    Value::String(text.to_owned()).to_string()
}

/// What servers accept in one enumeration.
const ENUM_LIMIT: usize = 500;
/// And how long all of it may be, in bytes.
const ENUM_BYTES: usize = 12_000;

/// A JSON schema for a whole answer: `{"question": "", "goals": ["put(pie, oven)"]}`.
///
/// The goals on offer are listed when servers can be expected to take the list; otherwise any text is
/// allowed, and reading the answer finds what is not a goal.
pub fn schema(domain: &Domain, world: &World, offers: &[Offer]) -> Value {
    schema_of(domain, world, offers, false)
}

/// The same; where goals may depend on something, any text is allowed.
pub(crate) fn schema_of(domain: &Domain, world: &World, offers: &[Offer], depends: bool) -> Value {
    let texts: Vec<String> = offers
        .iter()
        .flat_map(|offer| offer.arguments.iter().map(|arguments| (offer.word, arguments.clone())))
        .map(|(word, arguments)| GoalFact::Word { word, arguments }.everyday(domain, world))
        .collect();
    let listed = !depends
        && !texts.is_empty()
        && texts.len() <= ENUM_LIMIT
        && texts.iter().map(String::len).sum::<usize>() <= ENUM_BYTES;
    let goal = if listed {
        json!({"type": "string", "enum": texts})
    } else {
        json!({"type": "string"})
    };
    json!({
        "type": "object",
        "properties": {
            "question": {"type": "string"},
            "goals": {"type": "array", "items": goal},
        },
        "required": ["question", "goals"],
        "additionalProperties": false,
    })
}
