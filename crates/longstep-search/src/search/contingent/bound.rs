//! Lower bound on the worst-case cost of a contingent plan.
//!
//! A plan must work for all sensing outcomes. So it must also work if one unknown fact always has the same outcome, and
//! there it costs at least as much as a plan that knows the outcome in advance. For each outcome of each unknown fact,
//! the bound of the task restricted to that outcome is therefore a lower bound. The largest of them bounds the worst
//! case. If one of them is infinite, no plan works for that outcome.

use rustc_hash::FxHashMap;

use crate::search::bits::Bits;
use crate::search::landmark_cut::LandmarkCut;
use crate::search::operator::Operator;
use crate::search::task::Task;
use longstep_model::effort;

/// Alternative outcomes of sensing, exactly one of which holds: their fact numbers, sorted.
type OutcomeGroup = Vec<u32>;

/// Lower bounds for the states of one task.
#[derive(Debug)]
pub(super) struct LowerBounds {
    /// Optimistic bound: sensing has the best outcome.
    wishful: LandmarkCut,
    groups: Vec<(OutcomeGroup, Vec<LandmarkCut>)>,
    known: FxHashMap<Bits, Estimate>,
    /// Number of evaluated states.
    pub(super) looked_at: usize,
}

/// Heuristic estimate for a state.
#[derive(Debug, Clone)]
pub(super) struct Estimate {
    /// Lower bound on the worst-case cost; none if there is no plan.
    pub(super) cost: Option<u32>,
    /// Operators of which every plan contains some, sorted.
    pub(super) preferred: Vec<u32>,
}

impl Estimate {
    /// Raises the cost to that of one bound; returns false if there is no plan.
    fn raise(&mut self, bound: &mut LandmarkCut, state: &Bits) -> bool {
        let found = bound.estimate(|fact| state.holds(fact));
        self.cost = self.cost.and_then(|cost| Some(cost.max(found.cost?)));
        if self.preferred.is_empty() {
            self.preferred = found.preferred;
        }
        self.cost.is_some()
    }
}

impl LowerBounds {
    /// Prepares the bounds. If `looping`, repeated sensing may have different outcomes, so only the optimistic bound is
    /// valid.
    pub(super) fn new(task: &Task, looping: bool) -> Self {
        let groups = if looping { Vec::new() } else { groups(task) };
        Self {
            wishful: LandmarkCut::new(task),
            groups: groups.into_iter().map(|group| with_bounds(task, group)).collect(),
            known: FxHashMap::default(),
            looked_at: 0,
        }
    }

    /// Returns the bound for a state.
    pub(super) fn estimate(&mut self, state: &Bits) -> Estimate {
        if let Some(known) = self.known.get(state) {
            return known.clone();
        }
        self.looked_at += 1;
        let mut estimate = Estimate {
            cost: Some(0),
            preferred: Vec::new(),
        };
        let unknown = |group: &OutcomeGroup| group.iter().all(|fact| !state.holds(*fact));
        let mut open = self.groups.iter_mut().filter(|(group, _)| unknown(group)).peekable();
        // The tasks with a fixed outcome have fewer operators, so their bounds are seldom below the optimistic one.
        if open.peek().is_none() {
            estimate.raise(&mut self.wishful, state);
        } else {
            open.flat_map(|(_, bounds)| bounds)
                .all(|bound| estimate.raise(bound, state));
        }
        effort::spend(8 + estimate.preferred.len() / 8);
        // Nested searches meet the same states again.
        self.known.insert(state.clone(), estimate.clone());
        estimate
    }
}

/// Adds the bound for each outcome of a group.
fn with_bounds(task: &Task, group: OutcomeGroup) -> (OutcomeGroup, Vec<LandmarkCut>) {
    let alone = |outcome: &u32| LandmarkCut::new(&only(task, &group, *outcome));
    // The largest of fewer lower bounds is a lower bound too.
    let affordable = group.iter().take_while(|_| !effort::is_exhausted());
    let bounds = affordable.map(alone).collect();
    (group, bounds)
}

/// Returns the groups of alternative sensing outcomes in a task.
pub(super) fn groups(task: &Task) -> Vec<OutcomeGroup> {
    let mut by_step: FxHashMap<_, OutcomeGroup> = FxHashMap::default();
    for operator in task.operators.iter().filter(|operator| operator.outcome.is_some()) {
        by_step.entry(&operator.step).or_default().extend(outcome(operator));
    }
    let mut groups: Vec<OutcomeGroup> = by_step.into_values().collect();
    groups.iter_mut().for_each(|group| group.sort_unstable());
    groups.sort_unstable();
    groups.dedup();
    groups
}

/// Returns the fact that a sensing operator reveals.
pub(super) fn outcome(operator: &Operator) -> Option<u32> {
    operator.outcome?;
    operator.effects.first().map(|effect| effect.literal.fact)
}

/// Restricts sensing of the group to this outcome.
pub(super) fn only(task: &Task, group: &OutcomeGroup, alone: u32) -> Task {
    effort::spend(32 * task.units());
    let mut task = task.clone();
    task.operators.retain(|operator| {
        let alternative = outcome(operator);
        alternative.is_none_or(|fact| fact == alone || group.binary_search(&fact).is_err())
    });
    task
}
