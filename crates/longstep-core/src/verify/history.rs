//! Changes along the execution paths of a plan.

use crate::effort;
use crate::model::{Change, Fact, Missing, StepId, Trace};

/// Position in the [`History`]: the last step of an execution path.
pub(super) type Here = Option<u32>;

/// The changes of all execution paths, step by step. Paths share common prefixes, so a branch copies nothing.
#[derive(Debug, Default)]
pub(super) struct History {
    changes: Vec<Change>,
    entries: Vec<Entry>,
}

#[derive(Debug)]
struct Entry {
    step: StepId,
    begin: usize,
    end: usize,
    before: Here,
}

impl History {
    /// Adds a step after `before`; `change` appends its changes.
    pub(super) fn add(&mut self, step: StepId, before: Here, change: impl FnOnce(&mut Vec<Change>)) -> Here {
        effort::spend(effort::KEPT);
        let begin = self.changes.len();
        change(&mut self.changes);
        self.entries.push(Entry {
            step,
            begin,
            end: self.changes.len(),
            before,
        });
        Some((self.entries.len() - 1) as u32)
    }

    /// Returns the position before the last step.
    pub(super) fn before(&self, here: Here) -> Here {
        here.and_then(|number| self.entries[number as usize].before)
    }

    /// Iterates over the steps of a path, from the last to the first.
    pub(super) fn back(&self, here: Here) -> impl Iterator<Item = (StepId, &[Change])> {
        let entry = |here: Here| here.map(|number| &self.entries[number as usize]);
        std::iter::successors(entry(here), move |last| entry(last.before))
            .map(|entry| (entry.step, &self.changes[entry.begin..entry.end]))
    }

    /// Returns true if the path changed the fact.
    pub(super) fn touched(&self, here: Here, fact: Fact) -> bool {
        self.back(here)
            .take_while(|(_, changes)| effort::spend(1 + changes.len()))
            .any(|(_, changes)| changes.iter().any(|change| change.fact == fact))
    }

    /// Returns the changes of a path, by step.
    pub(super) fn trace(&self, here: Here) -> Trace {
        let mut trace = Trace::default();
        let steps: Vec<_> = self.back(here).collect();
        effort::spend(effort::KEPT * steps.len());
        for (step, changes) in steps.into_iter().rev() {
            trace.add(step, changes);
        }
        trace
    }
}

/// Sets, for each missing fact, the last step on the path that deleted it.
pub(super) fn with_culprits(mut missing: Vec<Missing>, history: &History, here: Here) -> Vec<Missing> {
    for missing in &mut missing {
        let undoes = |change: &Change| Some(change.fact) == missing.fact && change.holds != missing.holds;
        missing.undone_by = history
            .back(here)
            .take_while(|(_, changes)| effort::spend(1 + changes.len()))
            .find(|(_, changes)| changes.iter().any(undoes))
            .map(|(step, _)| step.index());
    }
    missing
}
