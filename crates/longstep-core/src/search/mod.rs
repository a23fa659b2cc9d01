//! From a goal to a plan.
//!
//! [`solve`] grounds the domain in the world (`task`), keeps only what the goal can need (`relevance`),
//! and searches forward with an admissible heuristic (`landmark_cut`), so that the plan it finds first is a
//! shortest one. When that takes too long it goes on greedily and says so.

mod bits;
mod contingent;
mod dominance;
mod formula;
mod forward;
mod landmark_cut;
mod outcome;
mod relaxed;
mod relevance;
mod scope;
mod task;

pub(crate) use formula::{Formula, Literal};
pub use forward::Limits;
use forward::Straight;
pub(crate) use forward::{Found, cheapest, greedy};
pub use outcome::Outcome;
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

/// The units of work of one search: grounding, leaving out what cannot matter, and all its runs.
pub const EFFORT: u64 = 50_000_000;

/// The answer when they are spent.
const TOO_MUCH: &str =
    "the conditions have too many instances in this world: the search took all the work that it may take";

/// Finds a shortest plan from the world's state to one in which everything wanted holds: one that looks before it decides
/// where what is wanted depends on what sensing tells, or where there is no other.
///
/// In a world that is too large to look at as a whole, only what surrounds the goal is; then no plan is called
/// shortest, and nothing is proven unsolvable.
///
/// The domain's rules for every state hold on the way. The answer is a function of the arguments: limits count
/// states, not seconds.
///
/// ```
/// use longstep_core::{domain, goal, json, search, verify, environment};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let environment = environment::Environment::from_json(r#"{
///     "assets": ["<table>", "<shelf>"], "asset_states": {},
///     "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#).unwrap();
/// let world = environment::read(&household, &environment, "env.json", "", &json::Path::default()).unwrap();
/// let goal = goal::parse(&household, &world, "put(cup, shelf)").unwrap();
/// let outcome = search::solve(&household, &world, &goal.wanted(&household), &search::Limits::default());
/// let search::Outcome::Solved { plan, shortest, .. } = outcome else { panic!() };
/// assert!(shortest && plan.steps().len() == 6);
/// ```
pub fn solve(domain: &Domain, world: &World, wanted: &[Wanted], limits: &Limits) -> Outcome {
    let mut sensed = false;
    for wanted in wanted {
        wanted
            .condition
            .for_each_atom(&mut |atom, _| sensed |= domain.is_sensed(atom.predicate));
    }
    if sensed {
        return contingent::solve(domain, world, wanted, limits);
    }
    let senses = || domain.actions.iter().any(|action| !action.senses.is_empty());
    match straight(domain, world, wanted, limits) {
        Straight::ProvenUnsolvable { .. } if senses() => contingent::solve(domain, world, wanted, limits),
        found => found.explained(domain, world),
    }
}

/// Finds a shortest plan that senses nothing.
fn straight(domain: &Domain, world: &World, wanted: &[Wanted], limits: &Limits) -> Straight {
    let spent = effort::within(EFFORT, || straight_within(domain, world, wanted, limits));
    match spent.exhausted {
        true => Straight::GaveUp {
            why: TOO_MUCH.to_owned(),
            expanded: spent.result.expanded(),
        },
        false => spent.result,
    }
}

fn straight_within(domain: &Domain, world: &World, wanted: &[Wanted], limits: &Limits) -> Straight {
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
            Straight::Solved { steps, expanded, .. } if reaches(domain, world, &steps, wanted) => {
                return Straight::Solved {
                    steps,
                    shortest: false,
                    expanded: expanded + looked_at,
                };
            }
            Straight::Solved { expanded, .. }
            | Straight::ProvenUnsolvable { expanded }
            | Straight::GaveUp { expanded, .. } => looked_at += expanded,
        }
    }
    Straight::GaveUp {
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
