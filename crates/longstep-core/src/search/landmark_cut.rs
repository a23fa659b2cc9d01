//! The landmark-cut heuristic: a lower bound on the cost of reaching the goal.
//!
//! Helmert and Domshlak, *Landmarks, Critical Paths and Abstractions: What's the Difference Anyway?* (2009),
//! with conditional effects as in Röger, Pommerening and Helmert (2014): the cost that a cut takes is taken
//! from the whole action, whichever of its effects are in the cut, so the bound stays a lower bound.

use super::relaxed::{NONE, Relaxed};
use super::task::Task;
use crate::effort;

/// The propositions and rules that are looked at for one unit of the budget.
const LOOKS: usize = 8;

/// The value of what cannot be reached.
const UNREACHED: u32 = u32::MAX;

/// What the bound is computed from, made once for a task, and room to compute in.
#[derive(Debug)]
pub(super) struct LandmarkCut {
    relaxed: Relaxed,
    /// By rule: how many propositions it needs.
    needs: Vec<u32>,
    // What follows is scratch space, kept so that it is allocated once.
    /// By rule: what is left of its operator's cost.
    price: Vec<u32>,
    /// By proposition: the cheapest way to it when a rule costs as much as the dearest of its needs.
    value: Vec<u32>,
    /// By rule: needs that are not reached yet.
    missing: Vec<u32>,
    /// By rule: the dearest of its needs, [`NONE`] while one of them is not reached.
    supporter: Vec<u32>,
    /// By rule: the value of its supporter.
    reached_at: Vec<u32>,
    /// Costs are small whole numbers: a bucket of propositions to look at for each sum of them.
    buckets: Vec<Vec<u32>>,
    /// By proposition: the round in which it was last found near the goal, or reached without going there.
    near_goal: Vec<u32>,
    reached: Vec<u32>,
    round: u32,
    start: Vec<u32>,
    queue: Vec<u32>,
    cut: Vec<u32>,
    /// Propositions and rules that were looked at and are not charged to the budget yet.
    looked_at: usize,
}

/// What is known of a state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Estimate {
    /// No plan costs less; `None` if there is no plan.
    pub(super) cost: Option<u32>,
    /// Operators in the cuts, of which some must be applied, sorted.
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
            near_goal: vec![0; propositions],
            reached: vec![0; propositions],
            round: 0,
            start: Vec::new(),
            queue: Vec::new(),
            cut: Vec::new(),
            looked_at: 0,
        }
    }

    /// The bound for a state.
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
            let left = |operator: &u32| {
                self.relaxed
                    .paid_by
                    .of(*operator)
                    .first()
                    .map(|rule| self.price[*rule as usize])
            };
            let Some(least) = self.cut.iter().filter_map(left).min().filter(|least| *least > 0) else {
                // Unreachable by construction; a bound that is too low is still a bound.
                debug_assert!(false, "an empty cut");
                break;
            };
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

    /// The values of a state in which nothing has been paid for yet.
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
                    // The last need to be reached is the dearest.
                    self.supporter[rule as usize] = proposition;
                    self.reached_at[rule as usize] = distance as u32;
                    self.fire(rule);
                }
            }
        }
    }

    /// Takes the cut's cost from its operators, and lowers the values that depend on it.
    fn lower(&mut self, least: u32) {
        for at in 0..self.cut.len() {
            let operator = self.cut[at];
            for at in 0..self.relaxed.paid_by.of(operator).len() {
                let rule = self.relaxed.paid_by.of(operator)[at];
                self.price[rule as usize] -= least;
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
                // Only a rule's dearest need decides when it fires.
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

    /// Takes the next proposition to look at from the buckets, going on from the distance.
    fn next(&mut self, distance: &mut usize) -> Option<u32> {
        while let Some(bucket) = self.buckets.get_mut(*distance) {
            match bucket.pop() {
                Some(proposition) if self.value[proposition as usize] == *distance as u32 => return Some(proposition),
                // A cheaper way to it was found since.
                Some(_) => {}
                None => *distance += 1,
            }
        }
        None
    }

    /// Lowers the values of what a rule gives.
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
            if self.buckets.len() <= value as usize {
                self.buckets.resize(value as usize + 1, Vec::new());
            }
            self.buckets[value as usize].push(proposition);
        }
    }

    /// The operators that lead from what is reached without them into what leads on to the goal for nothing.
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
                        // What costs nothing and leads there is near the goal itself.
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
