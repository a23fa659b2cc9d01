//! Steps and outcomes as calls.

use crate::call::Call;
use crate::model::{ActionId, EntityId, Fact, World};

/// Writes an action with all its arguments, those that calls omit included.
pub(super) fn written_step(world: &World, action: ActionId, arguments: &[EntityId]) -> String {
    let call = Call {
        name: world.domain().action(action).name.clone(),
        arguments: arguments
            .iter()
            .map(|entity| world.entity(*entity).identifier.clone())
            .collect(),
    };
    call.to_string()
}

/// Writes the outcome of a sensing step: `expired(<milk>)`.
pub(super) fn written_outcome(world: &World, fact: Fact) -> String {
    let domain = world.domain();
    let call = Call {
        name: domain.predicate(fact.predicate()).name.clone(),
        arguments: domain
            .arguments(fact)
            .map(|entity| world.entity(entity).identifier.clone())
            .collect(),
    };
    call.to_string()
}
