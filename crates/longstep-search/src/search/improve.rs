//! Improvement of a plan: steps that are not needed are dropped, then weighted search looks for cheaper plans with
//! less and less weight (Richter, Thayer and Ruml, *The Joy of Forgetting*, 2010).

use super::Found;
use super::bits::Bits;
use super::greedy::{Lazy, Rank};
use super::node::start;
use super::successor::Successors;
use super::task::Task;
use longstep_model::effort;

/// Weights of the estimate, in the order of the runs.
const WEIGHTS: [u32; 4] = [5, 3, 2, 1];

/// Returns the cost of a path.
pub(super) fn cost(task: &Task, path: &[u32]) -> u32 {
    let costs = path.iter().map(|operator| task.operators[*operator as usize].cost);
    costs.fold(0, u32::saturating_add)
}

/// Improves a plan of a task until no plan is cheaper or the limit is reached. Returns the plan, whether it is proven to be
/// a cheapest one of the task, and the number of evaluated states.
pub(super) fn improve(lazy: &mut Lazy<'_>, task: &Task, path: Vec<u32>, limit: usize) -> ((Vec<u32>, bool), usize) {
    let mut path = without_waste(task, &lazy.successors, path);
    let (mut evaluated, mut weights) = (0, WEIGHTS.iter().peekable());
    while let Some(weight) = weights.peek() {
        let rank = Rank::Weighted(**weight);
        // Each run starts afresh: nodes that a greedier run left open would bias the next one.
        let (found, more) = lazy.run(rank, Some(cost(task, &path)), limit - evaluated);
        evaluated += more;
        match found {
            Found::Path(cheaper) => path = without_waste(task, &lazy.successors, cheaper),
            // The run has looked at every path below the cost, whatever its weight.
            Found::Nothing => return ((path, true), evaluated),
            Found::Limit => break,
        }
        // The last weight stays until nothing cheaper is found.
        weights.next_if(|weight| **weight > 1);
    }
    ((path, false), evaluated)
}

/// Drops steps that the plan reaches its goal without, each together with the later steps that rely on it.
fn without_waste(task: &Task, successors: &Successors<'_>, mut path: Vec<u32>) -> Vec<u32> {
    // Action elimination (Nakhost and Müller, 2010), in time quadratic in the length of the plan.
    let (mut state, mut at) = (start(task), 0);
    while at < path.len() {
        match rest_without(task, successors, &state, &path[at + 1..]) {
            Some(rest) => {
                path.truncate(at);
                path.extend(rest);
            }
            None => {
                // Every step of a plan is applicable, so only an exhausted budget leads here.
                let Some(next) = step(task, successors, &state, path[at]) else {
                    return path;
                };
                state = next;
                at += 1;
            }
        }
        if effort::is_exhausted() {
            return path;
        }
    }
    path
}

/// Returns those of the steps that are applicable in sequence, if they reach the goal.
fn rest_without(task: &Task, successors: &Successors<'_>, state: &Bits, steps: &[u32]) -> Option<Vec<u32>> {
    let mut state = state.clone();
    let mut kept = Vec::new();
    effort::spend(1 + steps.len());
    for operator in steps {
        if let Some(next) = step(task, successors, &state, *operator) {
            state = next;
            kept.push(*operator);
        }
    }
    task.goal.holds(&|literal| state.is(literal)).then_some(kept)
}

/// Returns the state after a step; none if the step is not applicable or changes nothing.
fn step(task: &Task, successors: &Successors<'_>, state: &Bits, operator: u32) -> Option<Bits> {
    let operator = &task.operators[operator as usize];
    let applicable = operator.precondition.holds(&|literal| state.is(literal));
    applicable.then(|| successors.of(state, operator)).flatten()
}
