//! Changes along the execution paths of a plan.

use rustc_hash::FxHashMap;

use longstep_model::effort;
use longstep_model::model::{Change, Changes, Fact, Fluent, Missing, Number, NumberChange, Shortfall, StepId, Trace};

/// Position in the [`History`]: the last step of an execution path.
pub(super) type Here = Option<u32>;

/// The changes of all execution paths, step by step. Paths share common prefixes, so a branch copies nothing.
#[derive(Debug, Default)]
pub(super) struct History {
    changes: Changes,
    entries: Vec<Entry>,
}

#[derive(Debug)]
struct Entry {
    step: StepId,
    /// The first change of a fact, and the first one of a number.
    begin: (usize, usize),
    end: (usize, usize),
    before: Here,
}

impl History {
    /// Adds a step after `before`; `change` appends its changes.
    pub(super) fn add(&mut self, step: StepId, before: Here, change: impl FnOnce(&mut Changes)) -> Here {
        effort::spend(effort::KEPT);
        let begin = (self.changes.facts.len(), self.changes.numbers.len());
        change(&mut self.changes);
        self.entries.push(Entry {
            step,
            begin,
            end: (self.changes.facts.len(), self.changes.numbers.len()),
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
        self.entries(here)
            .map(|entry| (entry.step, &self.changes.facts[entry.begin.0..entry.end.0]))
    }

    fn entries(&self, here: Here) -> impl Iterator<Item = &Entry> {
        let entry = |here: Here| here.map(|number| &self.entries[number as usize]);
        std::iter::successors(entry(here), move |last| entry(last.before))
    }

    /// Returns the changes of numbers by a step.
    fn numbers(&self, entry: &Entry) -> &[NumberChange] {
        &self.changes.numbers[entry.begin.1..entry.end.1]
    }

    /// Returns true if the last step of the path changed the state.
    pub(super) fn has_changed(&self, here: Here) -> bool {
        self.entries(here).next().is_some_and(|last| last.begin != last.end)
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
        let steps: Vec<&Entry> = self.entries(here).collect();
        effort::spend(effort::KEPT * steps.len());
        for entry in steps.into_iter().rev() {
            let facts = &self.changes.facts[entry.begin.0..entry.end.0];
            trace.add(entry.step, facts, self.numbers(entry));
        }
        trace
    }
}

impl History {
    /// Returns the last step on the path before which the requirement held.
    fn broke(&self, here: Here, shortfall: &Shortfall) -> Option<usize> {
        let mut numbers: FxHashMap<Fluent, Option<Number>> = shortfall.numbers.iter().copied().collect();
        let entries = self.entries(here);
        for entry in entries.take_while(|_| effort::spend(1 + shortfall.numbers.len())) {
            let changes = self
                .numbers(entry)
                .iter()
                .filter(|change| numbers.contains_key(&change.fluent));
            let changes: Vec<NumberChange> = changes.copied().collect();
            for change in &changes {
                numbers.insert(change.fluent, change.before);
            }
            let before = |fluent: &Fluent| numbers.get(fluent).copied().flatten();
            if !changes.is_empty() && shortfall.test.holds(&before) {
                return Some(entry.step.index());
            }
        }
        None
    }
}

/// Sets, for each missing fact, the last step on the path that deleted it.
pub(super) fn with_culprits(mut missing: Vec<Missing>, history: &History, here: Here) -> Vec<Missing> {
    for missing in &mut missing {
        if let Some(shortfall) = missing.number.clone() {
            missing.undone_by = history.broke(here, &shortfall);
            continue;
        }
        let undoes = |change: &Change| Some(change.fact) == missing.fact && change.holds != missing.holds;
        missing.undone_by = history
            .back(here)
            .take_while(|(_, changes)| effort::spend(1 + changes.len()))
            .find(|(_, changes)| changes.iter().any(undoes))
            .map(|(step, _)| step.index());
    }
    missing
}
