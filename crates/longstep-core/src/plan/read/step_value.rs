//! Plans and steps inside of values: lists of calls, objects with an action and its arguments, tool calls, and texts.
//!
//! Servers and agent frameworks put a plan under keys of their own (`choices[0].message.tool_calls[0].function.arguments`), so
//! every value is searched, and no list of such paths is kept. The outermost plan counts.

use super::line::step_of_text;
use super::shape::{Likeness, likeness};
use super::unreadable::Unreadable;
use super::{Found, INNERMOST, find};
use crate::call::{Call, NOTATION};
use crate::json::Path;
use crate::literal::{self, Member, Value, ValueNode};
use crate::plan::WrittenStep;

/// Keys under which a list of texts is a list of steps. Under other keys, a list of calls may be goals or states.
const LIST_KEYS: [&str; 20] = [
    "action_list",
    "action_plan",
    "action_sequence",
    "actions",
    "answer",
    "calls",
    "commands",
    "execution_plan",
    "function_calls",
    "output",
    "plan",
    "program",
    "response",
    "result",
    "sequence",
    "skills",
    "steps",
    "task_plan",
    "tasks",
    "tool_calls",
];

/// Keys whose text is an action, or a whole call. An object with one of these needs no key for its arguments.
const ACTION_KEYS: [&str; 9] = [
    "action",
    "action_name",
    "call",
    "command",
    "operator",
    "primitive",
    "skill",
    "step",
    "verb",
];

/// Keys whose text is an action where a key for the arguments stands beside it. Other objects have names too.
const NAME_KEYS: [&str; 6] = [
    "function",
    "function_name",
    "name",
    "recipient_name",
    "tool",
    "tool_name",
];

/// Keys for the arguments of an action.
const ARGUMENT_KEYS: [&str; 9] = [
    "action_input",
    "args",
    "arguments",
    "input",
    "kwargs",
    "objects",
    "parameters",
    "params",
    "tool_input",
];

/// Keys for what a step or a plan says to a person, and for the thoughts of a model. A plan there is a draft.
const EXPLANATION_KEYS: [&str; 12] = [
    "comment",
    "description",
    "explanation",
    "instruction",
    "note",
    "rationale",
    "reason",
    "reasoning",
    "reasoning_content",
    "thinking",
    "thought",
    "thoughts",
];

/// Keys that count steps and name the kind of an object, without a meaning for the plan.
const COUNT_KEYS: [&str; 9] = [
    "id",
    "index",
    "no",
    "number",
    "order",
    "step",
    "step_id",
    "step_number",
    "type",
];

/// A part of a value that may be a plan.
pub(super) enum Candidate<'v> {
    /// An object in the paper's format.
    Plan {
        node: &'v ValueNode,
        path: Path,
        is_part: bool,
    },
    /// A list whose items are all steps.
    Steps { steps: Vec<WrittenStep>, path: Path },
    /// An object that is one step.
    Step(WrittenStep),
    /// A text with a plan in some notation, or with the beginning of one.
    Inner {
        found: Result<Box<Found>, Unreadable>,
        at: usize,
        path: Path,
    },
}

/// Returns the outermost plans and steps of a value, in its order. The value stands `depth` texts deep in the reply; `before` is
/// the text before it.
pub(super) fn candidates<'v>(before: &str, node: &'v ValueNode, depth: usize) -> Vec<Candidate<'v>> {
    let mut search = Search {
        depth,
        found: Vec::new(),
    };
    search.value(node, &Path::default(), may_be_plan(before));
    search.found
}

/// Returns true unless a text before a list calls it something else than a plan: `goals = [...]`.
fn may_be_plan(before: &str) -> bool {
    let line = before.rsplit('\n').next().unwrap_or_default().trim();
    let Some((name, _)) = line.split_once([':', '=']) else {
        return true;
    };
    let name = name.trim().trim_matches(['*', '`', '"']).to_lowercase();
    name.contains(char::is_whitespace) || LIST_KEYS.contains(&name.as_str())
}

struct Search<'v> {
    depth: usize,
    found: Vec<Candidate<'v>>,
}

impl<'v> Search<'v> {
    /// Searches a value; `is_plan` is true if a list there is a list of steps.
    fn value(&mut self, node: &'v ValueNode, path: &Path, is_plan: bool) {
        if let Some(likeness) = likeness(node) {
            self.found.push(Candidate::Plan {
                node,
                path: path.clone(),
                is_part: likeness == Likeness::Part,
            });
            return;
        }
        match &node.value {
            Value::List(items) => {
                if let Some(steps) = step_list(items, is_plan) {
                    let path = path.clone();
                    self.found.push(Candidate::Steps { steps, path });
                    return;
                }
                for (index, item) in items.iter().enumerate() {
                    self.value(item, &path.index(index), false);
                }
            }
            Value::Object(members) if is_environment(members) => {}
            Value::Object(members) => {
                if let Some(step) = step_of_object(members) {
                    self.found.push(Candidate::Step(step));
                    return;
                }
                let spoken = |member: &&Member| EXPLANATION_KEYS.contains(&member.key.as_str());
                for Member { key, node, .. } in members.iter().filter(|member| !spoken(member)) {
                    let is_plan = LIST_KEYS.contains(&key.as_str());
                    self.value(node, &path.push(&literal::shorten(key)), is_plan);
                }
            }
            Value::Text(text) => self.text(text, node.at, path),
            Value::Null | Value::Bool(_) | Value::Number(_) => {}
        }
    }

    /// Searches a text of several lines or with brackets, as servers and frameworks put replies into JSON.
    fn text(&mut self, text: &str, at: usize, path: &Path) {
        if self.depth + 1 >= INNERMOST || !text.contains(['\n', '{', '[']) {
            return;
        }
        let found = match find(text, self.depth + 1) {
            Ok(found) => Ok(Box::new(found)),
            // A text without a plan is a text.
            Err(
                Unreadable::Refusal { .. }
                | Unreadable::Empty
                | Unreadable::NoPlan { .. }
                | Unreadable::OnlyThoughts
                | Unreadable::NoStep { .. }
                | Unreadable::Script { .. }
                | Unreadable::Foreign { .. },
            ) => return,
            Err(error) => Err(error),
        };
        let path = path.clone();
        self.found.push(Candidate::Inner { found, at, path });
    }
}

/// Returns true for an environment, whose states are calls and no steps.
fn is_environment(members: &[Member]) -> bool {
    let keys = ["assets", "asset_states", "objects", "object_states"];
    members
        .iter()
        .filter(|member| keys.contains(&member.key.as_str()))
        .count()
        >= 2
}

/// Returns the steps of a list if all its items are steps. Texts, tuples and objects of one key are steps in a plan only.
fn step_list(items: &[ValueNode], is_plan: bool) -> Option<Vec<WrittenStep>> {
    if items.is_empty() {
        return None;
    }
    let step = |item: &ValueNode| match &item.value {
        Value::Object(members) => step_of_object(members).or_else(|| step_of_pair(members).filter(|_| is_plan)),
        Value::Text(text) if is_plan => step_of_text(text),
        Value::List(parts) if is_plan => step_of_tuple(parts),
        _ => None,
    };
    items.iter().map(step).collect()
}

/// Returns the step of an object with an action and its arguments.
fn step_of_object(members: &[Member]) -> Option<WrittenStep> {
    let has_key = |member: &Member, keys: &[&str]| keys.contains(&member.key.as_str());
    let given = members.iter().find(|member| has_key(member, &ARGUMENT_KEYS));
    let step_with = |keys: &[&str]| {
        let mut keyed = members.iter().filter(|member| has_key(member, keys));
        keyed.find_map(|member| match &member.node.value {
            Value::Text(text) => Some((member, bare_step(text).or_else(|| step_of_text(text))?)),
            _ => None,
        })
    };
    let (own, mut step) = step_with(&ACTION_KEYS).or_else(|| given.and(step_with(&NAME_KEYS)))?;
    let is_whole = matches!(&own.node.value, Value::Text(text) if bare_step(text).is_none());
    let mut spoken = members.iter().filter(|member| has_key(member, &EXPLANATION_KEYS));
    if let Some(Value::Text(text)) = spoken.next().map(|member| &member.node.value)
        && step.explanation.is_empty()
    {
        step.explanation.clone_from(text);
    }
    let without_meaning = [&EXPLANATION_KEYS[..], &COUNT_KEYS, &NAME_KEYS].concat();
    match given {
        _ if is_whole => {}
        Some(member) => add_arguments(&mut step, &member.node.value)?,
        None => {
            let named = members.iter().filter(|member| {
                !std::ptr::eq(*member, own) && !has_key(member, &without_meaning) && member.node.value != Value::Null
            });
            for member in named {
                step.implicit.push((member.key.clone(), argument(&member.node.value)?));
            }
        }
    }
    Some(step)
}

/// Returns the step of an object that has only an action with its arguments: `{"Grab": "<cup>"}`.
fn step_of_pair(members: &[Member]) -> Option<WrittenStep> {
    let [Member { key, node, .. }] = members else {
        return None;
    };
    let mut step = bare_step(key)?;
    add_arguments(&mut step, &node.value)?;
    Some(step)
}

/// Returns the step of a list with the action first: `("Grab", "<cup>")`.
fn step_of_tuple(parts: &[ValueNode]) -> Option<WrittenStep> {
    let (action, rest) = parts.split_first()?;
    let Value::Text(action) = &action.value else {
        return None;
    };
    let mut step = bare_step(action)?;
    match rest {
        [only] => add_arguments(&mut step, &only.value)?,
        several => {
            for part in several {
                step.call.arguments.push(argument(&part.value)?);
            }
        }
    }
    Some(step)
}

/// Returns a step without arguments.
fn bare_step(action: &str) -> Option<WrittenStep> {
    let action = action.trim();
    let begins = action.starts_with(char::is_alphabetic);
    Some(WrittenStep {
        call: Call::parse(action).ok().filter(|_| begins && !action.contains('('))?,
        implicit: Vec::new(),
        explanation: String::new(),
    })
}

/// Adds arguments in the order of a list, by the names of an object, of such an object in a text, or one alone.
fn add_arguments(step: &mut WrittenStep, value: &Value) -> Option<()> {
    match value {
        Value::Null => {}
        Value::List(items) => {
            for item in items {
                step.call.arguments.push(argument(&item.value)?);
            }
        }
        Value::Object(members) => {
            for Member { key, node, .. } in members {
                match &node.value {
                    Value::List(_) if members.len() == 1 => add_arguments(step, &node.value)?,
                    value => step.implicit.push((key.clone(), argument(value)?)),
                }
            }
        }
        Value::Text(text) if text.trim_start().starts_with('{') => {
            let inner = literal::whole(text).ok()?;
            match &inner.node.value {
                Value::Object(_) => add_arguments(step, &inner.node.value)?,
                _ => return None,
            }
        }
        Value::Text(text) if text.trim().is_empty() => {}
        Value::Text(text) if text.contains(',') => {
            for part in text.split(',') {
                step.call.arguments.push(argument(&Value::Text(part.to_owned()))?);
            }
        }
        value => step.call.arguments.push(argument(value)?),
    }
    Some(())
}

/// Returns the argument of a step: a name or a number.
fn argument(value: &Value) -> Option<String> {
    match value {
        Value::Text(text) => {
            let text = text.trim();
            (!text.is_empty() && !text.contains(NOTATION) && !text.contains(['{', '[', '\n'])).then(|| text.to_owned())
        }
        Value::Number(digits) => Some(digits.clone()),
        _ => None,
    }
}
