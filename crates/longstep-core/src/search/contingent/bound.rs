//! What a plan that looks before it decides costs at least.
//!
//! A plan has to do whatever sensing tells. So it has to do in particular where one thing that is not known always turns
//! out the same way, and there it can do no better than a plan that knew it: for each outcome of each such thing, the
//! lower bound of the task in which sensing has that outcome alone. The largest of them is a lower bound on the worst
//! case. Where one of them finds no way, no plan can do with that outcome.

use rustc_hash::FxHashMap;

use crate::effort;
use crate::search::bits::Bits;
use crate::search::landmark_cut::LandmarkCut;
use crate::search::task::{Operator, Task};

/// Things that sensing tells: the outcomes of which one holds, by the numbers of their facts, sorted.
type Group = Vec<u32>;

/// Lower bounds for the states of one task.
#[derive(Debug)]
pub(super) struct Bounds {
    /// Sensing has whichever outcome is wished for.
    wishful: LandmarkCut,
    groups: Vec<(Group, Vec<LandmarkCut>)>,
    known: FxHashMap<Bits, Estimate>,
    /// How many states were looked at.
    pub(super) looked_at: usize,
}

/// What is known of a state.
#[derive(Debug, Clone)]
pub(super) struct Estimate {
    /// No plan costs less in the worst case; none if there is no plan.
    pub(super) cost: Option<u32>,
    /// Operators of which some must be applied, sorted.
    pub(super) preferred: Vec<u32>,
}

impl Bounds {
    /// If it is `looping`, what is told may be another thing the next time, and only the wishful bound counts.
    pub(super) fn new(task: &Task, looping: bool) -> Self {
        let groups = match looping {
            true => Vec::new(),
            false => groups(task),
        };
        let bounds = |group: Group| {
            let alone = |outcome: &u32| LandmarkCut::new(&only(task, &group, *outcome));
            let affordable = group.iter().take_while(|_| !effort::is_exhausted());
            let bounds = affordable.map(alone).collect();
            (group, bounds)
        };
        Self {
            wishful: LandmarkCut::new(task),
            groups: groups.into_iter().map(bounds).collect(),
            known: FxHashMap::default(),
            looked_at: 0,
        }
    }

    /// The bound for a state.
    pub(super) fn estimate(&mut self, state: &Bits) -> Estimate {
        if let Some(known) = self.known.get(state) {
            return known.clone();
        }
        self.looked_at += 1;
        let mut estimate = Estimate {
            cost: Some(0),
            preferred: Vec::new(),
        };
        let mut take = |bound: &mut LandmarkCut| {
            let found = bound.estimate(|fact| state.holds(fact));
            estimate.cost = estimate.cost.and_then(|cost| Some(cost.max(found.cost?)));
            if estimate.preferred.is_empty() {
                estimate.preferred = found.preferred;
            }
            estimate.cost.is_some()
        };
        let unknown = |group: &Group| group.iter().all(|fact| !state.holds(*fact));
        let mut open = self.groups.iter_mut().filter(|(group, _)| unknown(group)).peekable();
        if open.peek().is_none() {
            take(&mut self.wishful);
        } else {
            open.flat_map(|(_, bounds)| bounds).all(take);
        }
        effort::spend(8 + estimate.preferred.len() / 8);
        self.known.insert(state.clone(), estimate.clone());
        estimate
    }
}

/// The things that sensing tells in a task.
pub(super) fn groups(task: &Task) -> Vec<Group> {
    let mut by_step: FxHashMap<_, Group> = FxHashMap::default();
    for operator in task.operators.iter().filter(|operator| operator.told.is_some()) {
        by_step.entry(&operator.step).or_default().extend(outcome(operator));
    }
    let mut groups: Vec<Group> = by_step.into_values().collect();
    groups.iter_mut().for_each(|group| group.sort_unstable());
    groups.sort_unstable();
    groups.dedup();
    groups
}

/// The fact that an operator of sensing tells.
pub(super) fn outcome(operator: &Operator) -> Option<u32> {
    operator.told?;
    operator.effects.first().map(|effect| effect.literal.fact)
}

/// The task in which sensing the group has this outcome alone.
pub(super) fn only(task: &Task, group: &Group, alone: u32) -> Task {
    effort::spend(32 * task.units());
    let mut task = task.clone();
    task.operators.retain(|operator| {
        let told = outcome(operator);
        told.is_none_or(|fact| fact == alone || group.binary_search(&fact).is_err())
    });
    task
}
