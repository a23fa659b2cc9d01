//! Plans and steps inside of values: lists of calls, objects with an action and its arguments, tool calls, and texts.
//!
//! Servers and agent frameworks put a plan under keys of their own (`choices[0].message.tool_calls[0].function.arguments`), so
//! every value is searched, and no list of such paths is kept. The outermost plan counts.

use super::line::step_of_text;
use super::shape::{Likeness, likeness};
use super::unreadable::Unreadable;
use super::{FoundPlan, INNERMOST, find};
use crate::plan::WrittenStep;
use longstep_model::call::{Call, NOTATION};
use longstep_model::json::Path;
use longstep_model::literal::{self, LiteralValue, Member, ValueNode};

/// Keys under which a list of texts is a list of steps. Under other keys, a list of calls may be goals or states.
const LIST_KEYS: [&str; 21] = [
    "action_list",
    "action_plan",
    "action_sequence",
    "actions",
    "answer",
    "calls",
    "commands",
    "executable_plan",
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
pub(super) const ACTION_KEYS: [&str; 9] = [
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
pub(super) const EXPLANATION_KEYS: [&str; 12] = [
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
pub(super) const COUNT_KEYS: [&str; 9] = [
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

/// Keys that change what a step means: what they say cannot be left out.
const MEANING_KEYS: [&str; 18] = [
    "disabled",
    "else",
    "enabled",
    "if",
    "loop",
    "negate",
    "negated",
    "otherwise",
    "repeat",
    "skip",
    "skipped",
    "sub_steps",
    "substeps",
    "then",
    "times",
    "unless",
    "until",
    "while",
];

/// Keys under which a server says why its answer ends.
const END_KEYS: [&str; 4] = ["done_reason", "finish_reason", "status", "stop_reason"];

/// Reasons there for an answer that is not whole.
const NOT_WHOLE: [&str; 5] = [
    "incomplete",
    "length",
    "max_output_tokens",
    "max_tokens",
    "model_context_window_exceeded",
];

/// A part of a value that may be a plan.
pub(super) enum PlanCandidate<'v> {
    /// An object in the paper's format.
    Plan {
        node: &'v ValueNode,
        path: Path,
        is_part: bool,
    },
    /// A list whose items are all steps, with the keys in them that were ignored.
    Steps {
        /// False if its key has words that may say that this is no plan to carry out: `rejected_plan`, `next_steps`.
        is_sure: bool,
        steps: Vec<WrittenStep>,
        ignored: Vec<String>,
        path: Path,
    },
    /// An object that is one step.
    Step(WrittenStep),
    /// A text with a plan in some notation, or with the beginning of one.
    Inner {
        found: Result<Box<FoundPlan>, Unreadable>,
        at: usize,
        path: Path,
    },
    /// Steps that cannot be read without a change of their meaning.
    Refused { at: usize, message: String },
    /// A value whose server says that it is not whole.
    NotWhole { at: usize, key: String, reason: String },
}

/// Returns the outermost plans and steps of a value, in its order. The value stands `depth` texts deep in the reply; `before` is
/// the text before it.
pub(super) fn candidates<'v>(before: &str, node: &'v ValueNode, depth: usize) -> Vec<PlanCandidate<'v>> {
    let mut search = Search {
        depth,
        found: Vec::new(),
    };
    search.value(node, &Path::default(), before_list(before));
    search.found
}

/// Returns what a text before a list calls it: `goals = [...]` is no plan.
fn before_list(before: &str) -> Listed {
    let line = before.rsplit('\n').next().unwrap_or_default().trim();
    let Some((name, _)) = line.split_once([':', '=']) else {
        return Listed::Plan;
    };
    let name = name.trim().trim_matches(['*', '`', '"']).to_lowercase();
    if name.contains(char::is_whitespace) {
        Listed::Plan
    } else {
        list_under(&name)
    }
}

/// Returns a key in lower case with `_` between its words: `actionName` is `action_name`.
pub(super) fn snake_case(key: &str) -> String {
    let mut written = String::with_capacity(key.len() + 4);
    let mut before = '_';
    for letter in key.chars() {
        if letter.is_uppercase() && before.is_lowercase() {
            written.push('_');
        }
        match letter {
            '-' | ' ' => written.push('_'),
            _ => written.extend(letter.to_lowercase()),
        }
        before = letter;
    }
    written
}

/// Returns true for one of the keys, as it is or with words before it: `executable_plan`, `actionParameters`.
fn ends_with_key(key: &str, keys: &[&str]) -> bool {
    let key = snake_case(key);
    let last = key.rsplit('_').next().unwrap_or_default();
    keys.contains(&key.as_str()) || keys.contains(&last)
}

/// Returns what the values under a key may be.
fn list_under(key: &str) -> Listed {
    match LIST_KEYS.contains(&snake_case(key).as_str()) {
        true => Listed::Plan,
        false if ends_with_key(key, &LIST_KEYS) => Listed::PerhapsPlan,
        false => Listed::Other,
    }
}

/// The meaning of a list, by the key before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Listed {
    /// Its texts are steps.
    Plan,
    /// Its texts are steps, but perhaps of no plan to carry out.
    PerhapsPlan,
    /// Its objects may be steps; its texts may be goals or states.
    Other,
}

fn has_key(member: &Member, keys: &[&str]) -> bool {
    keys.contains(&snake_case(&member.key).as_str())
}

fn is_arguments(member: &Member) -> bool {
    ends_with_key(&member.key, &ARGUMENT_KEYS)
}

struct Search<'v> {
    depth: usize,
    found: Vec<PlanCandidate<'v>>,
}

impl<'v> Search<'v> {
    /// Searches a value; `listed` is what a list there may be.
    fn value(&mut self, node: &'v ValueNode, path: &Path, listed: Listed) {
        if let Some(likeness) = likeness(node) {
            self.found.push(PlanCandidate::Plan {
                node,
                path: path.clone(),
                is_part: likeness == Likeness::Part,
            });
            return;
        }
        match &node.value {
            LiteralValue::List(items) => {
                if let Some(steps) = step_list(items, listed != Listed::Other) {
                    self.steps(steps, &items.iter().collect::<Vec<_>>(), path, listed);
                    return;
                }
                for (index, item) in items.iter().enumerate() {
                    self.value(item, &path.index(index), Listed::Other);
                }
            }
            LiteralValue::Object(members) if is_environment(members) => {}
            LiteralValue::Object(members) => {
                if let Some(step) = step_of_object(members) {
                    self.found.push(match fault_of_steps(&[node]) {
                        Some((at, message)) => PlanCandidate::Refused { at, message },
                        None => PlanCandidate::Step(step),
                    });
                    return;
                }
                if let Some(items) = counted(members)
                    && let Some(steps) = items.iter().map(|item| step(item, true)).collect()
                {
                    self.steps(steps, &items, path, listed);
                    return;
                }
                let spoken = |member: &&Member| has_key(member, &EXPLANATION_KEYS);
                for Member { key, node, .. } in members.iter().filter(|member| !spoken(member)) {
                    if let LiteralValue::Text(reason) = &node.value
                        && END_KEYS.contains(&snake_case(key).as_str())
                        && NOT_WHOLE.contains(&reason.to_lowercase().as_str())
                    {
                        self.found.push(PlanCandidate::NotWhole {
                            at: node.at,
                            key: key.clone(),
                            reason: reason.clone(),
                        });
                    }
                    self.value(node, &path.push(&literal::shorten(key)), list_under(key));
                }
            }
            LiteralValue::Text(text) => self.text(text, node.at, path),
            LiteralValue::Null | LiteralValue::Bool(_) | LiteralValue::Number(_) => {}
        }
    }

    /// Adds the steps of a list, which its items are.
    fn steps(&mut self, steps: Vec<WrittenStep>, items: &[&ValueNode], path: &Path, listed: Listed) {
        self.found.push(match fault_of_steps(items) {
            Some((at, message)) => PlanCandidate::Refused { at, message },
            None => PlanCandidate::Steps {
                is_sure: listed != Listed::PerhapsPlan,
                steps,
                ignored: ignored_keys(items),
                path: path.clone(),
            },
        });
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
        self.found.push(PlanCandidate::Inner { found, at, path });
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
    items.iter().map(|item| step(item, is_plan)).collect()
}

/// Returns the step that a value is; a text, a tuple and an object of one key are steps in a plan only.
fn step(item: &ValueNode, is_plan: bool) -> Option<WrittenStep> {
    match &item.value {
        LiteralValue::Object(members) => step_of_object(members).or_else(|| step_of_pair(members).filter(|_| is_plan)),
        LiteralValue::Text(text) if is_plan => step_of_text(text),
        LiteralValue::List(parts) if is_plan => step_of_tuple(parts),
        _ => None,
    }
}

/// Returns the values of an object whose keys count from 1: `{"step_1": ..., "step_2": ...}`.
fn counted(members: &[Member]) -> Option<Vec<&ValueNode>> {
    let mut values = Vec::with_capacity(members.len());
    for (index, Member { key, node, .. }) in members.iter().enumerate() {
        let number = key.trim_start_matches(|c: char| !c.is_ascii_digit());
        if number.parse() != Ok(index + 1) {
            return None;
        }
        values.push(node);
    }
    (!values.is_empty()).then_some(values)
}

/// Returns true for a member of a step that is neither its action nor an argument of it, and that a plan has no place for.
fn is_beside_step(members: &[Member], member: &Member) -> bool {
    let is_given =
        |own: &Member| is_arguments(own) || matches!(&own.node.value, LiteralValue::Text(text) if text.contains('('));
    let keys = [&ACTION_KEYS[..], &NAME_KEYS, &EXPLANATION_KEYS, &COUNT_KEYS];
    members.iter().any(is_given) && !is_arguments(member) && !keys.iter().any(|keys| has_key(member, keys))
}

/// Returns the first thing about the steps of a list that cannot be left out: keys that change what a step means, steps inside of
/// steps, and numbers in another order.
fn fault_of_steps(items: &[&ValueNode]) -> Option<(usize, String)> {
    let mut last: Option<(&str, f64)> = None;
    for item in items {
        let LiteralValue::Object(members) = &item.value else {
            continue;
        };
        for member in members {
            let Member { key, node, .. } = member;
            if let LiteralValue::Number(digits) = &node.value
                && has_key(member, &COUNT_KEYS)
                && let Ok(number) = digits.parse::<f64>()
            {
                if last.is_some_and(|(name, before)| name == key && number <= before) {
                    let message = format!("`{key}` is {digits}, so this step does not follow the one before it");
                    return Some((node.at, message));
                }
                last = Some((key, number));
            }
            if has_key(member, &MEANING_KEYS) && !says_nothing(key, &node.value) {
                return Some((
                    node.at,
                    format!("`{key}` changes what a step means, and a list of steps cannot say it"),
                ));
            }
            let has_steps = |items: &[ValueNode]| step_list(items, true).is_some();
            if is_beside_step(members, member)
                && matches!(&node.value, LiteralValue::List(items) if has_steps(items))
                && snake_case(key) != "preconditions"
            {
                return Some((node.at, format!("there are steps in a step, under `{key}`")));
            }
        }
    }
    None
}

/// Returns true if the value of a key that changes a step's meaning leaves it as it is.
fn says_nothing(key: &str, value: &LiteralValue) -> bool {
    match value {
        LiteralValue::Null => true,
        LiteralValue::Bool(is_set) => *is_set == (snake_case(key) == "enabled"),
        LiteralValue::Number(digits) => digits == "1" || (digits == "0" && !matches!(key, "times" | "repeat")),
        LiteralValue::Text(text) => text.trim().is_empty(),
        LiteralValue::List(items) => items.is_empty(),
        LiteralValue::Object(members) => members.is_empty(),
    }
}

/// Returns the keys of steps that have no place in a plan.
fn ignored_keys(items: &[&ValueNode]) -> Vec<String> {
    let mut ignored: Vec<String> = Vec::new();
    for item in items {
        let LiteralValue::Object(members) = &item.value else {
            continue;
        };
        for member in members {
            let is_known = ignored.contains(&member.key) || has_key(member, &MEANING_KEYS);
            if !is_known && is_beside_step(members, member) && member.node.value != LiteralValue::Null {
                ignored.push(member.key.clone());
            }
        }
    }
    ignored.truncate(MOST_IGNORED);
    ignored
}

/// The number of ignored keys that are told.
const MOST_IGNORED: usize = 8;

/// Returns the step of an object with an action and its arguments.
fn step_of_object(members: &[Member]) -> Option<WrittenStep> {
    let given = members.iter().find(|member| is_arguments(member));
    let step_with = |keys: &[&str]| {
        let mut keyed = members
            .iter()
            .filter(|member| has_key(member, keys) && !is_arguments(member));
        keyed.find_map(|member| match &member.node.value {
            LiteralValue::Text(text) => Some((member, bare_step(text).or_else(|| step_of_text(text))?)),
            _ => None,
        })
    };
    let (own, mut step) = step_with(&ACTION_KEYS).or_else(|| given.and(step_with(&NAME_KEYS)))?;
    let is_whole = matches!(&own.node.value, LiteralValue::Text(text) if bare_step(text).is_none());
    let mut spoken = members.iter().filter(|member| has_key(member, &EXPLANATION_KEYS));
    if let Some(LiteralValue::Text(text)) = spoken.next().map(|member| &member.node.value)
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
                !std::ptr::eq(*member, own)
                    && !has_key(member, &without_meaning)
                    && member.node.value != LiteralValue::Null
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
    let LiteralValue::Text(action) = &action.value else {
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

/// Returns the step of an action whose input is a value.
pub(super) fn step_with_input(action: &str, input: &LiteralValue) -> Option<WrittenStep> {
    let mut step = bare_step(action)?;
    add_arguments(&mut step, input)?;
    Some(step)
}

/// Returns a step without arguments.
pub(super) fn bare_step(action: &str) -> Option<WrittenStep> {
    let action = action.trim();
    let begins = action.starts_with(char::is_alphabetic);
    let call = Call::parse(action).ok().filter(|_| begins && !action.contains('('));
    call.map(WrittenStep::of_call)
}

/// Adds arguments in the order of a list, by the names of an object, of such an object in a text, or one alone.
pub(super) fn add_arguments(step: &mut WrittenStep, value: &LiteralValue) -> Option<()> {
    match value {
        LiteralValue::Null => {}
        LiteralValue::List(items) => {
            for item in items {
                step.call.arguments.push(argument(&item.value)?);
            }
        }
        LiteralValue::Object(members) => {
            for Member { key, node, .. } in members {
                match &node.value {
                    LiteralValue::List(_) if members.len() == 1 => add_arguments(step, &node.value)?,
                    value => step.implicit.push((key.clone(), argument(value)?)),
                }
            }
        }
        LiteralValue::Text(text) if text.trim_start().starts_with('{') => {
            let inner = literal::whole(text).ok()?;
            match &inner.node.value {
                LiteralValue::Object(_) => add_arguments(step, &inner.node.value)?,
                _ => return None,
            }
        }
        LiteralValue::Text(text) if text.trim().is_empty() => {}
        LiteralValue::Text(text) if text.contains(',') => {
            for part in text.split(',') {
                step.call
                    .arguments
                    .push(argument(&LiteralValue::Text(part.to_owned()))?);
            }
        }
        value => step.call.arguments.push(argument(value)?),
    }
    Some(())
}

/// Returns the argument of a step: a name or a number.
fn argument(value: &LiteralValue) -> Option<String> {
    match value {
        LiteralValue::Text(text) => {
            let text = text.trim();
            (!text.is_empty() && !text.contains(NOTATION) && !text.contains(['{', '[', '\n'])).then(|| text.to_owned())
        }
        LiteralValue::Number(digits) => Some(digits.clone()),
        _ => None,
    }
}
