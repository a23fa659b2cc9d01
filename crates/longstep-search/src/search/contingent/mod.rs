//! Contingent planning: plans with sensing.
//!
//! If a goal depends on unknown facts, [`solve`] finds a tree of steps: sensing splits the path, and each outcome has
//! its own path to the goal (AND-OR search in `and_or`, with lower bounds from `bound`). It finds a tree with the
//! shortest worst case. If no tree works because an outcome can recur, it looks for a loop that ends with another
//! outcome. The resulting policy (`policy`) is converted to a [`Plan`].

mod and_or;
mod bound;
#[cfg(test)]
mod brute_force;
#[cfg(test)]
mod forgetting_tests;
mod policy;
#[cfg(test)]
mod tests;

use self::and_or::{DEEPEST, Manner, Search, TooFar};
use self::policy::Policy;
use super::cost::{self, Costs};
use super::target::Target;
use super::task::Task;
use super::{Found, Limits, Outcome, Requirements, Scope, cheapest, forward, ground, relevance};
use longstep_model::effort;
use longstep_model::model::{EntityId, Fact, World};

/// States for fewer total steps once the worst case is known.
const TIES: usize = 150;
/// Weight of the heuristic in the greedy search.
const GREED: u32 = 5;
/// Nesting depths of sensing in the greedy search, one after the other. Where acting makes an outcome unknown again, a greedy
/// search would look and act again and again, and never come back to the steps that it needs in between. Plans that look less
/// often are the better ones, too.
const DEPTHS: [usize; 5] = [2, 3, 4, 8, DEEPEST];
/// Maximum length of a plan.
const LONGEST: u32 = 1_000;

/// Parts of the limit on any plan: AND-OR search evaluates a state by landmark cuts, which takes longer.
const LAZY: usize = 10;

/// Returns a bound on the cost of a plan.
fn dearest(task: &Task) -> u32 {
    let costs = task.operators.iter().map(|operator| operator.cost);
    costs.max().unwrap_or(1).max(1).saturating_mul(LONGEST)
}

/// Finds a plan with the shortest worst case that achieves all wanted conditions for every sensing outcome. It does not
/// sense facts that are known or that the goal does not need.
///
/// Among plans with equal worst case, prefers fewer total steps, then earlier sensing. Each branch minimizes its own
/// worst case first, so with nested branches a plan with fewer total steps may exist. The result is a deterministic
/// function of the arguments: limits count states.
pub(super) fn solve(world: &World, target: &Target, limits: &Limits) -> Outcome {
    let spent = effort::within(limits.effort.units(), || solve_within(world, target, limits));
    match (spent.exhausted, spent.result) {
        (false, outcome) => outcome,
        (true, outcome) => Outcome::GaveUp {
            why: super::TOO_MUCH.to_owned(),
            expanded: outcome.expanded(),
        },
    }
}

fn solve_within(world: &World, target: &Target, limits: &Limits) -> Outcome {
    let requirements = Requirements::of(world, &target.wanted, &target.stages);
    let about: Vec<EntityId> = target.about().collect();
    let whole = Scope::whole(world, &requirements);
    let scope = if whole.is_bearable(world) {
        Some(whole)
    } else {
        // In a large world, only entities related to the goal; verification then checks the plan in the whole world.
        // The wider surroundings if they are bearable, since there is one search only.
        [false, true]
            .iter()
            .map(|far| whole.around(world, &requirements, &about, *far))
            .rfind(|scope| scope.is_bearable(world))
    };
    let too_large = || Outcome::GaveUp {
        why: "the world is too large to look at all that surrounds the goal".to_owned(),
        expanded: 0,
    };
    let Some(scope) = scope else { return too_large() };
    let mut task = relevance::reduce(ground::ground_sensing(world, &scope, target));
    let costs = match cost::price(world, &mut task) {
        Ok(costs) => costs,
        Err(why) => return Outcome::GaveUp { why, expanded: 0 },
    };
    // Relevance analysis removes sensing that is known or irrelevant. Without sensing, forward search is enough.
    let outcome = if task.operators.iter().any(|operator| operator.outcome.is_some()) {
        of_task(world, &task, costs, limits)
    } else {
        forward::search(&task, limits).priced(costs).explained(world)
    };
    match outcome {
        Outcome::Solved {
            plan,
            worst,
            cost,
            expanded,
            ..
        } if !scope.whole => Outcome::Solved {
            plan,
            worst,
            cost,
            shortest: false,
            at_least: 0,
            expanded,
        },
        Outcome::ProvenUnsolvable { .. } if !scope.whole => too_large(),
        outcome => outcome,
    }
}

/// Totals of several runs.
#[derive(Default)]
struct Tally {
    /// Evaluated states.
    states: usize,
    /// True if a run exhausted its budget.
    exhausted: bool,
    /// True if the last run left out policies that cost too much.
    is_too_dear: bool,
}

/// Runs a search within so many units of work, and adds to the tally.
fn run(task: &Task, manner: Manner, below: u32, work: u64, tally: &mut Tally) -> Result<Option<Policy>, TooFar> {
    let spent = effort::within(work, || {
        let mut search = Search::new(task, manner);
        (search.run(below), search.looked_at(), search.is_too_dear())
    });
    let (found, looked_at, is_too_dear) = spent.result;
    tally.states += looked_at;
    tally.is_too_dear = is_too_dear;
    if spent.exhausted {
        tally.exhausted = true;
        return Err(TooFar);
    }
    found.map(|policy| policy.map(|policy| (*policy).clone()))
}

fn of_task(world: &World, task: &Task, costs: Costs, limits: &Limits) -> Outcome {
    let manner = |limit: usize| Manner {
        limit,
        ties: TIES,
        weight: 1,
        looping: false,
        deepest: DEEPEST,
    };
    let work = limits.run_for_any();
    let mut tally = Tally::default();
    let solved = |task: &Task, policy: &Policy, shortest: bool, expanded: usize| {
        let plan = policy::plan(world, task, policy);
        plan.map_or_else(
            || Outcome::GaveUp {
                why: "the plan that was found branches too deep".to_owned(),
                expanded,
            },
            |plan| Outcome::Solved {
                plan,
                worst: policy.steps(),
                cost: policy.cost(world, task),
                at_least: if shortest && !world.domain().has_costs() {
                    policy.steps()
                } else {
                    0
                },
                shortest: shortest && (policy.steps() as usize) < costs.steps,
                expanded,
            },
        )
    };
    let focused = relevance::focus(task);
    if let Ok(Some(direct)) = run(&focused, manner(limits.direct), dearest(task), work, &mut tally) {
        // The proof search uses all operators but accepts only a better worst case.
        let found = run(task, manner(limits.proof), direct.worst, work, &mut tally);
        return match found {
            Ok(Some(better)) => solved(task, &better, true, tally.states),
            Ok(None) => solved(&focused, &direct, true, tally.states),
            Err(TooFar) => solved(&focused, &direct, false, tally.states),
        };
    }
    let (mut proven, mut too_long) = (false, false);
    // The greedy runs share the states and the work of one.
    let greedy = DEPTHS.map(|deepest| Manner {
        weight: GREED,
        deepest,
        ..manner(limits.any / LAZY / DEPTHS.len())
    });
    let greedy = greedy.map(|manner| (manner, work / DEPTHS.len() as u64));
    for (manner, work) in std::iter::once((manner(limits.shortest), work)).chain(greedy) {
        match run(task, manner, dearest(task), work, &mut tally) {
            Ok(Some(policy)) => return solved(task, &policy, manner.weight == 1, tally.states),
            Ok(None) => {
                // A longer plan than the search may find is no proof that there is none.
                too_long = tally.is_too_dear;
                proven = !too_long;
                break;
            }
            Err(TooFar) => {}
        }
    }
    let looping = Manner {
        looping: true,
        ..manner(limits.shortest)
    };
    // Sensing is applicable only while its outcome is unknown, so a loop needs an action that makes it unknown.
    if forgets(task)
        && let Ok(Some(policy)) = run(task, looping, dearest(task), work, &mut tally)
    {
        return solved(task, &policy, false, tally.states);
    }
    match proven {
        // If known facts can be lost again, another kind of loop may work.
        true if forgets(task) && is_solvable_by_luck(task, limits) => Outcome::GaveUp {
            why: "no plan is sure to come to an end, and no simple loop was found that does".to_owned(),
            expanded: tally.states,
        },
        true => Outcome::ProvenUnsolvable {
            when: hopeless(task, limits),
            expanded: tally.states,
        },
        false => Outcome::GaveUp {
            why: if too_long {
                format!("there is no plan of up to {LONGEST} steps, and longer ones are not looked for")
            } else if tally.exhausted {
                format!(
                    "no plan found in {} states, which took all the work that a search may take",
                    tally.states
                )
            } else {
                format!("no plan found in {} states", tally.states)
            },
            expanded: tally.states,
        },
    }
}

/// Returns true if some operator deletes a sensed fact.
fn forgets(task: &Task) -> bool {
    let sensed: Vec<u32> = bound::groups(task).concat();
    let mut effects = task.operators.iter().flat_map(|operator| &operator.effects);
    effects.any(|effect| !effect.literal.holds && sensed.contains(&effect.literal.fact))
}

/// Returns false if there is no plan even with the best sensing outcomes.
fn is_solvable_by_luck(task: &Task, limits: &Limits) -> bool {
    !matches!(cheapest(task, limits.shortest, None).0, Found::Nothing)
}

/// Returns a sensing outcome after which there is no plan, if there are plans with other outcomes.
fn hopeless(task: &Task, limits: &Limits) -> Option<Fact> {
    if !is_solvable_by_luck(task, limits) {
        return None;
    }
    let outcome_of = |fact: u32| {
        let mut operators = task.operators.iter();
        operators
            .find(|operator| bound::outcome(operator) == Some(fact))?
            .outcome
    };
    // A plan must work for every outcome, so one outcome without a plan is a reason.
    for group in bound::groups(task) {
        for fact in &group {
            let alone = bound::only(task, &group, *fact);
            if cheapest(&alone, limits.proof, None).0 == Found::Nothing {
                return outcome_of(*fact);
            }
        }
    }
    None
}
