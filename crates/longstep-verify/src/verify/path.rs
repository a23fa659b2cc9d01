//! An execution path of a plan.

use super::history::Here;
use longstep_model::model::{Bindings, Number, State};

/// One execution path up to the current node.
#[derive(Debug, Clone)]
pub(super) struct ExecutionPath {
    pub(super) state: State,
    pub(super) here: Here,
    /// The `always` rules that are broken in the state, so that each violation is reported where it begins. A function
    /// of the state, so paths with equal states are equal.
    pub(super) broken: Vec<(usize, Bindings)>,
    /// The cost of the steps so far, of the dearest path to the state; none if it is not known.
    pub(super) cost: Option<Number>,
}

/// Returns the cost of the dearest of these paths; none if one of them is not known.
pub(super) fn dearest(paths: &[ExecutionPath]) -> Option<Number> {
    let costs: Option<Vec<Number>> = paths.iter().map(|path| path.cost).collect();
    costs?.into_iter().max()
}

pub(super) fn sum(one: Option<Number>, other: Option<Number>) -> Option<Number> {
    one?.plus(other?)
}

/// Returns the cost of so many periods of a loop that are not simulated.
pub(super) fn cost_of_periods(before: Option<Number>, after: Option<Number>, periods: u32) -> Option<Number> {
    let periods = Number::of_millionths(i64::from(periods).checked_mul(1_000_000)?)?;
    after?.minus(before?)?.times(periods)
}
