//! Structured output for goals: a grammar and a JSON schema of the offered goals.

use indexmap::{IndexMap, IndexSet};
use longstep_core::model::written_fact;
use serde_json::Value;

use super::answer_grammar::{ENUM_LIMIT, Form, any_text, closed, list, listed, one_of};
use crate::coverage::Gap;
use crate::effort;
use crate::environment::{EntityId, World};
use crate::goal::{self, Dependence, GoalFact, IF, NOT, Offer, THEN};
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
    if ways.offers.is_empty() {
        return Form::question().grammar();
    }
    let joints = Form::texts(ways.joints.iter().map(|joint| (*joint).to_owned()));
    let more = match (ways.joints.is_empty(), ways.may_end) {
        (true, _) => Form::text(""),
        (false, true) => joints.optional(),
        (false, false) => joints,
    };
    let goals = ways.offers.iter();
    let goals = goals.map(|offer| word_form(world.domain().goal_word(offer.word), world, &offer.arguments));
    let mut parts = vec![Form::Row(vec![Form::Either(goals.collect()), more])];
    if !ways.conditions.is_empty() {
        let conditions = ways.conditions.iter();
        parts.push(Form::texts(conditions.map(|depends| condition(world, depends))));
    }
    match place {
        Place::First { question: true } => parts.insert(0, Form::question()),
        Place::First { question: false } => {}
        Place::Next => return Form::Row(vec![Form::text(" "), Form::Either(parts)]).grammar(),
    }
    Form::Either(parts).grammar()
}

/// Returns the condition of a goal, up to "then".
fn condition(world: &World, depends: &Dependence) -> String {
    let name = |entity: EntityId| world.entity(entity).name.clone();
    let not = if depends.negated { NOT } else { "" };
    format!("{IF}{not}{}{THEN}", written_fact(world.domain(), depends.fact, &name))
}

fn word_form(word: &GoalWord, world: &World, arguments: &[Vec<EntityId>]) -> Form {
    let mut parts = Vec::new();
    form_from(&word.form, world, arguments, &mut parts);
    Form::Row(parts)
}

/// Appends the rest of a form, given the remaining argument lists.
fn form_from(form: &[FormPiece], world: &World, arguments: &[Vec<EntityId>], parts: &mut Vec<Form>) {
    let Some((piece, rest)) = form.split_first() else {
        return;
    };
    let index = match piece {
        FormPiece::Text(text) => {
            parts.push(Form::text(text));
            return form_from(rest, world, arguments, parts);
        }
        FormPiece::Parameter(index) => *index,
    };
    // Entities with equal continuations share one form.
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
    let alternatives = groups.into_iter().map(|(others, entities)| {
        let names = entities.iter().map(|entity| world.entity(*entity).name.clone());
        let mut parts = vec![Form::texts(names)];
        form_from(rest, world, &others, &mut parts);
        Form::Row(parts)
    });
    parts.push(Form::Either(alternatives.collect()));
}

/// Lists the goals that the answer of a server may contain. A schema describes all goals of an answer at once, and a later one
/// may be open only because of those before it ("put the butter on the counter and close the fridge"), so neither the current
/// state nor the names of the instruction narrow the list. None if servers would reject its size.
pub(super) fn listed_goals(world: &World, keep: impl FnOnce(&mut Vec<Offer>)) -> Option<Vec<String>> {
    let found = effort::within(effort::OPERATION, || goal::possible_goals(world, ENUM_LIMIT));
    let mut offers = found.result.filter(|_| !found.exhausted)?;
    keep(&mut offers);
    listed(goal_texts(world, &offers))
}

/// Writes goals in everyday names, each once.
fn goal_texts(world: &World, offers: &[Offer]) -> Vec<String> {
    let word = |offer: &Offer| {
        offer
            .arguments
            .iter()
            .map(|own| (offer.word, own.clone()))
            .collect::<Vec<_>>()
    };
    let goals = offers.iter().flat_map(word);
    let texts = goals.map(|(word, arguments)| GoalFact::Word { word, arguments }.everyday(world));
    texts.collect::<IndexSet<String>>().into_iter().collect()
}

/// Returns a JSON schema for a whole answer: `{"question": "", "goals": ["put(pie, oven)"], "never": [],
/// "not_represented": [{"text": "for ten minutes", "kind": "quantity"}]}`.
///
/// The schema enumerates the goals if they can be `listed`. Otherwise, and for `goals` with `depends`, where goals may have
/// conditions, it admits any string, and the parser rejects strings that are no goals.
pub(super) fn goal_schema(listed: Option<&[String]>, depends: bool) -> Value {
    let goals = listed.filter(|_| !depends);
    let never = one_of(listed);
    let kinds: Vec<String> = Gap::ALL.iter().map(|gap| gap.name().to_owned()).collect();
    let part = closed(&[("text", any_text()), ("kind", one_of(Some(&kinds)))]);
    closed(&[
        ("question", any_text()),
        ("goals", list(one_of(goals))),
        ("never", list(never)),
        ("not_represented", list(part)),
    ])
}
