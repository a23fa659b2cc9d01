//! Transfer of a repaired path to the draft.

use super::super::{Edit, EditKind};
use super::draft::{Draft, Item, Part};
use super::path::ExecutionPath;
use longstep_verify::plan::Step;

impl Draft {
    /// Applies the edits of a repaired path to the draft.
    pub(super) fn settle(&mut self, path: &ExecutionPath, steps: &[Step], edits: &[Edit]) {
        let place_of = |edit: &Edit| edit.step;
        let gone: Vec<usize> = edits
            .iter()
            .filter(|edit| edit.kind != EditKind::Insert)
            .map(place_of)
            .collect();
        // The steps of the repaired path that no edit concerns are those of the draft, in the same order.
        let mut kept = (0..path.steps.len()).filter(|place| !gone.contains(place));
        for edit in edits
            .iter()
            .filter(|edit| matches!(edit.kind, EditKind::Drop | EditKind::Move))
        {
            let (number, block) = path.steps[edit.step];
            if let Some(block) = block {
                self.blocks[block].retain(|part| !matches!(part, Part::Step(other) if *other == number));
            }
            if edit.kind == EditKind::Drop {
                let item = &self.items[number];
                let next = path.steps[edit.step + 1..].iter().map(|(number, _)| *number);
                let next = next.into_iter().next();
                self.dropped
                    .push((item.from, item.written.clone(), edit.why.clone(), next));
            }
        }
        for (at, step) in steps.iter().enumerate() {
            let edit = edits.iter().find(|edit| edit.at == at && edit.kind != EditKind::Drop);
            let number = match edit {
                None => kept.next().map(|place| path.steps[place].0),
                Some(edit) if edit.kind == EditKind::Replace => {
                    let number = path.steps[edit.step].0;
                    self.items[number].edit = Some((EditKind::Replace, edit.why.clone()));
                    Some(number)
                }
                Some(edit) => {
                    // It goes before the next step of the path that keeps its position.
                    let next = kept.clone().next().map(|place| path.steps[place]);
                    let from = match edit.kind {
                        EditKind::Move => self.items[path.steps[edit.step].0].from,
                        _ => next.map_or_else(|| self.end(), |(number, _)| self.items[number].from),
                    };
                    self.items.push(Item {
                        step: step.into(),
                        bound: step.arguments.clone(),
                        written: edit.before.clone().unwrap_or_default(),
                        from,
                        edit: Some((edit.kind, edit.why.clone())),
                        settled: true,
                    });
                    let new = self.items.len() - 1;
                    self.put_before(new, next, path.last);
                    Some(new)
                }
            };
            if let Some(number) = number {
                let item = &mut self.items[number];
                item.step = step.into();
                item.bound.clone_from(&step.arguments);
                item.settled = true;
            }
        }
    }

    /// Returns one more than the last step number of the draft.
    fn end(&self) -> usize {
        let own = self.items.iter().filter_map(Item::drafted);
        own.map(|number| number + 1).max().unwrap_or(0)
    }

    fn put_before(&mut self, new: usize, next: Option<(usize, Option<usize>)>, last: usize) {
        let Some((next, block)) = next else {
            return self.blocks[last].push(Part::Step(new));
        };
        let blocks = match block {
            Some(block) => block..block + 1,
            None => 0..self.blocks.len(),
        };
        for block in blocks {
            // For a step of a condition, the new step goes before the branch or loop.
            if let Some(place) = self.blocks[block].iter().position(|part| part.executes(next)) {
                return self.blocks[block].insert(place, Part::Step(new));
            }
        }
    }
}
