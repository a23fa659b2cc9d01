//! The parser of goals.

use super::{Conditional, Goal, GoalFact, WrittenConditional};
use crate::call::Call;
use crate::diagnostic::nearest;
use crate::model::{EntityId, Fact, FormPiece, GoalWord, GoalWordId, TypeId, World, ground};

/// The prefix of a question in a model's answer.
pub const QUESTION: &str = "question: ";

/// The separator after a goal, without the blank before the next one. Models write a blank and the following word as
/// one token, so the grammar must not split them.
pub const JOINT: &str = " &";

/// The reason why a text is not a goal.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GoalError {
    /// An empty part between two `&`.
    #[error("the goal has an empty part")]
    Empty,
    /// A word that is not a goal word of the domain.
    #[error("`{part}` is not a goal of this domain; write {forms}")]
    UnknownWord {
        /// The part of the goal.
        part: String,
        /// The notations of the domain's goal words.
        forms: String,
    },
    /// A name that no entity has.
    #[error("`{name}` in `{part}` is nothing in the environment{}", near.as_ref().map_or(String::new(), |n| format!("; did you mean `{n}`?")))]
    UnknownName {
        /// The part of the goal.
        part: String,
        /// The name.
        name: String,
        /// An entity name that resembles it.
        near: Option<String>,
    },
    /// A condition that no sensing action reveals.
    #[error("`{condition}` is nothing that sensing tells here, so no goal can depend on it{}", if forms.is_empty() { String::new() } else { format!("; write {forms}") })]
    NotSensed {
        /// The condition.
        condition: String,
        /// The facts that sensing actions reveal.
        forms: String,
    },
    /// An entity of the wrong type.
    #[error("`{name}` in `{part}` is no {expected}")]
    WrongType {
        /// The part of the goal.
        part: String,
        /// The name.
        name: String,
        /// The expected type.
        expected: String,
    },
}

/// Parses a goal: parts joined by `&`. A part is a goal word, or a state word with the subject as first argument:
/// `INSIDE(<pie>, <oven>)`. Entities are given by everyday name or identifier.
///
/// A part may depend on a sensed fact, in the form
/// `if expired(milk) then put(milk, bin) and closed(fridge) else put(milk, fridge)`. The word "and" joins the goals of
/// a branch, and the `else` branch is optional.
///
/// # Errors
///
/// The error in the first unreadable part.
pub fn parse(world: &World, text: &str) -> Result<Goal, GoalError> {
    let mut goal = Goal::default();
    for part in text.split('&').map(str::trim) {
        if part.is_empty() {
            return Err(GoalError::Empty);
        }
        let fact = fact(world, part)?;
        if !goal.facts.contains(&fact) {
            goal.facts.push(fact);
        }
    }
    Ok(goal)
}

fn fact(world: &World, part: &str) -> Result<GoalFact, GoalError> {
    match WrittenConditional::read(part) {
        Some(written) => Ok(GoalFact::If(conditional(world, &written)?)),
        None => plain(world, part),
    }
}

/// Reads a conditional goal; its branches cannot contain conditions.
fn conditional(world: &World, written: &WrittenConditional<'_>) -> Result<Conditional, GoalError> {
    let domain = world.domain();
    let condition = match state(world, written.condition)? {
        Some(fact) if domain.is_sensed(fact.predicate()) => fact,
        _ => {
            let sensed = domain
                .states
                .iter()
                .filter(|word| domain.is_sensed(word.atom.predicate));
            let forms: Vec<String> = sensed.map(|word| format!("`{}(...)`", word.word)).collect();
            return Err(GoalError::NotSensed {
                condition: written.condition.to_owned(),
                forms: forms.join(", "),
            });
        }
    };
    let side = |parts: &[&str]| {
        let mut facts: Vec<GoalFact> = Vec::new();
        for text in parts {
            if text.is_empty() {
                return Err(GoalError::Empty);
            }
            let fact = plain(world, text)?;
            if !facts.contains(&fact) {
                facts.push(fact);
            }
        }
        Ok(facts)
    };
    let (then, otherwise) = (side(&written.then)?, side(&written.otherwise)?);
    let others: Vec<Fact> = domain
        .outcomes(condition)
        .into_iter()
        .filter(|o| *o != condition)
        .collect();
    Ok(match (written.negated, &others[..]) {
        (false, _) => Conditional {
            condition,
            then,
            otherwise,
        },
        (true, [other]) => Conditional {
            condition: *other,
            then,
            otherwise,
        },
        (true, _) => Conditional {
            condition,
            then: otherwise,
            otherwise: then,
        },
    })
}

/// Reads a fact in a state word, with the subject as first argument; none if the text has another form.
fn state(world: &World, part: &str) -> Result<Option<Fact>, GoalError> {
    let Ok(call) = Call::parse(part) else { return Ok(None) };
    let word = world
        .domain()
        .states
        .iter()
        .find(|s| s.word == call.name && s.parameters.len() + 1 == call.arguments.len());
    let Some(word) = word else { return Ok(None) };
    let names: Vec<&str> = call.arguments.iter().map(String::as_str).collect();
    let bindings = entities(world, part, &names, &vec![TypeId::OBJECT; names.len()])?;
    Ok(Some(ground(&word.atom, &bindings)))
}

fn plain(world: &World, part: &str) -> Result<GoalFact, GoalError> {
    let domain = world.domain();
    let mut error = None;
    for (index, word) in domain.goal_words.iter().enumerate() {
        let Some(names) = read_form(word, part) else { continue };
        let kinds: Vec<TypeId> = word.parameters.iter().map(|parameter| parameter.kind).collect();
        match entities(world, part, &names, &kinds) {
            Ok(arguments) => {
                return Ok(GoalFact::Word {
                    word: GoalWordId::new(index),
                    arguments,
                });
            }
            // Several forms of one word may match; the first error is the clearest.
            Err(found) => {
                error.get_or_insert(found);
            }
        }
    }
    if let Some(fact) = state(world, part)? {
        return Ok(GoalFact::Plain(fact));
    }
    Err(error.unwrap_or_else(|| {
        let mut forms: Vec<String> = domain
            .goal_words
            .iter()
            .map(|word| format!("`{}`", word.shown()))
            .collect();
        forms.dedup();
        GoalError::UnknownWord {
            part: part.chars().take(80).collect(),
            forms: forms.join(", "),
        }
    }))
}

/// Returns the names in a goal of this form, by parameter; none if the text has another form.
pub fn read_form<'t>(word: &GoalWord, text: &'t str) -> Option<Vec<&'t str>> {
    let mut names = vec![""; word.parameters.len()];
    let mut rest = text;
    let mut pieces = word.form.iter().peekable();
    while let Some(piece) = pieces.next() {
        match piece {
            FormPiece::Text(text) => rest = rest.strip_prefix(text.as_str())?,
            FormPiece::Parameter(index) => {
                let end = match pieces.peek() {
                    Some(FormPiece::Text(next)) if !next.is_empty() => rest.find(next.as_str())?,
                    _ => rest.len(),
                };
                names[*index] = rest[..end].trim();
                rest = &rest[end..];
            }
        }
    }
    rest.is_empty().then_some(names)
}

fn entities(world: &World, part: &str, names: &[&str], kinds: &[TypeId]) -> Result<Vec<EntityId>, GoalError> {
    let domain = world.domain();
    let mut entities = Vec::with_capacity(names.len());
    for (name, kind) in names.iter().zip(kinds) {
        let Some(entity) = world.find(name).or_else(|| world.find_name(name)) else {
            let known = world.entities().map(|(_, entity)| entity.name.as_str());
            return Err(GoalError::UnknownName {
                part: part.to_owned(),
                name: (*name).to_owned(),
                near: nearest(name, known).map(str::to_owned),
            });
        };
        if !domain.types.is_a(world.entity(entity).kind, *kind) {
            return Err(GoalError::WrongType {
                part: part.to_owned(),
                name: (*name).to_owned(),
                expected: domain.types.name(*kind).to_owned(),
            });
        }
        entities.push(entity);
    }
    Ok(entities)
}
