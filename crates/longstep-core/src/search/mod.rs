//! From a goal to a plan.
//!
//! [`solve`] grounds the domain in the world (`task`), keeps only what the goal can need (`relevance`),
//! and searches forward with an admissible heuristic (`landmark_cut`), so that the plan it finds first is a
//! shortest one. When that takes too long it goes on greedily and says so.

mod bits;
pub mod contingent;
mod dominance;
mod formula;
mod forward;
mod landmark_cut;
mod relaxed;
mod relevance;
mod scope;
mod task;

pub(crate) use formula::{Formula, Literal};
pub use forward::Limits;
pub(crate) use forward::{Found, cheapest, greedy};
pub(crate) use relevance::reduce;
pub(crate) use scope::{Asked, Scope};
pub(crate) use task::{Always, GroundCondition, GroundEffect, Grounder, Operator, Task, ground_condition, ground_step};

use crate::effort;
use crate::model::{ActionId, Domain, EntityId, Moment, World, apply, holds};

pub use crate::model::Wanted;

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

impl Outcome {
    /// Returns how many states were expanded.
    pub fn expanded(&self) -> usize {
        match self {
            Self::Solved { expanded, .. } | Self::ProvenUnsolvable { expanded } | Self::GaveUp { expanded, .. } => {
                *expanded
            }
        }
    }
}

/// The units of work of one search: grounding, leaving out what cannot matter, and all its runs.
pub const EFFORT: u64 = 60_000_000;

/// The answer when they are spent.
const TOO_MUCH: &str =
    "the conditions have too many instances in this world: the search took all the work that it may take";

/// Finds a shortest plan from the world's state to one in which everything wanted holds.
///
/// In a world that is too large to look at as a whole, only what surrounds the goal is; then no plan is called
/// shortest, and nothing is proven unsolvable.
///
/// The domain's rules for every state hold on the way. The answer is a function of the arguments: limits count
/// states, not seconds.
///
/// ```
/// use longstep_core::{domain, goal, json, search, verify, world};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let environment = world::Environment::from_json(r#"{
///     "assets": ["<table>", "<shelf>"], "asset_states": {},
///     "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#).unwrap();
/// let world = world::read(&household, &environment, "env.json", "", &json::Path::default()).unwrap();
/// let goal = goal::parse(&household, &world, "put(cup, shelf)").unwrap();
/// let outcome = search::solve(&household, &world, &goal.wanted(&household), &search::Limits::default());
/// let search::Outcome::Solved { steps, shortest, .. } = outcome else { panic!() };
/// assert!(shortest && steps.len() == 6);
/// ```
pub fn solve(domain: &Domain, world: &World, wanted: &[Wanted], limits: &Limits) -> Outcome {
    let spent = effort::within(EFFORT, || solve_within(domain, world, wanted, limits));
    match spent.exhausted {
        true => Outcome::GaveUp {
            why: TOO_MUCH.to_owned(),
            expanded: spent.result.expanded(),
        },
        false => spent.result,
    }
}

fn solve_within(domain: &Domain, world: &World, wanted: &[Wanted], limits: &Limits) -> Outcome {
    let asked = Asked::of(domain, wanted);
    let about: Vec<EntityId> = wanted
        .iter()
        .flat_map(|wanted| wanted.bindings.iter().copied())
        .collect();
    let whole = Scope::whole(domain, world, &asked);
    let around = |far: &bool| whole.around(domain, world, &asked, &about, *far);
    let scopes = match whole.is_bearable(domain) {
        true => vec![whole],
        false => [false, true]
            .iter()
            .map(around)
            .filter(|scope| scope.is_bearable(domain))
            .collect(),
    };
    let mut looked_at = 0;
    for scope in scopes {
        if effort::is_exhausted() {
            break;
        }
        let task = relevance::reduce(task::ground(domain, world, &scope, wanted));
        let outcome = forward::search(&task, limits);
        match outcome {
            outcome if scope.whole => return outcome,
            Outcome::Solved { steps, expanded, .. } if reaches(domain, world, &steps, wanted) => {
                return Outcome::Solved {
                    steps,
                    shortest: false,
                    expanded: expanded + looked_at,
                };
            }
            Outcome::Solved { expanded, .. }
            | Outcome::ProvenUnsolvable { expanded }
            | Outcome::GaveUp { expanded, .. } => looked_at += expanded,
        }
    }
    Outcome::GaveUp {
        why: "no plan found with what surrounds the goal, and the world is too large to look at all of it".to_owned(),
        expanded: looked_at,
    }
}

/// Whether the steps can be done in the whole world, and lead to what is wanted.
fn reaches(domain: &Domain, world: &World, steps: &[GroundAction], wanted: &[Wanted]) -> bool {
    let mut state = world.state.clone();
    let possible = steps.iter().all(|step| {
        let action = domain.action(step.action);
        let moment = Moment { world, state: &state };
        let possible = holds(moment, &action.precondition, &mut step.arguments.clone());
        apply(world, &mut state, action, &step.arguments);
        possible
    });
    let moment = Moment { world, state: &state };
    possible
        && wanted
            .iter()
            .all(|wanted| holds(moment, &wanted.condition, &mut wanted.bindings.clone()))
}
