//! What the steps of a plan changed.

use crate::plan::StepId;
use crate::world::Fact;

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
    pub(super) fn add(&mut self, step: StepId, changes: &[Change]) {
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
