//! The goals on offer as a grammar, and as a JSON schema.

use indexmap::IndexMap;
use serde_json::{Value, json};

use super::{GoalFact, Offer};
use crate::domain::{Domain, FormPiece, GoalWord};
use crate::world::{EntityId, World};

/// How a question begins in a model's answer.
pub(crate) const QUESTION: &str = "question: ";

/// What joins two goals. A fact ends with the first part and the next one begins with the rest: a model
/// writes the blank and the word after it as one token, so the grammar must not be cut between them.
pub(crate) const JOINT: &str = " &";

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

/// A grammar in llguidance's Lark dialect for the next goal of an answer.
///
/// After the goal the answer may end, or go on with " &" when `more` is true. When nothing is on offer, only
/// a question is left to say.
pub fn grammar(domain: &Domain, world: &World, offers: &[Offer], place: Place, more: bool) -> String {
    let alternatives: Vec<String> = offers
        .iter()
        .map(|offer| word_rule(domain.goal_word(offer.word), world, &offer.arguments))
        .collect();
    let question = format!("question: {} /[A-Za-z][A-Za-z0-9 ,'-]{{8,120}}\\?/\n", quoted(QUESTION));
    if alternatives.is_empty() {
        return format!("start: question\n{question}");
    }
    let mut text = String::from(match place {
        Place::First { question: true } => "start: question | goal more\n",
        Place::First { question: false } => "start: goal more\n",
        Place::Next => "start: \" \" goal more\n",
    });
    if place == (Place::First { question: true }) {
        text.push_str(&question);
    }
    text.push_str(if more { "more: \" &\"?\n" } else { "more: \"\"\n" });
    text.push_str(&format!("goal: {}\n", alternatives.join("\n  | ")));
    text
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
    let texts: Vec<String> = offers
        .iter()
        .flat_map(|offer| offer.arguments.iter().map(|arguments| (offer.word, arguments.clone())))
        .map(|(word, arguments)| GoalFact::Word { word, arguments }.everyday(domain, world))
        .collect();
    let listed =
        !texts.is_empty() && texts.len() <= ENUM_LIMIT && texts.iter().map(String::len).sum::<usize>() <= ENUM_BYTES;
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
