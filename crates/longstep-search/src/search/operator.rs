//! Operators: ground actions with their effects on facts and numbers.

use super::GroundAction;
use super::formula::{Formula, Literal};
use longstep_model::model::{Arithmetic, Fact, NumberChangeKind};

/// A numeric expression over variables of a task.
pub(crate) type VariableExpression = Arithmetic<u32>;

/// A conditional effect on one fact; `condition` refers to the state before.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct GroundEffect {
    pub(crate) condition: Formula,
    pub(crate) literal: Literal,
    /// True if the effect is never applied: it marks a test of numbers that the operator may change.
    pub(crate) may: bool,
}

/// A conditional effect on a number.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct GroundNumericEffect {
    pub(crate) condition: Formula,
    pub(crate) variable: u32,
    pub(crate) kind: NumberChangeKind,
    pub(crate) value: VariableExpression,
}

/// A ground action.
#[derive(Debug, Clone)]
pub(crate) struct Operator {
    pub(crate) step: GroundAction,
    /// True for an operator that records progress: no step of the plan, but applied as soon as it is applicable.
    pub(crate) is_mark: bool,
    /// Cost; 1 for an ordinary step.
    pub(crate) cost: u32,
    /// Meaning of the operator for the creator of the task.
    pub(crate) tag: u32,
    /// Outcome of a sensing step. The search cannot choose it: the operators of the step's other outcomes are
    /// alternatives.
    pub(crate) outcome: Option<Fact>,
    pub(crate) precondition: Formula,
    pub(crate) effects: Vec<GroundEffect>,
    pub(crate) numeric: Vec<GroundNumericEffect>,
}

impl Operator {
    /// Returns the number of literals in its conditions, with some for each change of a number.
    pub(super) fn size(&self) -> usize {
        let effects: usize = self.effects.iter().map(|effect| effect.condition.size()).sum();
        self.precondition.size() + effects + 4 * self.numeric.len()
    }
}
