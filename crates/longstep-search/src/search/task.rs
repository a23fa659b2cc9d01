//! The task of a search: numbered facts, operators and a goal.

use indexmap::IndexSet;
use rustc_hash::FxBuildHasher;

use super::formula::Formula;
use super::numbers::Numbers;
use super::operator::Operator;

/// A planning task.
#[derive(Debug, Clone)]
pub(crate) struct Task {
    /// By fact: true if it holds in the initial state.
    pub(crate) initial: Vec<bool>,
    /// The operators; those that record progress come last, in the order in which they apply.
    pub(crate) operators: Vec<Operator>,
    pub(crate) goal: Formula,
    /// The ground `always` rules.
    pub(crate) always: Always,
    /// The numbers, and the facts that are computed from them.
    pub(crate) numbers: Numbers,
}

/// The ground `always` rules: one formula for each binding.
///
/// A step must not break a rule that holds before it. A rule that is broken in the initial state or by a sensing
/// outcome becomes binding once it holds.
#[derive(Debug, Clone, Default)]
pub(crate) struct Always {
    rules: Vec<Formula>,
}

impl Always {
    pub(super) fn of(rules: Vec<Formula>) -> Self {
        // No step can break a rule that never holds.
        let binding = |rule: &Formula| !rule.is_true() && !rule.is_false();
        // Several prohibitions may ground to one rule.
        let unique: IndexSet<Formula, FxBuildHasher> = rules.into_iter().filter(binding).collect();
        Self {
            rules: unique.into_iter().collect(),
        }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Formula> {
        self.rules.iter()
    }

    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Formula> {
        self.rules.iter_mut()
    }
}

impl Task {
    /// Iterates over the operators that are steps, by number.
    pub(crate) fn steps(&self) -> impl Iterator<Item = (usize, &Operator)> {
        let operators = self.operators.iter().enumerate();
        operators.take_while(|(_, operator)| !operator.is_mark)
    }

    /// Returns the operators that record progress, in the order in which they apply.
    pub(crate) fn marks(&self) -> &[Operator] {
        let marks = self
            .operators
            .iter()
            .rev()
            .take_while(|operator| operator.is_mark)
            .count();
        &self.operators[self.operators.len() - marks..]
    }

    /// Returns the work units for visiting every condition and effect once.
    pub(super) fn units(&self) -> usize {
        let operators: usize = self.operators.iter().map(Operator::size).sum();
        (operators + self.numbers.tests.len() + self.goal.size() + self.always.iter().map(Formula::size).sum::<usize>())
            / 8
            + 1
    }
}
