//! Several hands, arms or robots: what they can do at the same time, how long a plan takes, and who does what.
//!
//! A plan that search found is a list of steps, each by one actor or by several at once. [`compact`] turns such a list
//! into lanes that run side by side and come to the same, [`spread`] first gives work to whoever makes that shorter,
//! and [`makespan`] counts the time of any plan. Nothing here is trusted: what comes out is verified like any other
//! plan, in every order in which the lanes' steps can happen.

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

use crate::model::Domain;
use crate::model::EntityId;
use crate::plan::Step;

/// The actors of steps, each once, in order.
fn actors(domain: &Domain, steps: &[Step]) -> Vec<EntityId> {
    let mut actors: Vec<EntityId> = steps.iter().filter_map(|step| step.actor(domain)).collect();
    actors.sort_unstable();
    actors.dedup();
    actors
}
