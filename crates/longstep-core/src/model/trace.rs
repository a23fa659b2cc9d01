//! Changes that the steps of a plan made, and how it ended.

use super::{Fact, State};

/// A step of a plan, in reading order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StepId(u32);

impl StepId {
    /// The id of the step at `index` in its plan.
    pub fn new(index: usize) -> Self {
        debug_assert!(u32::try_from(index).is_ok());
        Self(index as u32)
    }

    /// The index in its plan.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A fact that a step made true or false.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// The fact.
    pub fact: Fact,
    /// Whether it holds now.
    pub holds: bool,
}

/// The changes of one way through a plan, step by step.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Trace {
    changes: Vec<Change>,
    /// Each step with the place where its changes begin.
    begins: Vec<(StepId, usize)>,
}

impl Trace {
    /// Adds a step with what it changed.
    pub(crate) fn add(&mut self, step: StepId, changes: &[Change]) {
        self.begins.push((step, self.changes.len()));
        self.changes.extend_from_slice(changes);
    }

    /// All changes, in order.
    pub fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// Each step that was done, in the order in which it was done, with what it changed, sorted by fact.
    pub fn steps(&self) -> impl DoubleEndedIterator<Item = (StepId, &[Change])> {
        self.begins.iter().enumerate().map(|(index, (step, begin))| {
            let end = self.begins.get(index + 1).map_or(self.changes.len(), |(_, end)| *end);
            (*step, &self.changes[*begin..end])
        })
    }
}

/// One way in which a plan can end.
#[derive(Debug, Clone)]
pub struct Ending {
    /// Outcomes of sensing on the way, as far as they are still known; empty for a plan without sensing.
    pub when: Vec<Fact>,
    /// Changes of each step, on one way that ends so.
    pub trace: Trace,
    /// The world after the last step.
    pub after: State,
}
