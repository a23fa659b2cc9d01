//! One fact of a goal, without groups and conditions.

use super::names::{entities, read_form};
use super::{GoalError, GoalFact, NumberGoal, relative};
use longstep_model::call::Call;
use longstep_model::model::{Fact, GoalWordId, Predicate, PredicateId, TypeId, World, ground};

/// Reads a fact in a state word, with the subject as first argument; none if the text has another form.
pub(super) fn state(world: &World, part: &str) -> Result<Option<Fact>, GoalError> {
    let Ok(call) = Call::parse(part) else { return Ok(None) };
    let word = world
        .domain()
        .states
        .iter()
        .find(|s| s.word == call.name && s.parameters.len() + 1 == call.arguments.len());
    let Some(word) = word else {
        return bare(world, part, &call);
    };
    let names: Vec<&str> = call.arguments.iter().map(String::as_str).collect();
    let bindings = entities(world, part, &names, &vec![TypeId::OBJECT; names.len()])?;
    Ok(Some(ground(&word.atom, &bindings)))
}

/// Reads a fact of a predicate by its name in PDDL, or with `_` for its `-`; none if there is no such predicate.
fn bare(world: &World, part: &str, call: &Call) -> Result<Option<Fact>, GoalError> {
    let domain = world.domain();
    let mut predicates = domain.predicates.iter();
    let Some(index) = predicates.position(|predicate| is_called(predicate, call)) else {
        return Ok(None);
    };
    let id = PredicateId::new(index);
    // No action changes a static fact, so neither a goal nor a rule about it makes sense.
    if !domain.words(id).fluent {
        return Ok(None);
    }
    let names: Vec<&str> = call.arguments.iter().map(String::as_str).collect();
    let kinds = domain.predicates[index]
        .parameters
        .iter()
        .map(|parameter| parameter.kind);
    let arguments = entities(world, part, &names, &kinds.collect::<Vec<_>>())?;
    Ok(Some(Fact::new(id, arguments)))
}

fn is_called(predicate: &Predicate, call: &Call) -> bool {
    let is_named = predicate.name == call.name || predicate.name.replace('-', "_") == call.name;
    is_named && predicate.parameters.len() == call.arguments.len()
}

/// Reads a goal word, a comparison or a state word about named entities.
pub(super) fn plain(world: &World, part: &str) -> Result<GoalFact, GoalError> {
    let domain = world.domain();
    if let Some(comparison) = NumberGoal::read(world, part)? {
        return Ok(comparison.into());
    }
    let mut error = None;
    for (index, word) in domain.goal_words.iter().enumerate() {
        let Some(names) = read_form(word, part) else { continue };
        let kinds: Vec<TypeId> = word.parameters.iter().map(|parameter| parameter.kind).collect();
        let resolved = relative::resolved(world, part, word, &names);
        let named = resolved.and_then(|names| {
            let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
            entities(world, part, &names, &kinds)
        });
        match named {
            Ok(arguments) => {
                return Ok(GoalFact::Word {
                    word: GoalWordId::new(index),
                    arguments,
                });
            }
            // Several forms of one word may match; the first error is the clearest, and best one in a form with known names
            // or with a shorter unknown one: `bench` and not `under bench`.
            Err(found) => match (&error, &found) {
                (Some(GoalError::UnknownName { .. }), GoalError::WrongType { .. }) | (None, _) => error = Some(found),
                (Some(GoalError::UnknownName { name: earlier, .. }), GoalError::UnknownName { name, .. })
                    if name.len() < earlier.len() =>
                {
                    error = Some(found)
                }
                _ => {}
            },
        }
    }
    // Form and names fit, and only the present amount is unknown: no other reading explains the text better.
    if let Some(own @ GoalError::UnknownNow { .. }) = error {
        return Err(own);
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
            // The text may be anything that a model wrote.
            part: part.chars().take(80).collect(),
            forms: forms.join(", "),
        }
    }))
}
