//! Feedback for a model on its plan.

use crate::environment::{Voice, World};
use crate::plan::Step;
use crate::repair::Edit;
use crate::verify::Violation;
use crate::visible;

/// Renders feedback: the violations, with the model's identifiers, and the edits of the cheapest repair if one is
/// known.
///
/// `steps` are those of the resolved plan; `length` is the number of steps as written.
pub(crate) fn feedback(
    world: &World,
    violations: &[Violation],
    steps: &[Step],
    length: usize,
    edits: &[Edit],
) -> String {
    let mut text = String::from("This plan cannot be carried out as it is.\n");
    for violation in violations {
        let message = violation.message_in(Voice::Model, world, steps, None);
        text.push_str(&format!("- {}\n", visible::line(&message)));
    }
    if !edits.is_empty() {
        text.push_str("The smallest change that makes it work:\n");
        for edit in edits {
            text.push_str(&format!("- {}\n", visible::line(&edit.description(length))));
        }
    }
    text.push_str("Answer with the whole plan again, in the same format.\n");
    text
}
