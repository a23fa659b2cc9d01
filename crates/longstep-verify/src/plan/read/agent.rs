//! The steps of an agent that writes the action and its input on lines of their own: `Action: Grab`, `Action Input: {"item": "cup"}`.

use super::FoundPlan;
use super::objects::no_step;
use super::step_value::step_with_input;
use super::unreadable::Unreadable;
use longstep_model::literal::{self, FENCE, LeniencyKind, LiteralValue, Notes};

const ACTION: &str = "Action:";
const INPUT: &str = "Action Input:";

/// The labels that end an input.
const LABELS: [&str; 4] = [ACTION, "Observation:", "Thought:", "Final Answer:"];

/// Finds the steps of an agent; none if no line is an input.
pub(super) fn find(text: &str) -> Option<Result<FoundPlan, Unreadable>> {
    let label = |line: &str| line.trim_start().trim_start_matches(['*', '#', ' ']).replace("**", "");
    let mut action: Option<(usize, String)> = None;
    let mut input: Option<String> = None;
    let mut first = None;
    let mut steps = Vec::new();
    if !text.lines().any(|line| label(line).starts_with(INPUT)) {
        return None;
    }
    let mut at = 0;
    let ends = text.split_inclusive('\n').map(Some).chain([None]);
    for line in ends {
        let start = at;
        at += line.map_or(0, str::len);
        let bare = line.map(label);
        let is_end = bare
            .as_ref()
            .is_none_or(|line| LABELS.iter().any(|own| line.starts_with(own)));
        if is_end && let Some((begin, name)) = action.take() {
            let Some(given) = input.take() else {
                return Some(Err(no_step(text, begin, &name)));
            };
            let given = given
                .trim()
                .trim_start_matches(FENCE)
                .trim_start_matches("json")
                .trim_end_matches(FENCE);
            let value = if given.trim_start().starts_with(['{', '[', '"']) {
                literal::whole(given).map(|literal| literal.node.value)
            } else {
                Ok(LiteralValue::Text(given.trim().to_owned()))
            };
            let step = value.ok().and_then(|value| step_with_input(&name, &value));
            let Some(step) = step else {
                return Some(Err(no_step(text, begin, &format!("{name} {given}"))));
            };
            first.get_or_insert(begin);
            steps.push(step);
        }
        let Some(bare) = bare else { break };
        if let Some(given) = bare.strip_prefix(INPUT) {
            input = Some(given.to_owned());
        } else if let Some(name) = bare.strip_prefix(ACTION) {
            action = Some((start, name.trim().to_owned()));
        } else if let Some(given) = &mut input {
            given.push_str(line.unwrap_or_default());
        }
    }
    let start = first?;
    let mut notes = Notes::default();
    notes.add(LeniencyKind::Notation("the steps of an agent"), start);
    Some(FoundPlan::of_steps(text, steps, start, notes))
}
