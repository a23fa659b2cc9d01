//! Plans in PDDL notation, one `(action argument ...)` per line.

use rustc_hash::FxHashMap;

use super::object_names;
use crate::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::domain::sexpr;
use crate::model::{EntityId, World};
use crate::plan::Step;
use crate::search::GroundAction;

/// Writes steps with all their arguments, one per line, with the names of [`object_names`].
pub fn write_plan(world: &World, steps: &[Step]) -> String {
    let names = object_names(world);
    let mut plan = String::new();
    for step in steps {
        plan.push('(');
        plan.push_str(&world.domain().action(step.action).name);
        for argument in &step.arguments {
            plan.push(' ');
            plan.push_str(&names[argument.index()]);
        }
        plan.push_str(")\n");
    }
    plan
}

/// Parses a planner's plan for a problem of this world; comments are skipped.
///
/// Applicability is not checked; see [`crate::verify::check`].
///
/// # Errors
///
/// All unknown actions and objects, wrong numbers of arguments and arguments of the wrong type, with their positions.
pub fn read_plan(world: &World, file: &str, text: &str) -> Result<Vec<GroundAction>, Diagnostics> {
    let domain = world.domain();
    let lines = sexpr::read(file, text).map_err(|finding| Diagnostics(vec![finding]))?;
    let names = object_names(world);
    let entities: FxHashMap<&str, EntityId> = names
        .iter()
        .enumerate()
        .map(|(index, name)| (name.as_str(), EntityId::new(index)))
        .collect();
    let mut findings = Vec::new();
    let mut unknown = |position, what: &str, name: &str, near: Option<&str>| {
        let mut finding = Diagnostic::at(file, position, format!("unknown {what} `{name}`"));
        finding.hint = near.map(|near| format!("did you mean `{near}`?"));
        findings.push(finding);
    };
    let mut steps = Vec::with_capacity(lines.len());
    let mut misfits = Vec::new();
    for line in &lines {
        let words = line.list().unwrap_or_default();
        let Some((head, arguments)) = words.split_first() else {
            misfits.push(Diagnostic::at(file, line.position, "expected `(action argument ...)`"));
            continue;
        };
        let name = head.word().unwrap_or("(...)");
        let Some((id, action)) = domain.action_ids().find(|(_, action)| action.name == name) else {
            let known = domain.actions.iter().map(|action| action.name.as_str());
            unknown(head.position, "action", name, nearest(name, known));
            continue;
        };
        if action.parameters.len() != arguments.len() {
            let message = format!(
                "`{name}` takes {} argument(s), not {}",
                action.parameters.len(),
                arguments.len()
            );
            misfits.push(Diagnostic::at(file, line.position, message));
            continue;
        }
        let mut bound = Vec::with_capacity(arguments.len());
        for (argument, parameter) in arguments.iter().zip(&action.parameters) {
            let name = argument.word().unwrap_or("(...)");
            let Some(entity) = entities.get(name).copied() else {
                let near = nearest(name, names.iter().map(String::as_str));
                unknown(argument.position, "object", name, near);
                continue;
            };
            if !domain.types.is_a(world.entity(entity).kind, parameter.kind) {
                let message = format!("`{name}` is no {}", domain.types.name(parameter.kind));
                misfits.push(Diagnostic::at(file, argument.position, message));
                continue;
            }
            bound.push(entity);
        }
        steps.push(GroundAction {
            action: id,
            arguments: bound,
        });
    }
    findings.extend(misfits);
    if findings.is_empty() {
        Ok(steps)
    } else {
        Err(Diagnostics::sorted(findings))
    }
}
