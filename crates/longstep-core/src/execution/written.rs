//! Steps and outcomes as calls, violations as sentences.

use longstep_model::call::Call;
use longstep_model::model::{ActionId, EntityId, Fact, World};
use longstep_search::goal::Goal;
use longstep_verify::plan::{Step, Violation};

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

/// Writes violations of a plan with these steps, made for a goal if it is known, as sentences for a person.
pub(super) fn messages(world: &World, violations: &[Violation], steps: &[Step], goal: Option<&Goal>) -> Vec<String> {
    let goal = goal.map(Goal::as_sentences);
    violations.iter().map(|own| own.message(world, steps, goal)).collect()
}
