//! Worlds and plans for tests and benchmarks, with the feature `testing`.
//!
//! These functions panic where the library returns an error, with the findings as the message.

#![allow(clippy::panic, reason = "a test fails by a panic")]

use crate::goal;
use crate::search::{self, Limits, Outcome};
use longstep_model::model::World;
use longstep_verify::verify::{VerifiedPlan, check};

pub use longstep_model::testing::{Draws, domain, world, world_of};

/// Returns a plan for a goal, found within the default limits and verified.
///
/// ```
/// use longstep_search::testing::{plan_for, world};
/// let world = world("household", r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
///     "object_states": {"<pen>": "on_something(<desk>)"}}"#);
/// assert_eq!(plan_for(&world, "put(pen, shelf)").steps().len(), 6);
/// ```
///
/// # Panics
///
/// If the goal cannot be read in this world, or if no plan for it was found.
#[track_caller]
pub fn plan_for(world: &World, goal: &str) -> VerifiedPlan {
    let parsed = goal::parse(world, goal).unwrap_or_else(|error| panic!("{goal}: {error}"));
    let purpose = parsed.purpose(world);
    let outcome = search::solve(world, &purpose, &Limits::default());
    let Outcome::Solved { plan, .. } = outcome else {
        panic!("no plan for {goal}: {outcome:?}");
    };
    check(world, plan, &purpose)
        .into_verified()
        .unwrap_or_else(|report| panic!("{goal}: {:?}", report.violations))
}
