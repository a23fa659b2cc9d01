//! Plans in PDDL notation, one `(action argument ...)` per line.

use rustc_hash::FxHashMap;

use super::object_names;
use super::plan_lines::{Form, Line, Lines};
use crate::search::GroundAction;
use longstep_model::diagnostic::{Diagnostic, Diagnostics, Position, nearest};
use longstep_model::model::{Domain, EntityId, World};
use longstep_verify::plan::Step;

/// Writes steps with all their arguments, one per line, with the names of [`object_names`]. A plan without steps is a comment.
pub fn write_plan(world: &World, steps: &[Step]) -> String {
    let names = object_names(world);
    let mut plan = String::new();
    if steps.is_empty() {
        plan.push_str("; no steps\n");
    }
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

/// A plan of another planner.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ForeignPlan {
    /// Its steps, in the order in which they begin.
    pub steps: Vec<GroundAction>,
    /// Assumptions about the plan, for a person.
    pub notes: Vec<String>,
}

/// Who may have written a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Author {
    /// A planner: the text has steps as only planners write them.
    Planner,
    /// A planner, a person or a model: all of its steps are written `move(a, b)`.
    Anybody,
}

/// Returns the author of a text that may be the plan of a planner: it has no JSON, and most of its lines, or some with the names of
/// actions of this domain, are steps. A plan without steps has comments only.
pub fn author_of_plan(domain: &Domain, text: &str) -> Option<Author> {
    if text.contains('{') || text.trim_start().starts_with(['[', '<']) {
        return None;
    }
    let lines = Lines::read(text, |word| is_action(domain, word));
    let known = |line: &Line| is_action(domain, &line.words[0].text);
    let filled = |line: &&str| !line.trim().is_empty() && !line.trim_start().starts_with(';');
    let (steps, filled) = (lines.steps.len(), text.lines().filter(filled).count());
    let is_empty_plan = filled == 0 && text.contains(';');
    let is_plan = is_empty_plan || lines.steps.iter().any(known) || (steps > 0 && 2 * steps > filled);
    let is_call = |line: &Line| line.form == Form::Call && line.start.is_none();
    is_plan.then(|| {
        if steps > 0 && lines.steps.iter().all(is_call) {
            Author::Anybody
        } else {
            Author::Planner
        }
    })
}

fn is_action(domain: &Domain, word: &str) -> bool {
    domain.actions.iter().any(|action| action.name == word)
}

/// Parses the plan of a planner for this world: steps as `(move a b)`, with times and durations, as `move(a, b)` or as
/// `step 0: MOVE A B`, a line each. Comments and the log before and behind the steps are skipped; of several plans that a planner
/// announced the last one counts.
/// Steps with times are taken one after another in the order in which they begin.
///
/// Applicability is not checked; see [`longstep_verify::verify::check`].
///
/// # Errors
///
/// All unknown actions and objects, wrong numbers of arguments and arguments of the wrong type, and lines between the steps that are
/// none, with their positions; no step.
pub fn read_plan(world: &World, file: &str, text: &str) -> Result<ForeignPlan, Diagnostics> {
    let domain = world.domain();
    let lines = Lines::read(text, |word| is_action(domain, word));
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
    let mut steps = Vec::with_capacity(lines.steps.len());
    let misfit = |position: &Position| Diagnostic::at(file, *position, "expected `(action argument ...)`");
    let mut misfits: Vec<Diagnostic> = lines.misfits.iter().map(misfit).collect();
    misfits.extend(lines.between.iter().map(|position| {
        Diagnostic::at(file, *position, "this line stands between steps and is none")
            .hint("take it out, or begin it with `;`, which makes it a comment")
    }));
    for Line { words, .. } in &lines.steps {
        let Some((head, arguments)) = words.split_first() else {
            continue;
        };
        let name = head.text.as_str();
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
            misfits.push(Diagnostic::at(file, head.position, message));
            continue;
        }
        let mut bound = Vec::with_capacity(arguments.len());
        for (argument, parameter) in arguments.iter().zip(&action.parameters) {
            let name = argument.text.as_str();
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
    let is_comment = |line: &str| line.trim().is_empty() || line.trim_start().starts_with(';');
    if steps.is_empty() && findings.is_empty() && !text.lines().all(is_comment) {
        return Err(Diagnostics(vec![Diagnostic::whole(
            file,
            "no step: expected `(action argument ...)` on each line",
        )]));
    }
    if !findings.is_empty() {
        return Err(Diagnostics::sorted(findings));
    }
    let mut notes = Vec::new();
    if lines.earlier > 0 {
        notes.push(format!(
            "the file has {} plans; the last one was taken",
            lines.earlier + 1
        ));
    }
    if lines.overlaps {
        notes.push(
            "steps of this plan are under way at the same time; it was read as steps one after another, in the order in which they begin"
                .to_owned(),
        );
    }
    Ok(ForeignPlan { steps, notes })
}
