//! The landmark-cut heuristic: a lower bound on the cost of reaching the goal.
//!
//! Helmert and Domshlak, *Landmarks, Critical Paths and Abstractions: What's the Difference Anyway?* (2009), with
//! conditional effects as in Röger, Pommerening and Helmert (2014): the cost of a cut is deducted from the whole
//! action, whichever of its effects are in the cut, so the bound stays admissible.

use std::collections::BTreeMap;

use super::relaxed::{NONE, Relaxed};
use super::task::Task;
use longstep_model::effort;

/// Number of propositions and rules that are processed for one work unit.
const LOOKS: usize = 8;

/// Costs below this have a bucket each; higher ones occur in domains with costs of their own.
// Counting up through buckets is fast only where costs are small and close together.
const DENSE: u32 = 4_096;

/// Value of an unreachable proposition.
const UNREACHED: u32 = u32::MAX;

/// The relaxed task, built once, and scratch space for the computation.
#[derive(Debug)]
pub(super) struct LandmarkCut {
    relaxed: Relaxed,
    /// By rule: number of its conditions.
    needs: Vec<u32>,
    // The remaining fields are scratch space, allocated once.
    /// By rule: remaining cost of its operator.
    price: Vec<u32>,
    /// By proposition: its h-max value.
    value: Vec<u32>,
    /// By rule: number of conditions not yet reached.
    missing: Vec<u32>,
    /// By rule: the condition with the highest value; [`NONE`] while a condition is not reached.
    supporter: Vec<u32>,
    /// By rule: value of its supporter.
    reached_at: Vec<u32>,
    /// Priority queue: a bucket of propositions for each cost below [`DENSE`].
    buckets: Vec<Vec<u32>>,
    /// The buckets of higher costs.
    sparse: BTreeMap<u32, Vec<u32>>,
    /// By proposition: the last round in which it was in the goal zone, or reached outside of it.
    near_goal: Vec<u32>,
    reached: Vec<u32>,
    round: u32,
    start: Vec<u32>,
    queue: Vec<u32>,
    cut: Vec<u32>,
    /// Processed propositions and rules that are not yet charged to the budget.
    looked_at: usize,
}

/// Heuristic estimate for a state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Estimate {
    /// Lower bound on the cost of a plan; `None` if there is no plan.
    pub(super) cost: Option<u32>,
    /// The operators in the cuts, sorted; every plan contains some of them.
    pub(super) preferred: Vec<u32>,
}

impl LandmarkCut {
    pub(super) fn new(task: &Task) -> Self {
        let relaxed = Relaxed::new(task);
        let (rules, propositions) = (relaxed.payer.len(), relaxed.propositions());
        Self {
            needs: (0..rules)
                .map(|rule| relaxed.needs.of(rule as u32).len() as u32)
                .collect(),
            relaxed,
            price: vec![0; rules],
            value: vec![UNREACHED; propositions],
            missing: vec![0; rules],
            supporter: vec![NONE; rules],
            reached_at: vec![0; rules],
            buckets: Vec::new(),
            sparse: BTreeMap::new(),
            near_goal: vec![0; propositions],
            reached: vec![0; propositions],
            round: 0,
            start: Vec::new(),
            queue: Vec::new(),
            cut: Vec::new(),
            looked_at: 0,
        }
    }

    /// Computes the bound for a state.
    pub(super) fn estimate(&mut self, holds: impl Fn(u32) -> bool) -> Estimate {
        self.start.clear();
        self.start.push(self.relaxed.truth);
        for (fact, propositions) in self.relaxed.literals.iter().enumerate() {
            let proposition = propositions[usize::from(holds(fact as u32))];
            if proposition != NONE {
                self.start.push(proposition);
            }
        }
        for (price, payer) in self.price.iter_mut().zip(&self.relaxed.payer) {
            *price = self.relaxed.costs.get(*payer as usize).copied().unwrap_or(0);
        }
        let mut bound = 0;
        let mut preferred = Vec::new();
        self.looked_at = self.price.len() + self.value.len();
        self.values();
        // A loop that ends for lack of budget leaves the sum of fewer cuts, which is a lower bound too.
        while effort::spend(std::mem::take(&mut self.looked_at) / LOOKS + 1) {
            match self.value[self.relaxed.goal as usize] {
                UNREACHED => {
                    return Estimate {
                        cost: None,
                        preferred: Vec::new(),
                    };
                }
                0 => break,
                _ => {}
            }
            self.find_cut();
            let prices = self.cut.iter().filter_map(|operator| self.price_of(*operator));
            let Some(least) = prices.min().filter(|least| *least > 0) else {
                // Cannot happen; a bound that is too low is still admissible.
                debug_assert!(false, "an empty cut");
                break;
            };
            // Every plan contains an operator of the cut, so it costs at least the least price. The rest of the prices
            // stays for later cuts.
            bound += least;
            preferred.extend_from_slice(&self.cut);
            self.lower(least);
        }
        preferred.sort_unstable();
        preferred.dedup();
        Estimate {
            cost: Some(bound),
            preferred,
        }
    }

    /// Returns the price of an operator that the cuts so far have left.
    fn price_of(&self, operator: u32) -> Option<u32> {
        let rule = self.relaxed.paid_by.of(operator).first()?;
        Some(self.price[*rule as usize])
    }

    /// Computes the h-max values of a state.
    fn values(&mut self) {
        self.value.fill(UNREACHED);
        self.missing.copy_from_slice(&self.needs);
        self.supporter.fill(NONE);
        for index in 0..self.start.len() {
            self.improve(self.start[index], 0);
        }
        let mut distance = 0;
        while let Some(proposition) = self.next(&mut distance) {
            self.looked_at += 1 + self.relaxed.needed_by.of(proposition).len();
            for at in 0..self.relaxed.needed_by.of(proposition).len() {
                let rule = self.relaxed.needed_by.of(proposition)[at];
                let missing = &mut self.missing[rule as usize];
                *missing -= 1;
                if *missing == 0 {
                    // The last condition to be reached has the highest value.
                    self.supporter[rule as usize] = proposition;
                    self.reached_at[rule as usize] = distance as u32;
                    self.fire(rule);
                }
            }
        }
    }

    /// Deducts the cost of the cut from its operators, and lowers the values that depend on it.
    fn lower(&mut self, least: u32) {
        for at in 0..self.cut.len() {
            let operator = self.cut[at];
            for at in 0..self.relaxed.paid_by.of(operator).len() {
                let rule = self.relaxed.paid_by.of(operator)[at];
                self.price[rule as usize] -= least;
                // A rule with an unreached condition stays so: cheaper operators reach nothing new.
                if self.supporter[rule as usize] != NONE {
                    self.fire(rule);
                }
            }
        }
        let mut distance = 0;
        while let Some(proposition) = self.next(&mut distance) {
            self.looked_at += 1 + self.relaxed.needed_by.of(proposition).len();
            for at in 0..self.relaxed.needed_by.of(proposition).len() {
                let rule = self.relaxed.needed_by.of(proposition)[at];
                let known = self.reached_at[rule as usize];
                // Only a rule's supporter determines when it fires.
                if self.supporter[rule as usize] != proposition || known <= distance as u32 {
                    continue;
                }
                let mut dearest = (distance as u32, proposition);
                self.looked_at += self.relaxed.needs.of(rule).len();
                for need in self.relaxed.needs.of(rule) {
                    let value = self.value[*need as usize];
                    if value > dearest.0 {
                        dearest = (value, *need);
                    }
                }
                (self.reached_at[rule as usize], self.supporter[rule as usize]) = dearest;
                if dearest.0 < known {
                    self.fire(rule);
                }
            }
        }
    }

    /// Takes the next proposition from the buckets, at or above the distance.
    fn next(&mut self, distance: &mut usize) -> Option<u32> {
        while let Some(bucket) = self.buckets.get_mut(*distance) {
            match bucket.pop() {
                Some(proposition) if self.value[proposition as usize] == *distance as u32 => return Some(proposition),
                // A cheaper path to it was found later.
                Some(_) => {}
                None => *distance += 1,
            }
        }
        while let Some(mut bucket) = self.sparse.first_entry() {
            let cost = *bucket.key();
            match bucket.get_mut().pop() {
                Some(proposition) if self.value[proposition as usize] == cost => {
                    *distance = cost as usize;
                    return Some(proposition);
                }
                Some(_) => {}
                None => {
                    bucket.remove();
                }
            }
        }
        None
    }

    /// Lowers the values of a rule's results.
    fn fire(&mut self, rule: u32) {
        let value = self.reached_at[rule as usize] + self.price[rule as usize];
        self.looked_at += self.relaxed.gives.of(rule).len();
        for at in 0..self.relaxed.gives.of(rule).len() {
            self.improve(self.relaxed.gives.of(rule)[at], value);
        }
    }

    fn improve(&mut self, proposition: u32, value: u32) {
        if value < self.value[proposition as usize] {
            self.value[proposition as usize] = value;
            if value >= DENSE {
                return self.sparse.entry(value).or_default().push(proposition);
            }
            if self.buckets.len() <= value as usize {
                self.buckets.resize(value as usize + 1, Vec::new());
            }
            self.buckets[value as usize].push(proposition);
        }
    }

    /// Finds the operators that lead from outside the goal zone into it. The goal zone is the set of propositions from
    /// which the goal is reachable at no cost.
    fn find_cut(&mut self) {
        let Self {
            relaxed,
            price,
            supporter,
            near_goal,
            reached,
            queue,
            cut,
            looked_at,
            ..
        } = self;
        self.round += 1;
        let round = self.round;
        // Round numbers serve as flags that need no clearing between cuts.
        near_goal[relaxed.goal as usize] = round;
        queue.push(relaxed.goal);
        *looked_at += self.start.len();
        while let Some(proposition) = queue.pop() {
            *looked_at += 1 + relaxed.given_by.of(proposition).len();
            for rule in relaxed.given_by.of(proposition) {
                let supporter = supporter[*rule as usize];
                if supporter != NONE && price[*rule as usize] == 0 && near_goal[supporter as usize] != round {
                    near_goal[supporter as usize] = round;
                    queue.push(supporter);
                }
            }
        }
        cut.clear();
        for proposition in &self.start {
            if near_goal[*proposition as usize] != round {
                reached[*proposition as usize] = round;
                queue.push(*proposition);
            }
        }
        while let Some(proposition) = queue.pop() {
            *looked_at += 1 + relaxed.needed_by.of(proposition).len();
            for rule in relaxed.needed_by.of(proposition) {
                if supporter[*rule as usize] != proposition {
                    continue;
                }
                *looked_at += relaxed.gives.of(*rule).len();
                for given in relaxed.gives.of(*rule) {
                    if near_goal[*given as usize] == round {
                        // Zero-cost rules into the goal zone are inside it.
                        cut.push(relaxed.payer[*rule as usize]);
                    } else if reached[*given as usize] != round {
                        reached[*given as usize] = round;
                        queue.push(*given);
                    }
                }
            }
        }
        cut.sort_unstable();
        cut.dedup();
    }
}
