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
