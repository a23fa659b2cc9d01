//! Costs of steps as integers of a search task.
//!
//! Costs are decimals of the domain. A search adds integers: the costs are divided by the largest decimal that divides them
//! all, so they stay exact. If the integers are small enough, each step costs a small fraction more, so that among equally
//! cheap plans one with the fewest steps is found.

use super::GroundAction;
use super::task::Task;
use longstep_model::model::{Arithmetic, Number, World};

/// The largest cost of a path that a search adds up, with room for weighted estimates.
const GREATEST: u64 = u32::MAX as u64 / 8;
/// The number of steps that a plan is expected to have at most.
const STEPS: u64 = 1_000;

/// The costs of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Costs {
    /// A plan with fewer steps than this is cheapest if no path has a lower sum of integers.
    pub(super) steps: usize,
}

/// Sets the costs of all operators from those of their actions; a step of an action without a cost costs nothing.
///
/// In a domain without costs, every step costs 1.
///
/// # Errors
///
/// The reason why the costs cannot be added up.
pub(super) fn price(world: &World, task: &mut Task) -> Result<Costs, String> {
    if !world.domain().has_costs() {
        return Ok(Costs { steps: usize::MAX });
    }
    let mut costs: Vec<u64> = Vec::with_capacity(task.operators.len());
    for operator in &task.operators {
        let cost = if operator.is_mark {
            Number::ZERO
        } else {
            fixed(world, &operator.step)?
        };
        costs.push(cost.millionths().unsigned_abs());
    }
    let divisor = costs.iter().copied().fold(0, greatest_common_divisor).max(1);
    let greatest = costs.iter().max().copied().unwrap_or(0) / divisor;
    // In a plan of fewer than `factor` steps the fractions sum to less than one unit of cost, so they only break ties.
    let Some(factor) = [STEPS, STEPS / 10, 1]
        .into_iter()
        .find(|factor| is_affordable(greatest, *factor))
    else {
        let span = Number::of_millionths(i64::try_from(divisor).unwrap_or(i64::MAX)).unwrap_or_default();
        return Err(format!(
            "the costs of steps differ too much to be added up exactly: up to {greatest} times {span}; round them in the domain"
        ));
    };
    for (operator, cost) in task.operators.iter_mut().zip(costs) {
        if !operator.is_mark {
            operator.cost = (cost / divisor * factor) as u32 + u32::from(factor > 1);
        }
    }
    Ok(Costs {
        steps: match factor {
            1 => usize::MAX,
            factor => factor as usize,
        },
    })
}

/// Returns true if a search can add up the costs of a path, of which the greatest is given, scaled by the factor.
fn is_affordable(greatest: u64, factor: u64) -> bool {
    let longest = greatest.saturating_mul(factor).saturating_add(1).saturating_mul(STEPS);
    longest <= GREATEST
}

/// Returns the cost of a step, which must not depend on numbers that change.
fn fixed(world: &World, step: &GroundAction) -> Result<Number, String> {
    let action = world.domain().action(step.action);
    let Some(cost) = &action.cost else {
        return Ok(Number::ZERO);
    };
    match cost.ground(world, &step.arguments) {
        // A* and its lower bounds rely on costs that are not negative.
        Arithmetic::Constant(number) if number >= Number::ZERO => Ok(number),
        Arithmetic::Constant(number) => Err(format!("the cost of `{}` is negative: {number}", action.name)),
        _ => Err(format!(
            "the cost of `{}` depends on a number that changes, or cannot be computed; let it depend on numbers that no action changes",
            action.name
        )),
    }
}

fn greatest_common_divisor(one: u64, other: u64) -> u64 {
    match other {
        0 => one,
        _ => greatest_common_divisor(other, one % other),
    }
}

/// Returns the sum of the costs of steps; none in a domain without costs, or if the sum is not known.
pub(super) fn total<'s>(world: &World, steps: impl IntoIterator<Item = &'s GroundAction>) -> Option<Number> {
    if !world.domain().has_costs() {
        return None;
    }
    let mut steps = steps.into_iter();
    steps.try_fold(Number::ZERO, |sum, step| sum.plus(fixed(world, step).ok()?))
}
