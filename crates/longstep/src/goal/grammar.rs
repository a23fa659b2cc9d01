//! Structured output for goals: a grammar and a JSON schema of the offered goals.

use indexmap::IndexMap;
use serde_json::{Value, json};

use super::depends::Dependence;
use super::{GoalFact, Offer};
use super::{IF, JOINT, NOT, QUESTION, THEN};
use crate::environment::{EntityId, World};
use crate::model::{FormPiece, GoalWord};
use longstep_core::model::Domain;
use longstep_core::model::written_fact;

/// Position of a goal in an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The first goal.
    First {
        /// True if a question may replace the goal.
        question: bool,
    },
    /// A goal after another one; the text begins with a space.
    Next,
}

/// Possible continuations of an answer.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ways<'a> {
    /// Goals.
    pub(crate) offers: &'a [Offer],
    /// Conditions on which a goal may depend.
    pub(crate) conditions: &'a [Dependence],
    /// Separators that may follow a goal.
    pub(crate) joints: &'a [&'static str],
    /// True if the answer may also end after the goal.
    pub(crate) may_end: bool,
}

/// Returns a grammar in llguidance's Lark dialect for the next goal of an answer.
///
/// After the goal the answer may end, or continue with " &" if `more` is true. If `offers` is empty, the grammar admits
/// only a question.
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

/// Returns the grammar for all possible continuations.
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

/// Returns the rule for the condition of a goal, up to "then".
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

/// Appends the rule for the rest of a form, given the remaining argument lists.
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
    // Entities with equal continuations share one rule.
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

/// Returns a string literal of the grammar. The dialect uses the escapes of JSON.
pub(crate) fn quoted(text: &str) -> String {
    Value::String(text.to_owned()).to_string()
}

/// Maximum number of values in an enumeration that servers accept.
const ENUM_LIMIT: usize = 500;
/// Maximum total length of an enumeration, in bytes.
const ENUM_BYTES: usize = 12_000;

/// Returns a JSON schema for a whole answer: `{"question": "", "goals": ["put(pie, oven)"]}`.
///
/// The schema enumerates the offered goals if servers can be expected to accept the list. Otherwise it admits any
/// string, and the parser rejects strings that are no goals.
pub fn schema(domain: &Domain, world: &World, offers: &[Offer]) -> Value {
    schema_of(domain, world, offers, false)
}

/// Returns the schema; with `depends`, goals may have conditions, so it admits any string.
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
