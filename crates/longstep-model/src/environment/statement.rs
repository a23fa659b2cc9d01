//! Numbers, and statements without a subject.

use super::{EntityId, Fact, Fluent, Number, World};
use crate::call::Call;
use crate::model::{Domain, FunctionId, PredicateId};

/// A statement of an environment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Statement {
    /// A fact without arguments.
    Fact(Fact),
    /// The number of a fluent.
    Number(Fluent, Number),
}

/// The reason why a statement cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Misstatement {
    /// The wrong number of arguments, the number itself included; with the right number.
    Arguments(usize),
    /// The last argument is no number.
    NoNumber(String),
    /// The environment lists no such entity.
    Unlisted(String),
    /// An entity has the wrong type: the entity and the name of the right type.
    Kind(EntityId, String),
}

/// Returns the function that environments write with this word.
pub(super) fn function_of(domain: &Domain, word: &str) -> Option<FunctionId> {
    let place = domain.functions.iter().position(|function| function.word == word)?;
    Some(FunctionId::new(place))
}

/// Reads the number of a fluent: `level(3)` of `subject`, or `battery(80)` without a subject.
pub(super) fn number(
    world: &World,
    function: FunctionId,
    subject: Option<EntityId>,
    call: &Call,
) -> Result<(Fluent, Number), Misstatement> {
    let domain = world.domain();
    let parameters = &domain.function(function).parameters;
    let expected = (parameters.len() + 1).saturating_sub(usize::from(subject.is_some()));
    let wrong_subject = subject.is_some() && parameters.is_empty();
    let Some((number, others)) = call.arguments.split_last().filter(|_| !wrong_subject) else {
        return Err(Misstatement::Arguments(expected));
    };
    if call.arguments.len() != expected {
        return Err(Misstatement::Arguments(expected));
    }
    let Some(number) = Number::parse(number) else {
        return Err(Misstatement::NoNumber(number.clone()));
    };
    let mut entities: Vec<EntityId> = subject.into_iter().collect();
    for other in others {
        entities.push(world.find(other).ok_or_else(|| Misstatement::Unlisted(other.clone()))?);
    }
    for (entity, parameter) in entities.iter().zip(parameters) {
        if !world.is_of_kind(*entity, parameter.kind) {
            return Err(Misstatement::Kind(
                *entity,
                domain.types.name(parameter.kind).to_owned(),
            ));
        }
    }
    Ok((Fluent::new(function, entities), number))
}

/// Reads a number in the entry of `subject`, or one without a subject; none for any other text.
pub(super) fn number_of(world: &World, subject: Option<EntityId>, text: &str) -> Option<(Fluent, Number)> {
    let call = Call::parse(text).ok()?;
    let function = function_of(world.domain(), &call.name)?;
    number(world, function, subject, &call).ok()
}

/// Reads a fact without arguments; none for any other text.
pub(super) fn fact_alone(domain: &Domain, call: &Call) -> Option<Fact> {
    let alone = |index: &usize| is_stated(domain, PredicateId::new(*index));
    let mut predicates = (0..domain.predicates.len()).filter(alone);
    let index = predicates.find(|index| domain.predicates[*index].name == call.name)?;
    call.arguments
        .is_empty()
        .then(|| Fact::new(PredicateId::new(index), []))
}

/// Returns true for a predicate without arguments whose facts an environment may state: events are none of them.
pub(super) fn is_stated(domain: &Domain, predicate: PredicateId) -> bool {
    domain.predicate(predicate).parameters.is_empty() && !domain.words(predicate).event
}

/// Reads a statement without a subject; none if it cannot be read.
pub(super) fn statement(world: &World, text: &str) -> Option<Statement> {
    let number = number_of(world, None, text).map(|(fluent, number)| Statement::Number(fluent, number));
    let call = Call::parse(text).ok()?;
    number.or_else(|| fact_alone(world.domain(), &call).map(Statement::Fact))
}
