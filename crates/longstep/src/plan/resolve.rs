//! From the words of a plan file to actions and entities.

use super::TaskCohesion;
use crate::call::Call;
use crate::diagnostic::nearest;
use crate::domain::{ActionId, Domain};
use crate::verify::Violation;
use crate::world::{EntityId, World};

/// A step whose implicit arguments are not known yet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DraftStep {
    /// The action.
    pub action: ActionId,
    /// One entity for each parameter, none where the call syntax hides it.
    pub arguments: Vec<Option<EntityId>>,
    /// What the plan says that the step does; empty if it does not say.
    pub explanation: String,
}

/// Resolves every step, or tells everything that stands in the way.
///
/// # Errors
///
/// A violation for each step that names an unknown action or entity, or has the wrong number or types of
/// arguments, and for each unknown name under `object_name`.
pub fn resolve(
    domain: &Domain,
    world: &World,
    written: &TaskCohesion,
) -> Result<(Vec<DraftStep>, Vec<EntityId>), Vec<Violation>> {
    let mut steps = Vec::with_capacity(written.task_sequence.len());
    let mut violations = Vec::new();
    let mut objects = Vec::new();
    for name in written.objects() {
        match world.find(name) {
            Some(entity) => objects.push(entity),
            None => violations.push(unknown_entity(world, None, name)),
        }
    }
    for (index, text) in written.task_sequence.iter().enumerate() {
        let explanation = written.step_instructions.get(index).cloned().unwrap_or_default();
        match step(domain, world, index, text, explanation) {
            Ok(step) => steps.push(step),
            Err(found) => violations.extend(found),
        }
    }
    if violations.is_empty() {
        Ok((steps, objects))
    } else {
        Err(violations)
    }
}

fn unknown_entity(world: &World, step: Option<usize>, name: &str) -> Violation {
    let known = world.entities().map(|(_, entity)| entity.identifier.as_str());
    Violation::UnknownEntity {
        step,
        name: name.to_owned(),
        near: nearest(name, known).map(str::to_owned),
    }
}

fn step(
    domain: &Domain,
    world: &World,
    index: usize,
    text: &str,
    explanation: String,
) -> Result<DraftStep, Vec<Violation>> {
    let unknown = |name: &str| {
        let known = domain.actions.iter().map(|action| action.call.as_str());
        vec![Violation::UnknownAction {
            step: index,
            name: name.to_owned(),
            near: nearest(name, known).map(str::to_owned),
        }]
    };
    let call = Call::parse(text).map_err(|_| unknown(text))?;
    let found = domain
        .action_ids()
        .find(|(_, action)| action.call.eq_ignore_ascii_case(&call.name));
    let (id, action) = found.ok_or_else(|| unknown(&call.name))?;
    if call.arguments.len() != action.explicit.len() {
        return Err(vec![Violation::WrongArguments {
            step: index,
            call: text.to_owned(),
            expected: action.explicit.len(),
        }]);
    }
    let mut arguments = vec![None; action.parameters.len()];
    let mut violations = Vec::new();
    for (name, parameter) in call.arguments.iter().zip(&action.explicit) {
        let Some(entity) = world.find(name) else {
            violations.push(unknown_entity(world, Some(index), name));
            continue;
        };
        let expected = action.parameters[*parameter].kind;
        if !domain.types.is_a(world.entity(entity).kind, expected) {
            violations.push(Violation::WrongType {
                step: index,
                name: name.clone(),
                expected: domain.types.name(expected).to_owned(),
            });
        }
        arguments[*parameter] = Some(entity);
    }
    if !violations.is_empty() {
        return Err(violations);
    }
    Ok(DraftStep {
        action: id,
        arguments,
        explanation,
    })
}
