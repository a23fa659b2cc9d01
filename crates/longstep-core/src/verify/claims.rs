//! What single steps say that holds after them, compared with what was simulated.

use super::{StepClaim, Violation};
use crate::model::State;

/// What a step says that does not hold in the state after it. A warning: what a plan tells of the world is evidence for
/// what it means, and no part of what it does.
pub(super) fn broken(claims: &[StepClaim], step: usize, after: &State) -> Vec<Violation> {
    of_step(claims, step)
        .filter(|claim| !after.holds(claim.fact))
        .map(|claim| Violation::StepClaim { step, fact: claim.fact })
        .collect()
}

/// What a step says, of claims that are sorted by step.
pub(super) fn of_step(claims: &[StepClaim], step: usize) -> impl Iterator<Item = &StepClaim> {
    let begin = claims.partition_point(|claim| claim.step < step);
    claims[begin..].iter().take_while(move |claim| claim.step == step)
}
