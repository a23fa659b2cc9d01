//! Forward search: A* for a shortest plan; if it reaches its limit, greedy search for any plan, and its improvement.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rustc_hash::FxHashMap;

use super::bits::Bits;
use super::cost::{self, Costs};
use super::dominance::Dominance;
use super::greedy::{Lazy, Rank};
use super::improve::{self, improve};
use super::landmark_cut::LandmarkCut;
use super::node::{SearchNode, path, start};
use super::successor::Successors;
use super::task::Task;
use super::{GroundAction, Limits, Outcome, relevance};
use longstep_model::effort;
use longstep_model::model::World;
use longstep_verify::plan::Step;

/// Weight of the heuristic in the greedy search.
// Weighted A* (Pohl, 1970): with a lower bound as the estimate, a plan costs at most this times the least cost.
const GREED: u32 = 5;

/// Work units of one run for another part of the library.
// As much as one run for a shortest plan gets at normal effort.
const EFFORT: u64 = 8_000_000;

/// Result of a search without sensing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Straight {
    /// A plan.
    Solved {
        /// The steps; empty if the goal already holds.
        steps: Vec<GroundAction>,
        /// True if it is proven that no plan costs less.
        shortest: bool,
        /// Proven lower bound on the cost of a plan.
        at_least: u32,
        /// States expanded.
        expanded: usize,
    },
    /// There is no plan.
    ProvenUnsolvable {
        /// States expanded.
        expanded: usize,
    },
    /// No plan was found within the limits; one may exist.
    GaveUp {
        /// The limit that was reached.
        why: String,
        /// States expanded.
        expanded: usize,
    },
}

impl Straight {
    /// Converts the result; the steps get the domain's explanations.
    pub(super) fn explained(self, world: &World) -> Outcome {
        match self {
            Self::Solved {
                steps,
                shortest,
                at_least,
                expanded,
            } => Outcome::Solved {
                worst: steps.len() as u32,
                // The bound of a domain with costs is a cost, and this one counts steps.
                at_least: if world.domain().has_costs() { 0 } else { at_least },
                cost: cost::total(world, &steps),
                plan: steps
                    .into_iter()
                    .map(|step| Step::explained(world, step.action, step.arguments))
                    .collect(),
                shortest,
                expanded,
            },
            Self::ProvenUnsolvable { expanded } => Outcome::ProvenUnsolvable { when: None, expanded },
            Self::GaveUp { why, expanded } => Outcome::GaveUp { why, expanded },
        }
    }

    /// Returns the result for a task with these costs: a plan that is too long for them is not proven cheapest.
    pub(super) fn priced(mut self, costs: Costs) -> Self {
        if let Self::Solved { steps, shortest, .. } = &mut self {
            *shortest &= steps.len() < costs.steps;
        }
        self
    }

    /// Returns the number of expanded states.
    pub(super) fn expanded(&self) -> usize {
        match self {
            Self::Solved { expanded, .. } | Self::ProvenUnsolvable { expanded } | Self::GaveUp { expanded, .. } => {
                *expanded
            }
        }
    }
}

/// Finds a plan in runs that give up less and less: a shortest plan of the focused task; if that reaches a limit, any plan
/// of it, and then any plan of the whole task, each improved.
pub(super) fn search(task: &Task, limits: &Limits) -> Straight {
    // The most direct plans nearly always contain a shortest one, and their task is much smaller.
    let focused = relevance::focus(task);
    let mut runs = Runs {
        task,
        limits,
        expanded: 0,
        exhausted: false,
    };
    let mut heuristic = LandmarkCut::new(&focused);
    let direct = runs.run(limits.run_for_shortest(), || {
        Search::new(&focused, &mut heuristic, 1, limits.direct).run()
    });
    let direct_is_unsolvable = match direct {
        Found::Path(path) => return runs.proven(&focused, &path),
        // The focused task loses plans, so this proves nothing about the whole one.
        Found::Nothing => true,
        Found::Limit => false,
    };
    // Greedy search in the focused task would find nothing either.
    if direct_is_unsolvable && let Some(result) = runs.shortest() {
        return result;
    }
    if !direct_is_unsolvable && let Some(result) = runs.any(&focused) {
        return result;
    }
    if let Some(result) = runs.any(task) {
        return result;
    }
    // A* has failed on the smaller task, so it comes last on the whole one. It may still prove that there is no plan.
    if !direct_is_unsolvable && let Some(result) = runs.shortest() {
        return result;
    }
    let expanded = runs.expanded;
    Straight::GaveUp {
        why: if runs.exhausted {
            format!("no plan found in {expanded} states, which took all the work that a search may take")
        } else {
            format!("no plan found in {expanded} states")
        },
        expanded,
    }
}

/// The runs of one search, and their sums.
struct Runs<'a> {
    task: &'a Task,
    limits: &'a Limits,
    expanded: usize,
    /// True if a run exhausted its budget.
    exhausted: bool,
}

impl Runs<'_> {
    fn run<T>(&mut self, units: u64, search: impl FnOnce() -> (T, usize)) -> T {
        let spent = effort::within(units, search);
        self.exhausted |= spent.exhausted;
        self.expanded += spent.result.1;
        spent.result.0
    }

    fn solved(&self, task: &Task, path: &[u32], at_least: u32) -> Straight {
        Straight::Solved {
            steps: steps(task, path),
            shortest: at_least >= improve::cost(task, path),
            at_least,
            expanded: self.expanded,
        }
    }

    /// Looks for a plan of the whole task that is cheaper than a path of `from`, and for the proof that there is none.
    fn proven(&mut self, from: &Task, path: &[u32]) -> Straight {
        let (task, cost, limit) = (self.task, improve::cost(from, path), self.limits.proof);
        let (found, bound) = self.run(spare(self.limits.run_for_shortest()), || {
            let mut heuristic = LandmarkCut::new(task);
            let mut proof = Search::new(task, &mut heuristic, 1, limit);
            proof.below = Some(cost);
            // Only a cheaper plan matters here, so it need not be the most natural one of its cost.
            proof.dominance = Some(Dominance::new(task));
            let (found, expanded) = proof.run();
            ((found, proof.bound), expanded)
        });
        match found {
            Found::Path(cheaper) => self.solved(task, &cheaper, improve::cost(task, &cheaper)),
            Found::Nothing => self.solved(from, path, cost),
            // A run that is cut short is no proof, so its bound stays below the cost of the plan.
            Found::Limit => self.solved(from, path, bound.min(cost.saturating_sub(1))),
        }
    }

    /// Looks for a shortest plan of the whole task; none if that reaches a limit.
    fn shortest(&mut self) -> Option<Straight> {
        let task = self.task;
        let mut heuristic = LandmarkCut::new(task);
        let mut search = Search::new(task, &mut heuristic, 1, self.limits.shortest);
        search.dominance = Some(Dominance::new(task));
        match self.run(self.limits.run_for_shortest(), || search.run()) {
            Found::Path(path) => Some(self.solved(task, &path, improve::cost(task, &path))),
            Found::Nothing => Some(self.unsolvable()),
            Found::Limit => None,
        }
    }

    /// Looks for any plan of a task, and improves it; none if that reaches a limit, or if only the whole task may have one.
    fn any(&mut self, task: &Task) -> Option<Straight> {
        let is_whole = std::ptr::eq(task, self.task);
        let mut lazy = Lazy::new(task);
        match self.run(self.limits.run_for_any(), || {
            lazy.run(Rank::Estimate, None, self.limits.any)
        }) {
            Found::Path(path) => {
                let limit = self.limits.any;
                let units = spare(self.limits.run_for_any());
                let (path, proven) = self.run(units, || improve(&mut lazy, task, path, limit));
                // A proof about the focused task says nothing about plans with other operators.
                if proven && is_whole {
                    return Some(self.solved(task, &path, improve::cost(task, &path)));
                }
                Some(self.proven(task, &path))
            }
            Found::Nothing if is_whole => Some(self.unsolvable()),
            Found::Nothing | Found::Limit => None,
        }
    }

    fn unsolvable(&self) -> Straight {
        Straight::ProvenUnsolvable {
            expanded: self.expanded,
        }
    }
}

/// Returns the units for a run that a plan does not need: the search must not exhaust its budget once it has a plan.
fn spare(units: u64) -> u64 {
    units.min(effort::left() / 2)
}

fn steps(task: &Task, path: &[u32]) -> Vec<GroundAction> {
    let step = |number: &u32| task.operators[*number as usize].step.clone();
    path.iter().map(step).collect()
}

/// Finds the cheapest path to the goal, as operator numbers, and returns it with the number of expanded states. Accepts
/// only costs less than `below`, if given.
pub(crate) fn cheapest(task: &Task, limit: usize, below: Option<u32>) -> (Found<Vec<u32>>, usize) {
    let mut heuristic = LandmarkCut::new(task);
    let mut search = Search::new(task, &mut heuristic, 1, limit);
    search.below = below;
    // Without a bound this plan is shown, and dominance may replace it by a less natural one of equal cost.
    if below.is_some() {
        search.dominance = Some(Dominance::new(task));
    }
    effort::within(EFFORT, || search.run()).result
}

/// Finds a path to the goal quickly, not necessarily a cheap one.
pub(crate) fn greedy(task: &Task, limit: usize) -> (Found<Vec<u32>>, usize) {
    let mut heuristic = LandmarkCut::new(task);
    let mut search = Search::new(task, &mut heuristic, GREED, limit);
    effort::within(EFFORT, || search.run()).result
}

/// Result of one search run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Found<P> {
    /// The operators to apply.
    Path(P),
    /// There is no path to the goal within the cost bound.
    Nothing,
    /// The limit was reached first.
    Limit,
}

/// Priority of a node in the open list: f-value, then heuristic value, then preferred operators, then order of discovery.
// Among equal f-values the smallest estimate goes first, so A* seldom expands the whole last layer.
type Priority = Reverse<(u32, u32, bool, u32)>;

struct Search<'a> {
    task: &'a Task,
    successors: Successors<'a>,
    heuristic: &'a mut LandmarkCut,
    weight: u32,
    limit: usize,
    /// Upper bound: only plans of lower cost are accepted.
    below: Option<u32>,
    /// Prunes dominated states.
    dominance: Option<Dominance>,
    /// True if some operators cost nothing.
    free_first: bool,
    nodes: Vec<SearchNode>,
    known: FxHashMap<Bits, u32>,
    open: BinaryHeap<Priority>,
    /// Preferred operators of each evaluated node until its expansion.
    preferred: FxHashMap<u32, Vec<u32>>,
    /// Work units to expand a node, without its successors.
    expanding: usize,
    /// The largest f-value so far; without a weight no plan costs less.
    bound: u32,
}

impl<'a> Search<'a> {
    fn new(task: &'a Task, heuristic: &'a mut LandmarkCut, weight: u32, limit: usize) -> Self {
        Self {
            task,
            successors: Successors::new(task),
            heuristic,
            weight,
            limit,
            below: None,
            dominance: None,
            free_first: task.steps().any(|(_, operator)| operator.cost == 0),
            nodes: Vec::new(),
            known: FxHashMap::default(),
            open: BinaryHeap::new(),
            preferred: FxHashMap::default(),
            expanding: task.units(),
            bound: 0,
        }
    }

    /// Searches until a plan is found, no node is left, or the limit or the budget is reached.
    fn run(&mut self) -> (Found<Vec<u32>>, usize) {
        let (mut expanded, mut estimated) = (0, 0);
        self.discover(start(self.task), None, 0, 0, false);
        while let Some(Reverse((promise, _, _, number))) = self.open.pop() {
            if !effort::spend(1) {
                return (Found::Limit, expanded);
            }
            let node = &self.nodes[number as usize];
            // The heap has no decrease-key: an entry is stale once its node is expanded or has a cheaper path.
            if node.expanded || promise > self.promise(node) {
                continue;
            }
            // Some node on a cheapest path is always open, so the least f-value in the open list is a lower bound.
            self.bound = self.bound.max(promise);
            if self.below.is_some_and(|below| promise >= below) {
                // No open node has a lower f-value.
                return (Found::Nothing, expanded);
            }
            if self.task.goal.holds(&|literal| node.state.is(literal)) {
                return (Found::Path(path(&self.nodes, number)), expanded);
            }
            // Lazy evaluation: many nodes are never taken, and landmark cuts are the costly part of a node.
            if !node.estimated {
                if estimated == self.limit {
                    return (Found::Limit, expanded);
                }
                estimated += 1;
                let estimate = self.heuristic.estimate(|fact| node.state.holds(fact));
                let Some(cost) = estimate.cost else {
                    // A dead end: the goal is unreachable from here.
                    self.nodes[number as usize].expanded = true;
                    continue;
                };
                self.preferred.insert(number, estimate.preferred);
                let node = &mut self.nodes[number as usize];
                node.estimated = true;
                node.estimate = node.estimate.max(cost);
                let later = self.promise(&self.nodes[number as usize]);
                // With the larger f-value another node may come first.
                if later > promise {
                    self.open.push(self.priority(number, false));
                    continue;
                }
            }
            expanded += 1;
            self.expand(number);
        }
        // Successors are missing for lack of budget, so the empty open list proves nothing.
        if effort::is_exhausted() {
            return (Found::Limit, expanded);
        }
        (Found::Nothing, expanded)
    }

    fn promise(&self, node: &SearchNode) -> u32 {
        node.depth.saturating_add(self.weight.saturating_mul(node.estimate))
    }

    fn priority(&self, number: u32, preferred: bool) -> Priority {
        let node = &self.nodes[number as usize];
        let closeness = match node.parent {
            // Zero-cost operators come before others with equal f-value.
            Some((_, operator)) if self.free_first && !node.estimated => {
                node.estimate + self.task.operators[operator as usize].cost
            }
            _ => node.estimate,
        };
        Reverse((self.promise(node), closeness, !preferred, number))
    }

    fn expand(&mut self, number: u32) {
        let task = self.task;
        self.nodes[number as usize].expanded = true;
        let preferred = self.preferred.remove(&number).unwrap_or_default();
        effort::spend(self.expanding);
        for (index, operator) in task.steps() {
            let node = &self.nodes[number as usize];
            if !operator.precondition.holds(&|literal| node.state.is(literal)) {
                continue;
            }
            let Some(next) = self.successors.of(&node.state, operator) else {
                if effort::is_exhausted() {
                    return;
                }
                continue;
            };
            // Pathmax (Méro, 1984): a bound of the parent, less the cost of the step, bounds the successor too.
            let (depth, estimate) = (node.depth + operator.cost, node.estimate.saturating_sub(operator.cost));
            let is_preferred = preferred.binary_search(&(index as u32)).is_ok();
            self.discover(next, Some((number, index as u32)), depth, estimate, is_preferred);
        }
    }

    fn discover(&mut self, state: Bits, parent: Option<(u32, u32)>, depth: u32, estimate: u32, preferred: bool) {
        if let Some(number) = self.known.get(&state).copied() {
            if self.nodes[number as usize].improve(parent, depth) {
                self.open.push(self.priority(number, preferred));
            }
            return;
        }
        let number = self.nodes.len() as u32;
        // A pruned state does not become known, so that a cheaper path to it is compared again.
        if let Some(dominance) = &mut self.dominance
            && !dominance.admits(&state, depth)
        {
            return;
        }
        effort::spend(Bits::units(self.task));
        self.known.insert(state.clone(), number);
        self.nodes.push(SearchNode::new(state, parent, depth, estimate));
        self.open.push(self.priority(number, preferred));
    }
}
