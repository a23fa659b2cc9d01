//! From a goal to a plan.
//!
//! [`solve`] grounds the domain in the world (`task`), keeps only what the goal can need (`relevance`),
//! and searches forward with an admissible heuristic (`landmark_cut`), so that the plan it finds first is a
//! shortest one. When that takes too long it goes on greedily and says so.

mod bits;
mod dominance;
mod formula;
mod forward;
mod landmark_cut;
mod relaxed;
mod relevance;
mod task;

pub(crate) use formula::{Formula, Literal};
pub use forward::Limits;
pub(crate) use forward::{Found, cheapest, greedy};
pub(crate) use relevance::reduce;
pub(crate) use task::{GroundCondition, GroundEffect, Grounder, Operator, Task, ground_condition};

use crate::domain::{ActionId, Condition, Domain};
use crate::world::{EntityId, World};

/// A condition to be reached, with the entities that its first slots are bound to.
#[derive(Debug, Clone)]
pub struct Wanted {
    /// The condition.
    pub condition: Condition,
    /// Slots from 0.
    pub bindings: Vec<EntityId>,
}

/// An action with all its arguments, implicit ones included.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct GroundAction {
    /// The action.
    pub action: ActionId,
    /// One entity for each parameter.
    pub arguments: Vec<EntityId>,
}

/// What a search came to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// A plan.
    Solved {
        /// Its steps; none if everything wanted holds already.
        steps: Vec<GroundAction>,
        /// Whether it is proven that no plan has fewer steps.
        shortest: bool,
        /// States expanded.
        expanded: usize,
    },
    /// There is no plan.
    ProvenUnsolvable {
        /// States expanded.
        expanded: usize,
    },
    /// There may be a plan, and it was not found within the limits.
    GaveUp {
        /// Which limit.
        why: String,
        /// States expanded.
        expanded: usize,
    },
}

/// Finds a shortest plan from the world's state to one in which everything wanted holds.
///
/// `always` must hold in every state on the way. The answer is a function of the arguments: limits count
/// states, not seconds.
///
/// ```
/// use longstep::{domain, goal, json, search, verify, world};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let environment = world::Environment::from_json(r#"{
///     "assets": ["<table>", "<shelf>"], "asset_states": {},
///     "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#).unwrap();
/// let world = world::read(&household, &environment, "env.json", "", &json::Path::default()).unwrap();
/// let goal = goal::parse(&household, &world, "put(cup, shelf)").unwrap();
/// let outcome = search::solve(&household, &world, &goal.wanted(&household, &world), &search::Limits::default());
/// let search::Outcome::Solved { steps, shortest, .. } = outcome else { panic!() };
/// assert!(shortest && steps.len() == 6);
/// ```
pub fn solve(domain: &Domain, world: &World, wanted: &[Wanted], limits: &Limits) -> Outcome {
    let task = task::ground(domain, world, wanted);
    let task = relevance::reduce(task);
    forward::search(&task, limits)
}
