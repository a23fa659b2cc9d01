//! Structured output for goals: a grammar and a JSON schema of the offered goals.

use indexmap::IndexMap;
use longstep_core::model::written_fact;
use serde_json::Value;

use super::answer_grammar::{Grammar, any_text, closed, group, list, listed, one_of, quoted};
use crate::coverage::Gap;
use crate::environment::{EntityId, World};
use crate::goal::{Dependence, GoalFact, IF, NOT, Offer, THEN};
use crate::model::{FormPiece, GoalWord};

/// Position of a goal in an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
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
pub(super) struct Ways<'a> {
    /// Goals.
    pub(super) offers: &'a [Offer],
    /// Conditions on which a goal may depend.
    pub(super) conditions: &'a [Dependence],
    /// Separators that may follow a goal.
    pub(super) joints: &'a [&'static str],
    /// True if the answer may also end after the goal.
    pub(super) may_end: bool,
}

/// Returns a grammar in llguidance's Lark dialect for the next goal of an answer. Without offers it admits only a question.
pub(super) fn goal_grammar(world: &World, ways: &Ways<'_>, place: Place) -> String {
    let mut grammar = Grammar::default();
    if ways.offers.is_empty() {
        grammar.question();
        return grammar.text();
    }
    let goal = match ways.conditions.is_empty() {
        true => "goal more",
        false => "goal more | condition",
    };
    match place {
        Place::First { question } => {
            if question {
                grammar.question();
            }
            grammar.start(goal);
        }
        Place::Next if ways.conditions.is_empty() => grammar.start(format!("\" \" {goal}")),
        Place::Next => grammar.start(format!("\" \" ({goal})")),
    }
    let joints: Vec<String> = ways.joints.iter().map(|joint| quoted(joint)).collect();
    grammar.rule(
        "more",
        [match (joints.is_empty(), ways.may_end) {
            (true, _) => quoted(""),
            (false, true) => group(&joints) + "?",
            (false, false) => group(&joints),
        }],
    );
    if !ways.conditions.is_empty() {
        let conditions = ways.conditions.iter();
        grammar.rule("condition", conditions.map(|depends| condition(world, depends)));
    }
    let goals = ways.offers.iter();
    let goals = goals.map(|offer| word_rule(world.domain().goal_word(offer.word), world, &offer.arguments));
    grammar.rule("goal", goals);
    grammar.text()
}

/// Returns the condition of a goal, up to "then".
fn condition(world: &World, depends: &Dependence) -> String {
    let name = |entity: EntityId| world.entity(entity).name.clone();
    let not = if depends.negated { NOT } else { "" };
    quoted(&format!(
        "{IF}{not}{}{THEN}",
        written_fact(world.domain(), depends.fact, &name)
    ))
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

/// Returns a JSON schema for a whole answer: `{"question": "", "goals": ["put(pie, oven)"], "never": [],
/// "not_represented": [{"text": "for ten minutes", "kind": "quantity"}]}`.
///
/// The schema enumerates the offered goals if servers can be expected to accept the list. Otherwise, and with `depends`,
/// where goals may have conditions, it admits any string, and the parser rejects strings that are no goals.
pub(super) fn goal_schema(world: &World, offers: &[Offer], depends: bool) -> Value {
    let texts = offers
        .iter()
        .flat_map(|offer| offer.arguments.iter().map(|arguments| (offer.word, arguments.clone())))
        .map(|(word, arguments)| GoalFact::Word { word, arguments }.everyday(world));
    let all: Vec<String> = texts.collect();
    let goals = match depends {
        true => None,
        false => listed(all.clone()),
    };
    let never = one_of(listed(all).as_deref());
    let kinds: Vec<String> = Gap::ALL.iter().map(|gap| gap.name().to_owned()).collect();
    let part = closed(&[("text", any_text()), ("kind", one_of(Some(&kinds)))]);
    closed(&[
        ("question", any_text()),
        ("goals", list(one_of(goals.as_deref()))),
        ("never", list(never)),
        ("not_represented", list(part)),
    ])
}
