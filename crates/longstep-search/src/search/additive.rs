//! The FF heuristic with additive costs: the cost of a plan for the delete relaxation, and the operators of that plan.
//!
//! Hoffmann and Nebel, *The FF Planning System* (2001); the relaxed plan takes the achievers with the least additive cost
//! (Keyder and Geffner, 2008). The estimate is not a lower bound, but "unreachable" is a proof.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::bits::Bits;
use super::landmark_cut::Estimate;
use super::relaxed::{NONE, Relaxed};
use super::task::Task;
use longstep_model::effort;

/// Number of propositions and rules that are processed for one work unit.
const LOOKS: usize = 8;

/// Value of an unreachable proposition.
const UNREACHED: u32 = u32::MAX;

/// The relaxed task, built once, and scratch space for the computation.
#[derive(Debug)]
pub(super) struct Additive {
    relaxed: Relaxed,
    /// By rule: number of its conditions.
    needs: Vec<u32>,
    /// By rule: price of its operator.
    price: Vec<u32>,
    // The remaining fields are scratch space, allocated once.
    /// By proposition: its additive cost.
    value: Vec<u32>,
    /// By proposition: the rule that derives it at this cost; [`NONE`] in the state itself.
    achiever: Vec<u32>,
    /// By rule: number of conditions not yet reached.
    missing: Vec<u32>,
    /// By rule: its price and the cost of the conditions reached so far.
    total: Vec<u32>,
    queue: BinaryHeap<Reverse<(u32, u32)>>,
    /// By proposition, and by operator: the last round in which the relaxed plan had it.
    in_plan: Vec<u32>,
    applied: Vec<u32>,
    round: u32,
    stack: Vec<u32>,
}

impl Additive {
    pub(super) fn new(task: &Task) -> Self {
        let relaxed = Relaxed::new(task);
        let (rules, propositions) = (relaxed.payer.len(), relaxed.propositions());
        // Free steps take time as well, and a search that ignores them goes astray among them.
        let uneven = task.steps().any(|(_, operator)| operator.cost != 1);
        Self {
            needs: (0..rules)
                .map(|rule| relaxed.needs.of(rule as u32).len() as u32)
                .collect(),
            price: relaxed.payer.iter().map(|payer| price(task, *payer, uneven)).collect(),
            relaxed,
            value: vec![UNREACHED; propositions],
            achiever: vec![NONE; propositions],
            missing: vec![0; rules],
            total: vec![0; rules],
            queue: BinaryHeap::new(),
            in_plan: vec![0; propositions],
            applied: vec![0; task.operators.len()],
            round: 0,
            stack: Vec::new(),
        }
    }

    /// Estimates the cost from a state to the goal; the preferred operators are those of the relaxed plan.
    pub(super) fn estimate(&mut self, state: &Bits) -> Estimate {
        self.explore(state);
        match self.value[self.relaxed.goal as usize] {
            UNREACHED => Estimate {
                cost: None,
                preferred: Vec::new(),
            },
            _ => self.relaxed_plan(),
        }
    }

    /// Computes the additive costs in a state, until that of the goal is known.
    fn explore(&mut self, state: &Bits) {
        self.value.fill(UNREACHED);
        self.missing.copy_from_slice(&self.needs);
        self.total.copy_from_slice(&self.price);
        self.queue.clear();
        let mut looked_at = (self.needs.len() + self.value.len()) / 4;
        self.improve(self.relaxed.truth, 0, NONE);
        for fact in 0..self.relaxed.literals.len() {
            let proposition = self.relaxed.literals[fact][usize::from(state.holds(fact as u32))];
            if proposition != NONE {
                self.improve(proposition, 0, NONE);
            }
        }
        while let Some(Reverse((value, proposition))) = self.queue.pop() {
            // Taking one out moves as many others as the queue has levels, which is cheaper than a look elsewhere.
            looked_at += (self.queue.len() + 1).ilog2() as usize / 2;
            if value > self.value[proposition as usize] {
                continue;
            }
            // As in Dijkstra's algorithm this cost is final, and costlier propositions are in no relaxed plan.
            if proposition == self.relaxed.goal {
                break;
            }
            looked_at += 1 + self.relaxed.needed_by.of(proposition).len();
            for at in 0..self.relaxed.needed_by.of(proposition).len() {
                let rule = self.relaxed.needed_by.of(proposition)[at];
                // A sum that saturates must not look unreachable, which would count as a proof.
                let total = self.total[rule as usize].saturating_add(value).min(UNREACHED - 1);
                self.total[rule as usize] = total;
                self.missing[rule as usize] -= 1;
                if self.missing[rule as usize] == 0 {
                    looked_at += self.relaxed.gives.of(rule).len();
                    for at in 0..self.relaxed.gives.of(rule).len() {
                        self.improve(self.relaxed.gives.of(rule)[at], total, rule);
                    }
                }
            }
        }
        effort::spend(looked_at / LOOKS + 1);
    }

    fn improve(&mut self, proposition: u32, value: u32, achiever: u32) {
        if value < self.value[proposition as usize] {
            self.value[proposition as usize] = value;
            self.achiever[proposition as usize] = achiever;
            self.queue.push(Reverse((value, proposition)));
        }
    }

    /// Collects the operators that derive the goal at the computed costs.
    fn relaxed_plan(&mut self) -> Estimate {
        self.round += 1;
        let (mut cost, mut preferred) = (0u32, Vec::new());
        self.stack.push(self.relaxed.goal);
        let mut looked_at = 0;
        while let Some(proposition) = self.stack.pop() {
            looked_at += 1;
            let rule = self.achiever[proposition as usize];
            if rule == NONE || std::mem::replace(&mut self.in_plan[proposition as usize], self.round) == self.round {
                continue;
            }
            self.stack.extend(self.relaxed.needs.of(rule));
            let payer = self.relaxed.payer[rule as usize];
            // An operator is paid once, however many of its conditional effects the plan uses.
            if payer != NONE && std::mem::replace(&mut self.applied[payer as usize], self.round) != self.round {
                cost = cost.saturating_add(self.price[rule as usize]);
                preferred.push(payer);
            }
        }
        effort::spend(looked_at / LOOKS);
        preferred.sort_unstable();
        Estimate {
            // A product with a weight must not saturate, or all expensive states would rank alike.
            cost: Some(cost.min(UNREACHED / 64)),
            preferred,
        }
    }
}

/// Returns the price of a rule: the cost of the operator that pays for it, and one more if costs are `uneven`.
fn price(task: &Task, payer: u32, uneven: bool) -> u32 {
    match task.operators.get(payer as usize) {
        Some(operator) if !operator.is_mark => operator.cost.saturating_add(u32::from(uneven)),
        _ => 0,
    }
}
