//! Scheduling for several actors (hands, arms or robots): parallel lanes, makespan, and assignment of steps.
//!
//! Search returns a list of steps, each by one actor or by several together. [`compact`] turns such a list into
//! parallel lanes with the same final state, [`spread`] first assigns steps to other actors where that shortens the
//! makespan, and [`makespan`] computes the duration of any plan. Every result is verified like any other plan, in all
//! interleavings of the lanes.

mod compact;
mod footprint;
mod makespan;
mod spread;
#[cfg(test)]
mod tests;

pub use compact::{Compacted, compact};
pub use footprint::independent;
pub use makespan::{Makespan, Row, makespan, timetable};
pub use spread::{share, spread};

use longstep_model::model::{Domain, EntityId};
use longstep_verify::plan::Step;

/// Returns the actors of the steps, each once, sorted.
fn actors(domain: &Domain, steps: &[Step]) -> Vec<EntityId> {
    let mut actors: Vec<EntityId> = steps.iter().filter_map(|step| step.actor(domain)).collect();
    actors.sort_unstable();
    actors.dedup();
    actors
}
