//! Comparison of step claims with the simulated states.

use super::{StepClaim, Violation};
use longstep_model::model::State;

/// Returns the claims of a step that do not hold in the state after it. They are warnings: claims show the intention of
/// a plan and have no effect in the simulation.
pub(super) fn broken(claims: &[StepClaim], step: usize, after: &State) -> Vec<Violation> {
    of_step(claims, step)
        .filter(|claim| !after.holds(claim.fact))
        .map(|claim| Violation::StepClaim { step, fact: claim.fact })
        .collect()
}

/// Returns the claims of a step; `claims` is sorted by step.
pub(super) fn of_step(claims: &[StepClaim], step: usize) -> impl Iterator<Item = &StepClaim> {
    let begin = claims.partition_point(|claim| claim.step < step);
    claims[begin..].iter().take_while(move |claim| claim.step == step)
}
