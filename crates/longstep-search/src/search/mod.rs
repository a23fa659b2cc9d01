//! Search for plans.
//!
//! [`solve`] grounds the domain in the world (`task`), removes what the goal cannot need (`relevance`), and runs A*
//! with an admissible heuristic (`landmark_cut`), so that the first plan it finds is a shortest one. If that reaches a
//! limit, greedy search follows, and the result is marked as not proven shortest.

mod additive;
mod applicable;
mod bits;
mod contingent;
mod cost;
mod dominance;
mod formula;
mod forward;
mod greedy;
mod ground;
mod grounder;
mod improve;
mod landmark_cut;
mod limits;
mod node;
mod numbers;
#[cfg(test)]
mod numbers_tests;
mod operator;
mod outcome;
mod relaxed;
mod relevance;
#[cfg(test)]
mod relevance_tests;
mod scope;
#[cfg(test)]
mod scope_tests;
mod stages;
mod successor;
mod target;
mod task;
#[cfg(test)]
mod tests;
mod why_not;

pub(crate) use formula::{Formula, Literal};
use forward::Straight;
pub(crate) use forward::{Found, cheapest, greedy};
pub(crate) use ground::{GroundCondition, ground_condition, ground_step};
pub(crate) use grounder::{Grounder, Meaning};
pub use limits::{EFFORT, Effort, EffortError, Limits};
pub(crate) use operator::{GroundEffect, GroundNumericEffect, Operator};
pub use outcome::Outcome;
pub(crate) use relevance::reduce;
pub(crate) use scope::{Requirements, Scope};
pub(crate) use task::{Always, Task};
pub use why_not::{Missing, WhyNot, why_not};

use longstep_model::effort;
use longstep_model::model::{ActionId, EntityId, Fact, World};
use longstep_verify::plan::{Plan, Step};
use longstep_verify::verify::{self, Purpose};
use target::Target;

pub use longstep_model::model::Wanted;

/// An action with all its arguments, including implicit ones.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct GroundAction {
    /// The action.
    pub action: ActionId,
    /// One entity for each parameter.
    pub arguments: Vec<EntityId>,
}

/// Reason given when the budget is exhausted.
const TOO_MUCH: &str =
    "the conditions have too many instances in this world: the search took all the work that it may take";

/// Finds a shortest plan from the world's state that serves a purpose: it achieves the stages in order, and ends in a
/// state in which the wanted conditions and the domain's rules hold. The plan contains sensing if the conditions depend
/// on sensing outcomes, or if there is no plan without it.
///
/// In a world that is too large to ground completely, only entities related to the goal are considered. Then no plan is
/// marked as shortest, and unsolvability is not proven.
///
/// Plans keep the domain's `always` rules and the prohibitions in force. The result is a deterministic function of the arguments: limits count
/// states, not seconds.
///
/// ```
/// use longstep_model::{domain, json, environment};
/// use longstep_search::{goal, search};
/// use longstep_verify::verify;
/// let household = domain::shipped("household").unwrap().unwrap();
/// let environment = environment::Environment::from_json(r#"{
///     "assets": ["<table>", "<shelf>"], "asset_states": {},
///     "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#).unwrap();
/// let world = environment::read(&household, &environment, "env.json", "", &json::Path::default()).unwrap();
/// let goal = goal::parse(&world, "put(cup, shelf)").unwrap();
/// let outcome = search::solve(&world, &goal.purpose(&world), &search::Limits::default());
/// let search::Outcome::Solved { plan, shortest, .. } = outcome else { panic!() };
/// assert!(shortest && plan.steps().len() == 6);
/// ```
pub fn solve(world: &World, purpose: &Purpose, limits: &Limits) -> Outcome {
    let domain = world.domain();
    let (world, target) = (&*purpose.world(world), Target::of(domain, purpose));
    let mut atoms = target.all().flat_map(|wanted| wanted.condition.atoms());
    // An unknown outcome is absent from the state. Without sensing operators the search would take it for false.
    if atoms.any(|(atom, _)| domain.is_sensed(atom.predicate)) {
        return contingent::solve(world, &target, limits);
    }
    let senses = || domain.actions.iter().any(|action| !action.senses.is_empty());
    match straight(world, &target, limits) {
        // The proof covers plans without sensing only, and an action may require a fact that sensing reveals.
        Straight::ProvenUnsolvable { .. } if senses() => contingent::solve(world, &target, limits),
        found => found.explained(world),
    }
}

/// Grounds the whole task of a purpose without sensing, and returns it with its facts by number; none for facts that
/// record progress.
pub(crate) fn ground_task(world: &World, purpose: &Purpose) -> (Task, Vec<Option<Fact>>) {
    let target = Target::of(world.domain(), purpose);
    let scope = Scope::whole(world, &Requirements::of(world, &target.wanted, &target.stages));
    ground::ground_with_facts(world, &scope, &target)
}

/// Finds a shortest plan without sensing.
fn straight(world: &World, target: &Target, limits: &Limits) -> Straight {
    let spent = effort::within(limits.effort.units(), || straight_within(world, target, limits));
    // No result of an exhausted budget is used. A reserve in `forward` keeps a plan from being lost here.
    if spent.exhausted {
        Straight::GaveUp {
            why: TOO_MUCH.to_owned(),
            expanded: spent.result.expanded(),
        }
    } else {
        spent.result
    }
}

fn straight_within(world: &World, target: &Target, limits: &Limits) -> Straight {
    let requirements = Requirements::of(world, &target.wanted, &target.stages);
    let about: Vec<EntityId> = target.about().collect();
    let whole = Scope::whole(world, &requirements);
    let around = |far: &bool| whole.around(world, &requirements, &about, *far);
    // Grounding takes time quadratic in the number of entities, so a large world begins with the nearest ones.
    let scopes = if whole.is_bearable(world) {
        vec![whole]
    } else {
        [false, true]
            .iter()
            .map(around)
            .filter(|scope| scope.is_bearable(world))
            .collect()
    };
    let mut looked_at = 0;
    for scope in scopes {
        if effort::is_exhausted() {
            break;
        }
        let mut task = relevance::reduce(ground::ground(world, &scope, target));
        let costs = match cost::price(world, &mut task) {
            Ok(costs) => costs,
            Err(why) => {
                return Straight::GaveUp {
                    why,
                    expanded: looked_at,
                };
            }
        };
        let outcome = forward::search(&task, limits).priced(costs);
        match outcome {
            outcome if scope.whole => return outcome,
            // A cheaper plan may use entities out of scope, so nothing is proven about the cost.
            Straight::Solved { steps, expanded, .. } if serves(world, &steps, target) => {
                return Straight::Solved {
                    steps,
                    shortest: false,
                    at_least: 0,
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

/// Returns true if the steps are a valid plan in the whole world, where quantified conditions range over more entities, and rules and
/// prohibitions are about more of them, than in the scope of the search.
fn serves(world: &World, steps: &[GroundAction], target: &Target) -> bool {
    let steps = steps.iter();
    let plan: Plan = steps
        .map(|step| Step::explained(world, step.action, step.arguments.clone()))
        .collect();
    let purpose = Purpose {
        wanted: target.wanted.clone(),
        stages: target.stages.clone(),
        ..Purpose::default()
    };
    verify::check(world, plan, &purpose).violations.is_empty()
}
