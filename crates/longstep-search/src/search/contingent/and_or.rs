//! A* search with AND nodes for sensing.
//!
//! From each state, the search expands actions as in a search without sensing. Wherever an unknown fact can be sensed,
//! there is one more choice: sensing, which costs one step plus the cost of the worst outcome; each outcome is solved
//! recursively. Choices are processed in the order of their lower bounds, so the first solved choice is the best.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::rc::Rc;

use indexmap::IndexMap;
use rustc_hash::FxHashMap;

use super::bound::LowerBounds;
use super::policy::{Policy, Then};
use crate::search::GroundAction;
use crate::search::bits::Bits;
use crate::search::dominance::Dominance;
use crate::search::node::{SearchNode, after, path, start};
use crate::search::successor::Successors;
use crate::search::task::Task;
use longstep_model::effort;

/// Maximum nesting depth of sensing.
// The tree of a plan is no deeper either (`plan::tree::DEEPEST`).
pub(super) const DEEPEST: usize = 48;

/// The limit was reached.
#[derive(Debug)]
pub(super) struct TooFar;

/// Cached result for a state.
struct Known {
    /// Lower bound on the worst case of any policy.
    at_least: u32,
    policy: Option<Rc<Policy>>,
    /// True if there is no policy because one was cut off by its cost, so that a dearer one may exist.
    is_cut: bool,
}

/// Parameters of a search.
#[derive(Debug, Clone, Copy)]
pub(super) struct Manner {
    /// Maximum number of evaluated states.
    pub(super) limit: usize,
    /// States for fewer total steps once the worst case is known.
    pub(super) ties: usize,
    /// Weight of the heuristic; 1 finds the best policy.
    pub(super) weight: u32,
    /// True if sensing may be repeated until it has the desired outcome.
    pub(super) looping: bool,
    /// Maximum nesting depth of sensing. What lies deeper is left out.
    pub(super) deepest: usize,
}

pub(super) struct Search<'a> {
    task: &'a Task,
    successors: Successors<'a>,
    bounds: LowerBounds,
    manner: Manner,
    /// By sensing step: the operators of its outcomes.
    looks: Vec<Vec<u32>>,
    /// Work units to expand a node, without its successors.
    expanding: usize,
    known: FxHashMap<Bits, Known>,
    /// The states at which sensing is currently being solved.
    heads: Vec<Bits>,
    /// Number of started searches; they count against the limit like states.
    begun: usize,
    /// Number of states that were left out because sensing is nested too deeply before them.
    left_out: usize,
    /// The cost below which the whole policy must stay.
    dearest: u32,
    /// The cost of the steps before the search in progress.
    before: u32,
    /// Number of policies that were cut off by their cost.
    cuts: usize,
    /// True if one of them was cut off because the whole policy would cost too much, not because a cheaper one is known.
    is_too_dear: bool,
}

/// An entry of the open list.
#[derive(Clone)]
enum OpenEntry {
    /// A node number.
    Node(u32),
    /// Sensing at a node: node number and index of the sensing step; its outcomes are not estimated yet.
    Look(u32, u32),
    /// Sensing at a node with estimated outcomes; the third number is a lower bound on the total steps.
    Outcomes(u32, u32, u32),
    /// A solved policy.
    Solved(Rc<Policy>),
}

/// The open list: ordered by cost, then heuristic value, then preferred operators, then order of discovery.
#[derive(Default)]
struct Open {
    heap: BinaryHeap<Reverse<(u32, u32, bool, u32)>>,
    choices: Vec<OpenEntry>,
}

impl Open {
    fn push(&mut self, cost: u32, closeness: u32, preferred: bool, choice: OpenEntry) {
        let number = self.choices.len() as u32;
        self.choices.push(choice);
        self.heap.push(Reverse((cost, closeness, !preferred, number)));
    }

    fn pop(&mut self) -> Option<(u32, OpenEntry)> {
        let Reverse((cost, _, _, number)) = self.heap.pop()?;
        Some((cost, self.choices[number as usize].clone()))
    }
}

/// The nodes of one search.
struct Nodes {
    all: Vec<SearchNode>,
    numbers: FxHashMap<Bits, u32>,
    dominance: Option<Dominance>,
}

impl<'a> Search<'a> {
    pub(super) fn new(task: &'a Task, manner: Manner) -> Self {
        let mut looks: IndexMap<&GroundAction, Vec<u32>> = IndexMap::new();
        for (number, operator) in task.operators.iter().enumerate().filter(|(_, o)| o.outcome.is_some()) {
            looks.entry(&operator.step).or_default().push(number as u32);
        }
        Self {
            task,
            successors: Successors::new(task),
            bounds: LowerBounds::new(task, manner.looping),
            manner,
            looks: looks.into_values().collect(),
            expanding: task.units(),
            known: FxHashMap::default(),
            heads: Vec::new(),
            begun: 0,
            left_out: 0,
            dearest: u32::MAX,
            before: 0,
            cuts: 0,
            is_too_dear: false,
        }
    }

    /// Returns the number of evaluated states.
    pub(super) fn looked_at(&self) -> usize {
        self.bounds.looked_at
    }

    /// Returns true if a policy may exist that costs too much.
    pub(super) fn is_too_dear(&self) -> bool {
        self.is_too_dear
    }

    /// Notes that policies of this cost or more, from the state of the search in progress, are left out.
    fn cut(&mut self, cost: u32) {
        self.cuts += 1;
        self.is_too_dear |= self.before.saturating_add(cost) >= self.dearest;
    }

    /// Returns the best policy from the initial state with a worst case of fewer steps than `below`, if there is one.
    pub(super) fn run(&mut self, below: u32) -> Result<Option<Rc<Policy>>, TooFar> {
        self.dearest = below;
        match self.best(&start(self.task), below)? {
            None if self.left_out > 0 => Err(TooFar),
            policy => Ok(policy),
        }
    }

    fn best(&mut self, start: &Bits, below: u32) -> Result<Option<Rc<Policy>>, TooFar> {
        if let Some(known) = self.known.get(start) {
            match &known.policy {
                Some(policy) if policy.worst < below => return Ok(Some(Rc::clone(policy))),
                Some(policy) => {
                    let worst = policy.worst;
                    self.cut(worst);
                    return Ok(None);
                }
                None if known.at_least >= below => {
                    if known.is_cut {
                        let at_least = known.at_least;
                        self.cut(at_least);
                    }
                    return Ok(None);
                }
                None => {}
            }
        }
        self.begun += 1;
        if self.begun > self.manner.limit {
            return Err(TooFar);
        }
        if self.heads.len() > self.manner.deepest {
            // Without what is left out, a policy may not be the best one.
            if self.manner.weight == 1 {
                return Err(TooFar);
            }
            self.left_out += 1;
            return Ok(None);
        }
        let (left_out, cuts) = (self.left_out, self.cuts);
        let policy = self.search(start, below)?;
        // Behind fewer sensing steps the same state may be solvable, so this result is not cached.
        if policy.is_none() && self.left_out > left_out {
            return Ok(None);
        }
        // In looping mode, a policy may return to the current sensing and is valid only there.
        if !self.manner.looping {
            let known = Known {
                at_least: policy.as_ref().map_or(below, |policy| policy.worst),
                is_cut: policy.is_none() && self.cuts > cuts,
                policy: policy.clone(),
            };
            self.known.insert(start.clone(), known);
        }
        Ok(policy)
    }

    fn search(&mut self, start: &Bits, below: u32) -> Result<Option<Rc<Policy>>, TooFar> {
        let mut nodes = Nodes {
            all: Vec::new(),
            numbers: FxHashMap::default(),
            // A loop returns to the very state in which its sensing began, which a dominating state is not.
            dominance: (!self.manner.looping).then(|| Dominance::new(self.task)),
        };
        let mut open = Open::default();
        let mut best: Option<Rc<Policy>> = None;
        self.discover(&mut nodes, &mut open, start.clone(), None, (0, 0, false));
        while let Some((cost, choice)) = open.pop() {
            if !effort::spend(1) {
                return Err(TooFar);
            }
            let exact = self.manner.weight == 1;
            // Choices come in the order of their lower bounds, so no later one is cheaper.
            if exact && cost >= below {
                if best.is_none() {
                    self.cut(cost);
                }
                break;
            }
            // With an equal worst case, a later choice may have fewer steps in total.
            if let Some(best) = &best
                && (!exact || cost > best.worst || self.manner.ties == 0)
            {
                break;
            }
            let in_all = best.as_ref().map_or(u32::MAX, |best| best.total);
            match choice {
                OpenEntry::Node(number) => {
                    let node = &nodes.all[number as usize];
                    // The total of a policy is at least its worst case, which the estimate bounds from below.
                    if node.expanded || cost > self.promise(node) || node.depth + node.estimate >= in_all {
                        continue;
                    }
                    if let Some(then) = self.is_end(node) {
                        // Without a branch the total equals the worst case, so no policy is better.
                        return Ok(Some(Rc::new(nodes.straight(number, then))));
                    }
                    self.take_up(&mut nodes, &mut open, number, best.is_some())?;
                }
                OpenEntry::Look(number, look) => {
                    let node = &nodes.all[number as usize];
                    let (depth, state) = (node.depth, node.state.clone());
                    // Estimates of outcomes cost as much as those of nodes, so they wait until the choice is due.
                    if let Some((worst, sum)) = self.outcomes_at_least(&state, look)? {
                        let depth = depth + self.cost_of(look);
                        let cost = (depth + self.manner.weight * worst).max(cost);
                        open.push(
                            cost,
                            worst,
                            true,
                            OpenEntry::Outcomes(number, look, depth.saturating_add(sum)),
                        );
                    }
                }
                OpenEntry::Outcomes(number, look, total) => {
                    // Of equally dear policies, the one with fewer steps before it senses is better, whatever these cost.
                    let is_earlier = |best: &Rc<Policy>| path(&nodes.all, number).len() < best.path.len();
                    if total > in_all || (total == in_all && !best.as_ref().is_none_or(is_earlier)) {
                        continue;
                    }
                    let below = best
                        .as_ref()
                        .map_or(below, |best| below.min(best.worst.saturating_add(1)));
                    if let Some(policy) = self.solved(&nodes, number, look, below)? {
                        // Back into the open list, since another choice may have a smaller bound than this worst case.
                        open.push(policy.worst, 0, true, OpenEntry::Solved(Rc::new(policy)));
                    }
                }
                OpenEntry::Solved(policy) => {
                    if best.as_ref().is_none_or(|best| policy.is_better(best)) {
                        best = Some(policy);
                    }
                }
            }
        }
        Ok(best)
    }

    fn promise(&self, node: &SearchNode) -> u32 {
        node.depth + self.manner.weight * node.estimate
    }

    /// Returns the continuation if a policy may end at the node.
    fn is_end(&self, node: &SearchNode) -> Option<Then> {
        if self.task.goal.holds(&|literal| node.state.is(literal)) {
            return Some(Then::Done);
        }
        let back = self.manner.looping && node.depth > 0 && self.heads.last() == Some(&node.state);
        back.then_some(Then::Again)
    }

    /// Evaluates a node, and expands it unless its estimate has increased.
    fn take_up(&mut self, nodes: &mut Nodes, open: &mut Open, number: u32, tie: bool) -> Result<(), TooFar> {
        let node = &nodes.all[number as usize];
        let state = node.state.clone();
        let before = self.promise(node);
        let estimate = self.estimate(&state, tie)?;
        let node = &mut nodes.all[number as usize];
        let Some(cost) = estimate.cost else {
            // A dead end for every sensing outcome, or for one of them.
            node.expanded = true;
            return Ok(());
        };
        if !std::mem::replace(&mut node.estimated, true) {
            node.estimate = node.estimate.max(cost);
            let node = &nodes.all[number as usize];
            let later = self.promise(node);
            if later > before {
                open.push(later, node.estimate, false, OpenEntry::Node(number));
                return Ok(());
            }
        }
        self.expand(nodes, open, number, &estimate.preferred);
        Ok(())
    }

    fn estimate(&mut self, state: &Bits, tie: bool) -> Result<super::bound::Estimate, TooFar> {
        let before = self.bounds.looked_at;
        let estimate = self.bounds.estimate(state);
        if tie {
            self.manner.ties = self.manner.ties.saturating_sub(self.bounds.looked_at - before);
        }
        if self.bounds.looked_at > self.manner.limit {
            Err(TooFar)
        } else {
            Ok(estimate)
        }
    }

    fn expand(&mut self, nodes: &mut Nodes, open: &mut Open, number: u32, preferred: &[u32]) {
        let task = self.task;
        nodes.all[number as usize].expanded = true;
        effort::spend(self.expanding + self.looks.len());
        for (index, operator) in task.steps().filter(|(_, operator)| operator.outcome.is_none()) {
            let node = &nodes.all[number as usize];
            if !operator.precondition.holds(&|literal| node.state.is(literal)) {
                continue;
            }
            let Some(next) = self.successors.of(&node.state, operator) else {
                if effort::is_exhausted() {
                    return;
                }
                continue;
            };
            let (depth, estimate) = (node.depth + operator.cost, node.estimate.saturating_sub(operator.cost));
            let is_preferred = preferred.binary_search(&(index as u32)).is_ok();
            self.discover(
                nodes,
                open,
                next,
                Some((number, index as u32)),
                (depth, estimate, is_preferred),
            );
        }
        for look in 0..self.looks.len() {
            let node = &nodes.all[number as usize];
            let operator = &task.operators[self.looks[look][0] as usize];
            if operator.precondition.holds(&|literal| node.state.is(literal)) {
                open.push(
                    self.promise(node),
                    node.estimate,
                    true,
                    OpenEntry::Look(number, look as u32),
                );
            }
        }
    }

    fn discover(
        &self,
        nodes: &mut Nodes,
        open: &mut Open,
        state: Bits,
        parent: Option<(u32, u32)>,
        (depth, estimate, preferred): (u32, u32, bool),
    ) {
        let number = match nodes.numbers.get(&state).copied() {
            Some(number) => {
                if !nodes.all[number as usize].improve(parent, depth) {
                    return;
                }
                number
            }
            None => {
                let admitted = |dominance: &mut Dominance| dominance.admits(&state, depth);
                if !nodes.dominance.as_mut().is_none_or(admitted) {
                    return;
                }
                let number = nodes.all.len() as u32;
                effort::spend(Bits::units(self.task));
                nodes.numbers.insert(state.clone(), number);
                nodes.all.push(SearchNode::new(state, parent, depth, estimate));
                number
            }
        };
        let node = &nodes.all[number as usize];
        open.push(self.promise(node), node.estimate, preferred, OpenEntry::Node(number));
    }

    /// Returns lower bounds on the cost of the outcomes of sensing: the worst one and the sum. None if one of them is
    /// unsolvable.
    fn outcomes_at_least(&mut self, state: &Bits, look: u32) -> Result<Option<(u32, u32)>, TooFar> {
        let (mut worst, mut sum) = (0, 0_u32);
        for operator in self.looks[look as usize].clone() {
            // No check of the rules: that an outcome reveals a broken rule is no fault of the plan.
            let next = after(self.task, state, &self.task.operators[operator as usize]);
            let Some(cost) = self.estimate(&next, false)?.cost else {
                return Ok(None);
            };
            worst = worst.max(cost);
            sum = sum.saturating_add(cost);
        }
        Ok(Some((worst, sum)))
    }

    /// Returns the cost of a sensing step.
    fn cost_of(&self, look: u32) -> u32 {
        self.task.operators[self.looks[look as usize][0] as usize].cost
    }

    /// Returns the best policy that senses at a node.
    fn solved(&mut self, nodes: &Nodes, number: u32, look: u32, below: u32) -> Result<Option<Policy>, TooFar> {
        let node = &nodes.all[number as usize];
        let depth = node.depth + self.cost_of(look);
        let Some(left) = below.checked_sub(depth) else {
            self.cut(depth);
            return Ok(None);
        };
        let mut outcomes = Vec::new();
        self.heads.push(node.state.clone());
        self.before += depth;
        for operator in self.looks[look as usize].clone() {
            let next = after(self.task, &node.state, &self.task.operators[operator as usize]);
            match self.best(&next, left)? {
                Some(policy) => outcomes.push((operator, policy)),
                None => break,
            }
        }
        self.heads.pop();
        self.before -= depth;
        let all = outcomes.len() == self.looks[look as usize].len();
        // A loop that no outcome ends is not a policy.
        let ends = outcomes.iter().any(|(_, policy)| policy.then != Then::Again);
        if !all || !ends {
            return Ok(None);
        }
        let worst = outcomes.iter().map(|(_, policy)| policy.worst).max().unwrap_or(0);
        let total = outcomes
            .iter()
            .fold(0_u32, |sum, (_, policy)| sum.saturating_add(policy.total));
        Ok(Some(Policy {
            path: path(&nodes.all, number),
            then: Then::Look(outcomes),
            worst: depth + worst,
            total: depth.saturating_add(total),
        }))
    }
}

impl Nodes {
    /// Returns the policy that consists of the path to a node.
    fn straight(&self, number: u32, then: Then) -> Policy {
        let depth = self.all[number as usize].depth;
        Policy {
            path: path(&self.all, number),
            then,
            worst: depth,
            total: depth,
        }
    }
}
