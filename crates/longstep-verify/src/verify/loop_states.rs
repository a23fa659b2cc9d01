//! The states of a loop: those at the start of its iterations, and the transitions between them.

use rustc_hash::FxHashMap;

use super::path::ExecutionPath;
use longstep_model::effort;
use longstep_model::model::{ChangedLists, State};

/// The states at the start of a loop iteration.
#[derive(Default)]
pub(super) struct LoopStates {
    numbers: FxHashMap<ChangedLists, usize>,
    pub(super) paths: Vec<ExecutionPath>,
    /// Number of states that have been followed.
    followed: usize,
    /// By state: true if the loop can end there.
    pub(super) leaves: Vec<bool>,
    /// Transitions between the states by an iteration.
    pub(super) follows: Vec<(usize, usize)>,
}

impl LoopStates {
    pub(super) fn meet(&mut self, path: ExecutionPath, start: &State) -> usize {
        let state = path.state.changed_lists(start);
        if let Some(number) = self.numbers.get(&state) {
            return *number;
        }
        effort::spend(kept_units(&state));
        self.numbers.insert(state, self.paths.len());
        self.paths.push(path);
        self.leaves.push(false);
        self.paths.len() - 1
    }

    pub(super) fn next(&mut self) -> Option<(usize, ExecutionPath)> {
        let path = self.paths.get(self.followed)?.clone();
        self.followed += 1;
        Some((self.followed - 1, path))
    }

    /// Returns a state from which the loop can never end.
    pub(super) fn endless(&self) -> Option<usize> {
        let mut before: Vec<Vec<usize>> = vec![Vec::new(); self.paths.len()];
        for (from, to) in &self.follows {
            before[*to].push(*from);
        }
        let mut ends = self.leaves.clone();
        let mut open: Vec<usize> = (0..ends.len()).filter(|number| ends[*number]).collect();
        while let Some(number) = open.pop() {
            for from in &before[number] {
                if !std::mem::replace(&mut ends[*from], true) {
                    open.push(*from);
                }
            }
        }
        ends.iter().position(|ends| !ends)
    }
}

/// Returns the work units for storing a state: the part that is not shared with the initial state.
pub(super) fn kept_units(state: &ChangedLists) -> usize {
    state.units()
}
