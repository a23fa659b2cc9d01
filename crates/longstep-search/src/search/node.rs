//! Nodes of a state space search.

use super::bits::Bits;
use super::formula::Literal;
use super::numbers::Numbers;
use super::operator::{GroundEffect, Operator};
use super::task::Task;

/// A state that a search has reached, with the cheapest known path to it.
pub(super) struct SearchNode {
    pub(super) state: Bits,
    /// The numbers of the preceding node and of the operator that leads here from it.
    pub(super) parent: Option<(u32, u32)>,
    /// Cost from the start state.
    pub(super) depth: u32,
    /// Lower bound on the cost to the goal; inherited from the parent until the node is evaluated.
    pub(super) estimate: u32,
    pub(super) estimated: bool,
    pub(super) expanded: bool,
}

impl SearchNode {
    pub(super) fn new(state: Bits, parent: Option<(u32, u32)>, depth: u32, estimate: u32) -> Self {
        Self {
            state,
            parent,
            depth,
            estimate,
            estimated: false,
            expanded: false,
        }
    }

    /// Replaces the path to the node if the new one is cheaper; returns true if it is.
    pub(super) fn improve(&mut self, parent: Option<(u32, u32)>, depth: u32) -> bool {
        let cheaper = depth < self.depth;
        if cheaper {
            self.depth = depth;
            self.parent = parent;
            // With an inconsistent heuristic, the node may have been expanded too early.
            self.expanded = false;
        }
        cheaper
    }
}

/// Returns the initial state of a task, with the progress that it makes.
pub(super) fn start(task: &Task) -> Bits {
    let mut start = Bits::none(task);
    for (fact, holds) in task.initial.iter().enumerate() {
        let fact = fact as u32;
        start.set(Literal { fact, holds: *holds });
    }
    for (variable, number) in task.numbers.initial.iter().enumerate() {
        start.set_number(task, variable as u32, *number);
    }
    record(task, start)
}

/// Returns the state after an operator, with the progress that it makes.
pub(super) fn after(task: &Task, state: &Bits, operator: &Operator) -> Bits {
    record(task, applied(task, state, operator))
}

/// Applies the operators that record progress, each as soon as it is applicable.
fn record(task: &Task, mut state: Bits) -> Bits {
    // Marks come in the order of their stages, so one pass records all stages that one state completes.
    for mark in task.marks() {
        if mark.precondition.holds(&|literal| state.is(literal)) {
            state = applied(task, &state, mark);
        }
    }
    state
}

fn applied(task: &Task, state: &Bits, operator: &Operator) -> Bits {
    let mut next = state.clone();
    // As in PDDL, a fact that is both deleted and added holds afterwards.
    for holds in [false, true] {
        for GroundEffect {
            condition,
            literal,
            may,
        } in &operator.effects
        {
            if !may && literal.holds == holds && condition.holds(&|literal| state.is(literal)) {
                next.set(*literal);
            }
        }
    }
    if !operator.numeric.is_empty() {
        renumber(task, state, operator, &mut next);
    }
    next
}

/// Sets the numbers after an operator, and the tests of them.
fn renumber(task: &Task, state: &Bits, operator: &Operator, next: &mut Bits) {
    let before = |variable: u32| state.number(task, variable);
    let Some(after) = Numbers::after(operator, &before, &|literal| state.is(literal)) else {
        // The precondition excludes this.
        return;
    };
    for (variable, number) in after {
        next.set_number(task, variable, Some(number));
    }
    for test in &task.numbers.tests {
        let holds = test.test.holds(&|variable: &u32| next.number(task, *variable));
        next.set(Literal { fact: test.fact, holds });
    }
}

/// Returns the numbers of the operators on the path to a node.
pub(super) fn path(nodes: &[SearchNode], mut number: u32) -> Vec<u32> {
    let mut path = Vec::new();
    while let Some((parent, operator)) = nodes[number as usize].parent {
        path.push(operator);
        number = parent;
    }
    path.reverse();
    path
}
