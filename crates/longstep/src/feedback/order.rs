//! Another reading of words about the steps, for when the first one cannot be had.
//!
//! "Open the fridge first" may insert a step or move one that the plan has. A model writes one of the two.

use super::StepWish;
use super::amend::{Amendment, unrepaired};
use super::offer::does;
use crate::environment::World;
use crate::plan::{Plan, Step};
use crate::verify::Purpose;
use longstep_core::model::Domain;

/// Reads the insertion of a step that the plan has already as a wish about the order of its steps: the step, or the
/// steps around it that handle the same entity, are moved to where it was to be inserted. Repair is not tried: it could make
/// any order possible by doing the step twice.
pub(crate) fn reordered(world: &World, plan: &Plan, wishes: &[StepWish], purpose: &Purpose) -> Option<Amendment> {
    let domain = world.domain();
    let [
        StepWish::Insert {
            before,
            action,
            arguments,
            ..
        },
    ] = wishes
    else {
        return None;
    };
    let before = *before;
    let steps = plan.steps();
    for at in (0..steps.len()).filter(|at| does(domain, &steps[*at], *action, arguments)) {
        for (begin, end) in blocks(domain, steps, at) {
            if (begin..=end).contains(&before) {
                continue;
            }
            let moved: Vec<StepWish> = (begin..end).map(|step| StepWish::Move { step, before }).collect();
            if let Some(amendment) = unrepaired(world, plan, &moved, purpose) {
                return Some(amendment);
            }
        }
    }
    None
}

/// Runs of consecutive steps around one that all handle the same entity, the shortest first.
fn blocks(domain: &Domain, steps: &[Step], at: usize) -> Vec<(usize, usize)> {
    let object = steps[at].object(domain).or(steps[at].arguments.first().copied());
    let handles = |step: &Step| object.is_some_and(|object| step.arguments.contains(&object));
    let before = steps[..at].iter().rev().take_while(|step| handles(step)).count();
    let after = steps[at + 1..].iter().take_while(|step| handles(step)).count();
    let begins = at - before..=at;
    let mut blocks: Vec<(usize, usize)> = begins
        .flat_map(|begin| (at + 1..=at + 1 + after).map(move |end| (begin, end)))
        .collect();
    blocks.sort_by_key(|(begin, end)| end - begin);
    blocks
}
