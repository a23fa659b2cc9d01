//! Goals that make sense in a world.

use crate::effort;
use crate::environment::{Bindings, EntityId, Moment, World, holds};
use crate::model::{GoalWord, GoalWordId};

/// A goal word with the arguments that it is offered with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Offer {
    /// The goal word.
    pub word: GoalWordId,
    /// Argument lists, in the order of the word's parameters.
    pub arguments: Vec<Vec<EntityId>>,
}

/// Returns the goals that make sense in the world and do not hold yet.
pub fn offers(world: &World) -> Vec<Offer> {
    let moment = Moment {
        world,
        state: &world.state,
    };
    let words = world.domain().goal_words.iter().enumerate();
    let offers = words.map(|(index, word)| {
        let mut arguments = sayable(world, word);
        arguments.retain(|bindings| !holds(moment, &word.condition, &mut bindings.clone()));
        Offer {
            word: GoalWordId::new(index),
            arguments,
        }
    });
    offers.filter(|offer| !offer.arguments.is_empty()).collect()
}

/// Returns the argument lists for which a goal word makes sense in the world, whether or not the goal holds: by the known facts, and by
/// the assumed ones only if these give none.
pub(crate) fn sayable(world: &World, word: &GoalWord) -> Vec<Vec<EntityId>> {
    let known = world.known();
    for state in [&known, &world.state] {
        let mut found = Vec::new();
        collect(Moment { world, state }, word, &mut Vec::new(), &mut found);
        if !found.is_empty() {
            return found;
        }
    }
    Vec::new()
}

fn collect(moment: Moment<'_>, word: &GoalWord, bindings: &mut Bindings, found: &mut Vec<Vec<EntityId>>) {
    let Some(parameter) = word.parameters.get(bindings.len()) else {
        let distinct = (1..bindings.len()).all(|at| !bindings[..at].contains(&bindings[at]));
        if distinct && holds(moment, &word.offered, bindings) {
            found.push(bindings.clone());
        }
        return;
    };
    for entity in moment.world.of_kind(parameter.kind) {
        if !effort::spend(1) {
            return;
        }
        bindings.push(*entity);
        collect(moment, word, bindings, found);
        bindings.pop();
    }
}
