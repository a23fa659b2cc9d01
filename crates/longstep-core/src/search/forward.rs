//! Forward search: A* for a shortest plan, then greedy search if A* reaches its limit.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rustc_hash::FxHashMap;

use super::bits::Bits;
use super::dominance::Dominance;
use super::landmark_cut::LandmarkCut;
use super::node::{SearchNode, path, start, successor};
use super::relevance;
use super::task::Task;
use super::{GroundAction, Outcome};
use crate::effort;
use crate::model::World;
use crate::plan::Step;

/// Limits of a search as numbers of evaluated states, so that the result does not depend on the speed of the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// States for a plan in the focused task, which has only the most direct operators.
    pub direct: usize,
    /// States for the proof that no plan is shorter than the direct one.
    pub proof: usize,
    /// States for a shortest plan if there is no direct one.
    pub shortest: usize,
    /// States for the final greedy search.
    pub any: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            direct: 4_000,
            proof: 400,
            shortest: 1_500,
            any: 10_000,
        }
    }
}

/// Weight of the heuristic in the greedy search.
const GREED: u32 = 5;

/// Work units of one run. Limits count states, and a state of a task with 20,000 operators takes a thousand times the
/// work of one with 20 operators.
const EFFORT: u64 = 8_000_000;

/// Work units of the final greedy run.
const GREEDY_EFFORT: u64 = 36_000_000;

/// Result of a search without sensing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Straight {
    /// A plan.
    Solved {
        /// The steps; empty if the goal already holds.
        steps: Vec<GroundAction>,
        /// True if it is proven that no plan has fewer steps.
        shortest: bool,
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
                expanded,
            } => Outcome::Solved {
                worst: steps.len() as u32,
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

    /// Returns the number of expanded states.
    pub(super) fn expanded(&self) -> usize {
        match self {
            Self::Solved { expanded, .. } | Self::ProvenUnsolvable { expanded } | Self::GaveUp { expanded, .. } => {
                *expanded
            }
        }
    }
}

pub(super) fn search(task: &Task, limits: &Limits) -> Straight {
    let steps = |path: &[u32], task: &Task| -> Vec<super::GroundAction> {
        let step = |number: &u32| task.operators[*number as usize].step.clone();
        path.iter().map(step).collect()
    };
    let focused = relevance::focus(task);
    let mut heuristic = LandmarkCut::new(task);
    let mut exhausted = false;
    let mut run = |search: Search<'_>| {
        let limit = if search.weight == 1 { EFFORT } else { GREEDY_EFFORT };
        let spent = effort::within(limit, || search.run());
        exhausted |= spent.exhausted;
        spent.result
    };
    let (direct, mut expanded) = run(Search::new(&focused, &mut LandmarkCut::new(&focused), 1, limits.direct));
    match direct {
        Found::Limit => {
            let mut heuristic = LandmarkCut::new(&focused);
            let (found, more) = run(Search::new(&focused, &mut heuristic, GREED, limits.any));
            expanded += more;
            if let Found::Path(path) = found {
                return Straight::Solved {
                    steps: steps(&path, &focused),
                    shortest: false,
                    expanded,
                };
            }
        }
        Found::Path(direct) => {
            // The proof search uses all operators but accepts only plans with fewer steps.
            let mut proof = Search::new(task, &mut heuristic, 1, limits.proof);
            proof.below = Some(direct.len() as u32);
            proof.dominance = Some(Dominance::new(task));
            let (found, more) = run(proof);
            return Straight::Solved {
                shortest: !matches!(found, Found::Limit),
                steps: match found {
                    Found::Path(shorter) => steps(&shorter, task),
                    Found::Nothing | Found::Limit => steps(&direct, &focused),
                },
                expanded: expanded + more,
            };
        }
        Found::Nothing => {}
    }
    for (weight, limit) in [(1, limits.shortest), (GREED, limits.any)] {
        let mut search = Search::new(task, &mut heuristic, weight, limit);
        search.dominance = Some(Dominance::new(task));
        let (found, more) = run(search);
        expanded += more;
        match found {
            Found::Path(path) => {
                return Straight::Solved {
                    steps: steps(&path, task),
                    shortest: weight == 1,
                    expanded,
                };
            }
            Found::Nothing => return Straight::ProvenUnsolvable { expanded },
            Found::Limit => {}
        }
    }
    Straight::GaveUp {
        why: match exhausted {
            true => format!("no plan found in {expanded} states, which took all the work that a search may take"),
            false => format!(
                "no plan found in {} states",
                limits.direct + limits.shortest + limits.any
            ),
        },
        expanded,
    }
}

/// Finds the cheapest path to the goal, as operator numbers, and returns it with the number of expanded states. Accepts
/// only costs less than `below`, if given.
pub(crate) fn cheapest(task: &Task, limit: usize, below: Option<u32>) -> (Found<Vec<u32>>, usize) {
    let mut heuristic = LandmarkCut::new(task);
    let mut search = Search::new(task, &mut heuristic, 1, limit);
    search.below = below;
    if below.is_some() {
        search.dominance = Some(Dominance::new(task));
    }
    effort::within(EFFORT, || search.run()).result
}

/// Finds a path to the goal quickly, not necessarily a cheap one.
pub(crate) fn greedy(task: &Task, limit: usize) -> (Found<Vec<u32>>, usize) {
    let mut heuristic = LandmarkCut::new(task);
    let search = Search::new(task, &mut heuristic, GREED, limit);
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
type Priority = Reverse<(u32, u32, bool, u32)>;

struct Search<'a> {
    task: &'a Task,
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
}

impl<'a> Search<'a> {
    fn new(task: &'a Task, heuristic: &'a mut LandmarkCut, weight: u32, limit: usize) -> Self {
        Self {
            task,
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
        }
    }

    /// Searches until a plan is found, no node is left, or the limit or the budget is reached.
    fn run(mut self) -> (Found<Vec<u32>>, usize) {
        let (mut expanded, mut estimated) = (0, 0);
        self.discover(start(self.task), None, 0, 0, false);
        while let Some(Reverse((promise, _, _, number))) = self.open.pop() {
            if !effort::spend(1) {
                return (Found::Limit, expanded);
            }
            let node = &self.nodes[number as usize];
            if node.expanded || promise > self.promise(node) {
                continue;
            }
            if self.below.is_some_and(|below| promise >= below) {
                // No open node has a lower f-value.
                return (Found::Nothing, expanded);
            }
            if self.task.goal.holds(&|literal| node.state.is(literal)) {
                return (Found::Path(path(&self.nodes, number)), expanded);
            }
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
                if later > promise {
                    self.open.push(self.priority(number, false));
                    continue;
                }
            }
            expanded += 1;
            self.expand(number);
        }
        if effort::is_exhausted() {
            return (Found::Limit, expanded);
        }
        (Found::Nothing, expanded)
    }

    fn promise(&self, node: &SearchNode) -> u32 {
        node.depth + self.weight * node.estimate
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
            if !effort::spend(1 + task.initial.len() / 256) {
                return;
            }
            let Some(next) = successor(task, &node.state, operator) else {
                continue;
            };
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
        if let Some(dominance) = &mut self.dominance
            && !dominance.admits(&state, depth)
        {
            return;
        }
        effort::spend(Bits::units(self.task.initial.len()));
        self.known.insert(state.clone(), number);
        self.nodes.push(SearchNode::new(state, parent, depth, estimate));
        self.open.push(self.priority(number, preferred));
    }
}
