//! Findings of the simulation, and their merging.

use rustc_hash::FxHashMap;

use super::Violation;
use longstep_model::effort;
use longstep_model::model::Fact;

/// A finding on one or more paths.
#[derive(Debug, Clone)]
pub(super) struct Finding {
    pub(super) violation: Violation,
    /// True for a warning.
    pub(super) odd: bool,
    /// Sensing outcomes common to the paths with the finding; empty if it occurs on all paths.
    pub(super) when: Vec<Fact>,
}

/// Merges the findings of a loop whenever their number has doubled, since iterations repeat them.
pub(super) struct Findings {
    from: usize,
    most: usize,
}

impl Findings {
    pub(super) fn from(from: usize) -> Self {
        Self { from, most: 256 }
    }

    pub(super) fn compact(&mut self, found: &mut Vec<Finding>) {
        if found.len() - self.from > self.most {
            let together = joined(found.split_off(self.from), None);
            self.most = 2 * together.len().max(128);
            found.extend(together);
        }
    }
}

/// Merges equal findings. A finding becomes unconditional if `count` paths have it or one of them is unconditional;
/// otherwise the common sensing outcomes are kept.
pub(super) fn joined(found: Vec<Finding>, count: Option<usize>) -> Vec<Finding> {
    let mut together: Vec<(Finding, usize)> = Vec::with_capacity(found.len());
    let mut numbers: FxHashMap<(Violation, bool), usize> = FxHashMap::default();
    effort::spend(found.len());
    for next in found {
        let number = *numbers
            .entry((next.violation.clone(), next.odd))
            .or_insert(together.len());
        let Some((known, times)) = together.get_mut(number) else {
            together.push((next, 1));
            continue;
        };
        if !known.when.is_empty() {
            effort::spend(known.when.len());
            let common: Vec<Fact> = known
                .when
                .iter()
                .filter(|fact| next.when.contains(fact))
                .copied()
                .collect();
            // Without a common outcome the first list stays, since an empty one means "on all paths".
            if !common.is_empty() || next.when.is_empty() {
                known.when = common;
            }
        }
        *times += 1;
    }
    for (found, times) in &mut together {
        if count == Some(*times) {
            found.when.clear();
        }
    }
    together.into_iter().map(|(found, _)| found).collect()
}
