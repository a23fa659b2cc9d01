//! An execution path of a plan.

use super::history::Here;
use longstep_model::model::{Bindings, State};

/// One execution path up to the current node.
#[derive(Debug, Clone)]
pub(super) struct Way {
    pub(super) state: State,
    pub(super) here: Here,
    /// The `always` rules that are broken in the state, so that each violation is reported where it begins. A function
    /// of the state, so paths with equal states are equal.
    pub(super) broken: Vec<(usize, Bindings)>,
}
