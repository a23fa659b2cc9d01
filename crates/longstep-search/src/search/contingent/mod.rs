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

fn too_large() -> Outcome {
    Outcome::GaveUp {
        why: "the world is too large to look at all that surrounds the goal".to_owned(),
        expanded: 0,
    }
}

/// Returns the parameters of a search for the best policy within so many states.
fn exact(limit: usize) -> Manner {
    Manner {
        limit,
        ties: TIES,
        weight: 1,
        looping: false,
        deepest: DEEPEST,
    }
}

/// The runs of one search that senses, and their totals.
struct Runs<'a> {
    world: &'a World,
    task: &'a Task,
    costs: Costs,
    limits: &'a Limits,
    /// Evaluated states.
    states: usize,
    /// True if a run exhausted its budget.
    exhausted: bool,
    /// True if the last run left out policies that cost too much.
    is_too_dear: bool,
}

fn of_task(world: &World, task: &Task, costs: Costs, limits: &Limits) -> Outcome {
    let runs = Runs {
        world,
        task,
        costs,
        limits,
        states: 0,
        exhausted: false,
        is_too_dear: false,
    };
    runs.outcome()
}

impl Runs<'_> {
    fn outcome(mut self) -> Outcome {
        if let Some(solved) = self.direct() {
            return solved;
        }
        let any = self.any();
        if let Ok(Some(solved)) = any {
            return solved;
        }
        // A longer plan than the search may find is no proof that there is none.
        let too_long = any.is_ok() && self.is_too_dear;
        if let Some(solved) = self.looping() {
            return solved;
        }
        if any.is_ok() && !too_long {
            self.unsolvable()
        } else {
            self.gave_up(too_long)
        }
    }

    /// Looks for the best policy of the focused task, and for the proof that no other one is better.
    fn direct(&mut self) -> Option<Outcome> {
        let (task, work) = (self.task, self.limits.run_for_any());
        let focused = relevance::focus(task);
        let direct = self
            .run(&focused, exact(self.limits.direct), dearest(task), work)
            .ok()??;
        // The proof search uses all operators but accepts only a better worst case.
        Some(match self.run(task, exact(self.limits.proof), direct.worst, work) {
            Ok(Some(better)) => self.solved(task, &better, true),
            Ok(None) => self.solved(&focused, &direct, true),
            Err(TooFar) => self.solved(&focused, &direct, false),
        })
    }

    /// Looks for the best policy of the task, then greedily for any; none if the last run proves that none is cheap enough.
    fn any(&mut self) -> Result<Option<Outcome>, TooFar> {
        let (task, work) = (self.task, self.limits.run_for_any());
        // The greedy runs share the states and the work of one.
        let greedy = DEPTHS.map(|deepest| Manner {
            weight: GREED,
            deepest,
            ..exact(self.limits.any / LAZY / DEPTHS.len())
        });
        let greedy = greedy.map(|manner| (manner, work / DEPTHS.len() as u64));
        for (manner, work) in std::iter::once((exact(self.limits.shortest), work)).chain(greedy) {
            if let Ok(found) = self.run(task, manner, dearest(task), work) {
                return Ok(found.map(|policy| self.solved(task, &policy, manner.weight == 1)));
            }
        }
        Err(TooFar)
    }

    /// Looks for a policy that repeats sensing until it has the desired outcome.
    fn looping(&mut self) -> Option<Outcome> {
        let (task, work) = (self.task, self.limits.run_for_any());
        // Sensing is applicable only while its outcome is unknown, so a loop needs an action that makes it unknown.
        if !forgets(task) {
            return None;
        }
        let looping = Manner {
            looping: true,
            ..exact(self.limits.shortest)
        };
        let policy = self.run(task, looping, dearest(task), work).ok()??;
        Some(self.solved(task, &policy, false))
    }

    /// Runs a search within so many units of work, and adds to the totals.
    fn run(&mut self, task: &Task, manner: Manner, below: u32, work: u64) -> Result<Option<Policy>, TooFar> {
        let spent = effort::within(work, || {
            let mut search = Search::new(task, manner);
            (search.run(below), search.looked_at(), search.is_too_dear())
        });
        let (found, looked_at, is_too_dear) = spent.result;
        self.states += looked_at;
        self.is_too_dear = is_too_dear;
        if spent.exhausted {
            self.exhausted = true;
            return Err(TooFar);
        }
        found.map(|policy| policy.map(|policy| (*policy).clone()))
    }

    fn solved(&self, task: &Task, policy: &Policy, shortest: bool) -> Outcome {
        let Some(plan) = policy::plan(self.world, task, policy) else {
            return Outcome::GaveUp {
                why: "the plan that was found branches too deep".to_owned(),
                expanded: self.states,
            };
        };
        let is_bound = shortest && !self.world.domain().has_costs();
        Outcome::Solved {
            plan,
            worst: policy.steps(),
            cost: policy.cost(self.world, task),
            at_least: if is_bound { policy.steps() } else { 0 },
            shortest: shortest && (policy.steps() as usize) < self.costs.steps,
            expanded: self.states,
        }
    }

    fn unsolvable(&self) -> Outcome {
        // If known facts can be lost again, another kind of loop may work.
        if forgets(self.task) && is_solvable_by_luck(self.task, self.limits) {
            return Outcome::GaveUp {
                why: "no plan is sure to come to an end, and no simple loop was found that does".to_owned(),
                expanded: self.states,
            };
        }
        Outcome::ProvenUnsolvable {
            when: hopeless(self.task, self.limits),
            expanded: self.states,
        }
    }

    fn gave_up(&self, too_long: bool) -> Outcome {
        let states = self.states;
        let why = if too_long {
            format!("there is no plan of up to {LONGEST} steps, and longer ones are not looked for")
        } else if self.exhausted {
            format!("no plan found in {states} states, which took all the work that a search may take")
        } else {
            format!("no plan found in {states} states")
        };
        Outcome::GaveUp { why, expanded: states }
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
    // A plan must work for every outcome, so one outcome without a plan is a reason.
    for group in bound::groups(task) {
        for fact in &group {
            let alone = bound::only(task, &group, *fact);
            if cheapest(&alone, limits.proof, None).0 == Found::Nothing {
                let mut operators = task.operators.iter();
                return operators
                    .find(|operator| bound::outcome(operator) == Some(*fact))?
                    .outcome;
            }
        }
    }
    None
}
