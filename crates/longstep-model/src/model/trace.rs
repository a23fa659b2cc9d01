//! State changes made by the steps of a plan, and the endings of a plan.

use super::{Fact, Fluent, Number, State};

/// The index of a step of a plan, in reading order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StepId(u32);

impl StepId {
    /// Creates the id of the step at `index` in its plan.
    pub fn new(index: usize) -> Self {
        debug_assert!(u32::try_from(index).is_ok());
        Self(index as u32)
    }

    /// Returns the index of the step in its plan.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The change of one fact by a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// The fact.
    pub fact: Fact,
    /// The new value of the fact.
    pub holds: bool,
}

/// The change of one number by a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NumberChange {
    /// The fluent.
    pub fluent: Fluent,
    /// The number before; none if it had none.
    pub before: Option<Number>,
    /// The number after.
    pub after: Number,
}

/// The changes by one step, or by several.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Changes {
    /// The facts.
    pub facts: Vec<Change>,
    /// The numbers.
    pub numbers: Vec<NumberChange>,
}

/// The changes along one execution path of a plan, step by step.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Trace {
    changes: Vec<Change>,
    numbers: Vec<NumberChange>,
    /// Each executed step with the indices of its first change of a fact and of a number.
    begins: Vec<(StepId, usize, usize)>,
}

impl Trace {
    /// Appends a step and its changes.
    pub fn add(&mut self, step: StepId, changes: &[Change], numbers: &[NumberChange]) {
        self.begins.push((step, self.changes.len(), self.numbers.len()));
        self.changes.extend_from_slice(changes);
        self.numbers.extend_from_slice(numbers);
    }

    /// Returns all changes, in order of execution.
    pub fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// Iterates over the executed steps in order, each with its changes, sorted by fact.
    pub fn steps(&self) -> impl DoubleEndedIterator<Item = (StepId, &[Change])> {
        self.begins.iter().enumerate().map(|(index, (step, begin, _))| {
            let end = self
                .begins
                .get(index + 1)
                .map_or(self.changes.len(), |(_, end, _)| *end);
            (*step, &self.changes[*begin..end])
        })
    }

    /// Iterates over the executed steps in order, each with its changes of numbers, sorted by fluent.
    pub fn numbers(&self) -> impl DoubleEndedIterator<Item = (StepId, &[NumberChange])> {
        self.begins.iter().enumerate().map(|(index, (step, _, begin))| {
            let end = self
                .begins
                .get(index + 1)
                .map_or(self.numbers.len(), |(_, _, end)| *end);
            (*step, &self.numbers[*begin..end])
        })
    }
}

/// One possible ending of a plan.
#[derive(Debug, Clone)]
pub struct Ending {
    /// Sensing outcomes on the path to this ending, as far as they are still known; empty for a plan without sensing.
    pub when: Vec<Fact>,
    /// The changes of each step, on one path to this ending.
    pub trace: Trace,
    /// The state after the last step.
    pub after: State,
    /// The cost of the steps, of the dearest path to this ending; none in a domain without costs, or if it is not known.
    pub cost: Option<Number>,
}
