//! What a model is told about its plan.

use crate::environment::{Voice, World};
use crate::model::Domain;
use crate::plan::Step;
use crate::repair::Edit;
use crate::verify::Violation;
use crate::visible;

/// A turn of feedback: what is wrong, in the model's own identifiers, and the smallest change that mends it if one is
/// known.
///
/// `steps` are the plan's, and `length` their number as the model wrote them.
pub(crate) fn feedback(
    domain: &Domain,
    world: &World,
    violations: &[Violation],
    steps: &[Step],
    length: usize,
    edits: &[Edit],
) -> String {
    let mut text = String::from("This plan cannot be carried out as it is.\n");
    for violation in violations {
        let told = violation.message_in(Voice::Model, domain, world, steps, None);
        text.push_str(&format!("- {}\n", visible::line(&told)));
    }
    if !edits.is_empty() {
        text.push_str("The smallest change that makes it work:\n");
        for edit in edits {
            text.push_str(&format!("- {}\n", visible::line(&edit.told(length))));
        }
    }
    text.push_str("Answer with the whole plan again, in the same format.\n");
    text
}
