//! Lazy best-first search with preferred operators, for a plan that need not be a shortest one.
//!
//! Richter and Westphal, *The LAMA Planner* (2010): a state is evaluated when it is taken from the open list, not when it
//! is generated, and a second open list has only the successors by operators of the relaxed plan. It is served more often
//! after progress. A third list takes states of every estimate and depth in turn (Xie et al., *Type-Based Exploration with
//! Multiple Search Queues*, 2014): where estimates mislead, the others stay on one plateau.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Bound;

use rustc_hash::FxHashMap;

use super::Found;
use super::additive::Additive;
use super::applicable::Applicable;
use super::bits::Bits;
use super::node::start;
use super::successor::Successors;
use super::task::Task;
use longstep_model::effort;

/// Turns of the preferred successors after progress.
// The value of LAMA.
const BOOST: i64 = 1_000;

/// One in so many successors is of the next type, for a first plan.
// Without these turns, three of 38 laboratory tasks stayed on a plateau until the search gave up.
const EXPLORE: u64 = 3;

/// How a search ranks states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rank {
    /// By the estimate alone.
    Estimate,
    /// By the cost so far and the estimate times a weight; a cheaper path to a state replaces its path.
    Weighted(u32),
}

struct Node {
    state: Bits,
    /// The numbers of the preceding node and of the operator that leads here from it.
    parent: Option<(u32, u32)>,
    /// Cost from the start.
    depth: u32,
}

/// Successors that were not generated yet, as nodes and operators, by rank and in order of discovery.
#[derive(Default)]
struct Open {
    entries: BTreeMap<u32, VecDeque<(u32, u32)>>,
    /// The list with the least number of turns is next.
    turns: i64,
}

impl Open {
    fn push(&mut self, rank: u32, entry: (u32, u32)) {
        self.entries.entry(rank).or_default().push_back(entry);
    }

    fn pop(&mut self) -> Option<(u32, u32)> {
        let mut first = self.entries.first_entry()?;
        let entry = first.get_mut().pop_front();
        if first.get().is_empty() {
            first.remove();
        }
        entry
    }
}

/// Successors that were not generated yet, by the estimate and the cost of their parents.
#[derive(Default)]
struct Types {
    entries: BTreeMap<(u32, u32), VecDeque<(u32, u32)>>,
    /// The type of the last one that was taken.
    last: (u32, u32),
}

impl Types {
    fn push(&mut self, of: (u32, u32), entry: (u32, u32)) {
        self.entries.entry(of).or_default().push_back(entry);
    }

    /// Takes the oldest one of the next type, in turn.
    fn pop(&mut self) -> Option<(u32, u32)> {
        let after = (Bound::Excluded(self.last), Bound::Unbounded);
        let next = self.entries.range(after).next().or_else(|| self.entries.iter().next());
        self.last = *next?.0;
        let entries = self.entries.get_mut(&self.last)?;
        let entry = entries.pop_front();
        if entries.is_empty() {
            self.entries.remove(&self.last);
        }
        entry
    }
}

/// A task with the data that all its searches share.
pub(super) struct Lazy<'a> {
    task: &'a Task,
    pub(super) successors: Successors<'a>,
    heuristic: Additive,
    applicable: Applicable,
}

impl<'a> Lazy<'a> {
    pub(super) fn new(task: &'a Task) -> Self {
        Self {
            task,
            successors: Successors::new(task),
            heuristic: Additive::new(task),
            applicable: Applicable::new(task),
        }
    }

    /// Finds a path to the goal at a cost less than `below`, within `limit` evaluated states. Returns it with the number of
    /// evaluated states. `Found::Nothing` is a proof.
    pub(super) fn run(&mut self, rank: Rank, below: Option<u32>, limit: usize) -> (Found<Vec<u32>>, usize) {
        let mut run = Run {
            task: self.task,
            rank,
            below: below.unwrap_or(u32::MAX),
            nodes: Vec::new(),
            known: FxHashMap::default(),
            all: Open::default(),
            preferred: Open::default(),
            types: Types::default(),
            pops: 0,
            least: u32::MAX,
            scratch: Vec::new(),
        };
        let (mut next, mut evaluated) = (Some((start(self.task), None, 0)), 0);
        loop {
            if let Some((state, parent, depth)) = next.take() {
                if depth >= run.below {
                    return (Found::Nothing, evaluated);
                }
                if evaluated == limit || effort::is_exhausted() {
                    return (Found::Limit, evaluated);
                }
                evaluated += 1;
                let number = run.add(state, parent, depth);
                if self
                    .task
                    .goal
                    .holds(&|literal| run.nodes[number as usize].state.is(literal))
                {
                    return (Found::Path(run.path(number)), evaluated);
                }
                self.expand(&mut run, number);
            }
            let Some(entry) = run.pop() else {
                // Successors that are missing for lack of budget would make this proof false.
                let found = if effort::is_exhausted() {
                    Found::Limit
                } else {
                    Found::Nothing
                };
                return (found, evaluated);
            };
            if !effort::spend(1) {
                return (Found::Limit, evaluated);
            }
            next = run.generate(&self.successors, entry);
        }
    }

    fn expand(&mut self, run: &mut Run<'_>, number: u32) {
        let node = &run.nodes[number as usize];
        let estimate = self.heuristic.estimate(&node.state);
        // Not even the delete relaxation reaches the goal from here, so no plan passes through this state.
        let Some(cost) = estimate.cost else { return };
        if cost < run.least {
            // The first estimate of a run is no progress.
            run.preferred.turns -= if run.least == u32::MAX { 0 } else { BOOST };
            run.least = cost;
        }
        let rank = match run.rank {
            Rank::Estimate => cost,
            Rank::Weighted(weight) => node.depth.saturating_add(weight.saturating_mul(cost)),
        };
        let depth = node.depth;
        let mut scratch = std::mem::take(&mut run.scratch);
        self.applicable.find(self.task, &node.state, &mut scratch);
        for operator in &scratch {
            run.all.push(rank, (number, *operator));
            if run.rank == Rank::Estimate {
                run.types.push((cost, depth), (number, *operator));
            }
            if estimate.preferred.binary_search(operator).is_ok() {
                run.preferred.push(rank, (number, *operator));
            }
        }
        effort::spend(scratch.len() / 4);
        run.scratch = scratch;
    }
}

/// The state of one search.
struct Run<'a> {
    task: &'a Task,
    rank: Rank,
    /// Upper bound: only plans of lower cost are accepted.
    below: u32,
    nodes: Vec<Node>,
    known: FxHashMap<Bits, u32>,
    all: Open,
    preferred: Open,
    types: Types,
    pops: u64,
    /// The least estimate so far.
    least: u32,
    scratch: Vec<u32>,
}

/// A state that is about to be evaluated, its parent and its cost from the start.
type Generated = (Bits, Option<(u32, u32)>, u32);

impl Run<'_> {
    /// Takes the next successor from the list whose turn it is.
    fn pop(&mut self) -> Option<(u32, u32)> {
        self.pops += 1;
        if self.pops.is_multiple_of(EXPLORE)
            && let Some(entry) = self.types.pop()
        {
            return Some(entry);
        }
        let (first, second) = if self.preferred.turns <= self.all.turns {
            (&mut self.preferred, &mut self.all)
        } else {
            (&mut self.all, &mut self.preferred)
        };
        if let Some(entry) = first.pop() {
            first.turns += 1;
            return Some(entry);
        }
        let entry = second.pop()?;
        second.turns += 1;
        Some(entry)
    }

    /// Generates a successor; none if it is known, too expensive, or not allowed.
    fn generate(&self, successors: &Successors<'_>, (parent, operator): (u32, u32)) -> Option<Generated> {
        let node = &self.nodes[parent as usize];
        let step = &self.task.operators[operator as usize];
        let depth = node.depth.saturating_add(step.cost);
        // Costs are not negative, so no continuation is cheap enough again.
        if depth >= self.below {
            return None;
        }
        let state = successors.of(&node.state, step)?;
        let is_new = match self.known.get(&state) {
            None => true,
            // A first plan need not be cheap, so its search never reopens a state.
            Some(known) => self.rank != Rank::Estimate && depth < self.nodes[*known as usize].depth,
        };
        is_new.then_some((state, Some((parent, operator)), depth))
    }

    /// Adds a state, or replaces the path to a known one; returns its number.
    fn add(&mut self, state: Bits, parent: Option<(u32, u32)>, depth: u32) -> u32 {
        if let Some(number) = self.known.get(&state) {
            let node = &mut self.nodes[*number as usize];
            (node.parent, node.depth) = (parent, depth);
            return *number;
        }
        effort::spend(Bits::units(self.task));
        let number = self.nodes.len() as u32;
        self.known.insert(state.clone(), number);
        self.nodes.push(Node { state, parent, depth });
        number
    }

    fn path(&self, mut number: u32) -> Vec<u32> {
        let mut path = Vec::new();
        while let Some((parent, operator)) = self.nodes[number as usize].parent {
            path.push(operator);
            number = parent;
        }
        path.reverse();
        path
    }
}
