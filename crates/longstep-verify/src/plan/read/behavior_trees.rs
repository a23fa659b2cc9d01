//! Behavior trees in a reply: in a code block, or among words.

use super::{FoundPlan, Unreadable, around};
use crate::plan::{PlanFile, TaskCohesion, behavior_tree};
use longstep_model::diagnostic::Position;
use longstep_model::literal::{LeniencyKind, Notes};

/// Finds the behavior tree in a reply; none if nothing in it is meant as one.
pub(super) fn find(text: &str) -> Option<Result<FoundPlan, Unreadable>> {
    let range = behavior_tree::find(text)?;
    Some(read(text, range))
}

fn read(text: &str, range: std::ops::Range<usize>) -> Result<FoundPlan, Unreadable> {
    let start = range.start;
    let found = behavior_tree::read(&text[range.clone()]).map_err(|fault| Unreadable::BehaviorTree {
        position: Position::of(text, start + fault.at),
        message: fault.message,
        hint: fault.hint,
    })?;
    let mut notes = Notes::default();
    around(text, 0..start, &mut notes);
    around(text, range.end..text.len(), &mut notes);
    if let Some(at) = found.check {
        notes.add(LeniencyKind::Check, start + at);
    }
    let fault = found
        .written
        .steps
        .iter()
        .find_map(|step| Some((step.call.to_string(), step.fault()?)));
    if let Some((call, fault)) = fault {
        return Err(Unreadable::Malformed {
            position: Position::of(text, start),
            message: format!("a step of this plan, `{call}`, {fault}"),
        });
    }
    Ok(FoundPlan {
        file: PlanFile::from(TaskCohesion::from_written(found.written)),
        start,
        notes,
    })
}
