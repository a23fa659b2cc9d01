//! Reader for model replies and plan files: extracts a plan from text.
//!
//! The reader is lenient about form and lists every leniency; it is strict about content and guesses nothing. Each notation has one
//! reader ([`NOTATIONS`]); a text that two of them read differently is refused. Strict JSON produces no leniencies.

mod agent;
mod behavior_trees;
mod columns;
mod line;
mod lines;
mod objects;
mod scripts;
mod shape;
mod step_value;
mod stray;
#[cfg(test)]
mod tests;
mod thoughts;
mod tokens;
mod unreadable;
mod yaml;

pub use longstep_model::literal::{Leniency, LeniencyKind};
pub use unreadable::Unreadable;

use std::ops::Range;

use super::{Node, PlanFile, StepId, TaskCohesion, Written, WrittenStep};
use longstep_model::diagnostic::Position;
use longstep_model::json::Path;
use longstep_model::literal::{FENCE, Notes, PLAN_KEYS};
use unreadable::LARGEST;

/// A plan from a model's reply.
#[derive(Debug, Clone, PartialEq)]
pub struct Draft {
    /// The plan; its steps are not resolved.
    pub file: PlanFile,
    /// The deviations from the plan format, in text order.
    pub leniencies: Vec<Leniency>,
}

/// Extracts the plan from a model's reply or from a plan file.
///
/// The plan is an object in the paper's format, as JSON, as a Python literal or as YAML; a list of calls, or of objects with an action
/// and its arguments; a tool call, whose arguments are the plan or a step; a script (see [`super::script`]); a list or table of
/// calls; a VirtualHome script; or a behavior tree in XML. It may stand alone or inside prose and a code block. Takes time linear in the length of the text.
///
/// # Errors
///
/// [`Unreadable`] if the reply contains no plan, several different plans, or a plan that is truncated, malformed or of
/// the wrong type.
///
/// ```
/// use longstep_verify::plan::{Unreadable, read};
///
/// let reply = "Sure!\n```python\n{'task_cohesion': {'task_sequence': ['move_hand()'],\n\
///     'step_instructions': ['move the robot's hand near the cup']}}\n```";
/// let draft = read(reply).unwrap();
/// assert_eq!(draft.file.task_cohesion.step_instructions, ["move the robot's hand near the cup"]);
/// assert_eq!(draft.leniencies[0].message(), "line 1, column 1: words around the plan were ignored");
///
/// let cut_off = read(&reply[..100]).unwrap_err();
/// assert!(matches!(cut_off, Unreadable::CutOff { .. }));
///
/// let listed = read("1. **Walk(<desk>)** - go there\n2. `Grab(<pen>)`").unwrap();
/// assert_eq!(listed.file.task_cohesion.task_sequence, ["Walk(<desk>)", "Grab(<pen>)"]);
/// assert_eq!(listed.leniencies[0].message(), "line 1, column 1: the plan was read as a numbered list");
/// ```
pub fn read(text: &str) -> Result<Draft, Unreadable> {
    let found = find(text, 0)?;
    Ok(Draft {
        file: found.file,
        leniencies: found.notes.into_leniencies(text),
    })
}

/// A plan in a text.
#[derive(Debug)]
struct FoundPlan {
    file: PlanFile,
    start: usize,
    notes: Notes,
}

impl FoundPlan {
    /// Creates a plan of steps one after another, which stand at `start` of the text.
    ///
    /// # Errors
    ///
    /// [`Unreadable::Malformed`] if the plan needs a tree, because steps name their parameters, and a step cannot stand in one.
    fn of_steps(text: &str, steps: Vec<WrittenStep>, start: usize, notes: Notes) -> Result<Self, Unreadable> {
        let body = (0..steps.len()).map(|index| Node::Step(StepId::new(index))).collect();
        let objects = Vec::new();
        let written = Written { steps, body, objects };
        let fault = written
            .steps
            .iter()
            .find_map(|step| Some((step.call.to_string(), step.fault()?)));
        let task_cohesion = TaskCohesion::from_written(written);
        match fault {
            Some((call, fault)) if task_cohesion.task_tree.is_some() => Err(Unreadable::Malformed {
                position: Position::of(text, start),
                message: format!("a step of this plan, `{call}`, {fault}"),
            }),
            _ => Ok(Self {
                file: PlanFile::from(task_cohesion),
                start,
                notes,
            }),
        }
    }

    /// Returns true if both plans have the same steps, whatever their explanations.
    fn has_steps_of(&self, other: &Self) -> bool {
        let (own, other) = (&self.file.task_cohesion, &other.file.task_cohesion);
        let bare = |steps: Vec<WrittenStep>| {
            steps
                .into_iter()
                .map(|step| (step.call, step.implicit))
                .collect::<Vec<_>>()
        };
        match (own.written(), other.written()) {
            (Ok(own), Ok(other)) if own.is_sequence() && other.is_sequence() => bare(own.steps) == bare(other.steps),
            (Ok(own), Ok(other)) => own.body == other.body && bare(own.steps) == bare(other.steps),
            _ => own.task_sequence == other.task_sequence,
        }
    }
}

/// A notation of plans outside of JSON and Python literals.
struct Notation {
    /// The noun for messages.
    name: &'static str,
    /// Finds the plan that a text has in this notation; none if nothing in the text is meant as one.
    find: fn(&str) -> Option<Result<FoundPlan, Unreadable>>,
}

const NOTATIONS: [Notation; 4] = [
    Notation {
        name: "a script",
        find: scripts::find,
    },
    Notation {
        name: "a list of calls",
        find: lines::find,
    },
    Notation {
        name: "a table with columns",
        find: columns::find,
    },
    Notation {
        name: "YAML",
        find: yaml::find,
    },
];

/// Maximum depth of texts with plans inside of values.
const INNERMOST: usize = 4;

/// Finds the plan of a text that stands `depth` texts deep in a reply.
fn find(text: &str, depth: usize) -> Result<FoundPlan, Unreadable> {
    if text.len() > LARGEST {
        return Err(Unreadable::TooLarge {
            bytes: text.len(),
            limit: LARGEST,
        });
    }
    if let Some(inner) = quoted(text).filter(|_| depth + 1 < INNERMOST) {
        let found = find(&inner, depth + 1).map_err(|error| Unreadable::Inside {
            position: Position::of(text, text.len() - text.trim_start().len()),
            path: Path::default(),
            error: Box::new(error),
        })?;
        let mut notes = Notes::default();
        notes.add(LeniencyKind::Quoted, 0);
        found
            .notes
            .notations()
            .for_each(|name| notes.add(LeniencyKind::Notation(name), 0));
        return Ok(FoundPlan {
            start: 0,
            notes,
            ..found
        });
    }
    if let Some(found) = behavior_trees::find(text) {
        return found;
    }
    let (answer, thoughts) = thoughts::blanked(text);
    let answer = thoughts::blank(&answer, &tokens::ranges(&answer));
    if thoughts.is_some() && answer.trim().is_empty() {
        return Err(Unreadable::OnlyThoughts);
    }
    let mut found = find_in_answer(&answer, depth)?;
    if let Some(at) = thoughts {
        found.notes.add(LeniencyKind::Thoughts, at);
    }
    Ok(found)
}

/// Returns the content of a reply that is one text in JSON's quotes.
fn quoted(text: &str) -> Option<String> {
    let text = text.trim();
    text.starts_with('"').then(|| serde_json::from_str(text).ok()).flatten()
}

fn find_in_answer(text: &str, depth: usize) -> Result<FoundPlan, Unreadable> {
    // Its inputs are objects, which are no plans by themselves.
    if let Some(found) = agent::find(text) {
        return found;
    }
    let survey = match objects::survey(text, depth) {
        // Without any plan key, the broken object was not meant as a plan in JSON.
        Err(error) if PLAN_KEYS.iter().any(|key| text.contains(key)) => return Err(error),
        survey => survey,
    };
    // A broken object is not read line by line.
    let is_whole = survey.as_ref().is_ok_and(|survey| survey.broken.is_none());
    let notations = if is_whole { &NOTATIONS[..] } else { &NOTATIONS[..1] };
    let outside = match &survey {
        Ok(survey) => thoughts::blank(text, &survey.read),
        Err(_) => text.into(),
    };
    let mut readings: Vec<(&str, Result<FoundPlan, Unreadable>)> = Vec::new();
    let rest = match survey {
        Ok(survey) => match survey.plan(text) {
            Ok(read) => {
                readings.push(("JSON", read));
                None
            }
            Err(none) => Some(none),
        },
        Err(error) => Some(error),
    };
    let others = notations
        .iter()
        .filter_map(|notation| Some((notation.name, (notation.find)(&outside)?)));
    readings.extend(others);
    if readings.is_empty()
        && !matches!(rest, Some(Unreadable::CutOff { .. } | Unreadable::Malformed { .. }))
        && let Some(what) = foreign(text)
    {
        return Err(Unreadable::Foreign { what });
    }
    chosen(text, readings).unwrap_or_else(|| Err(rest.unwrap_or(Unreadable::Empty)))
}

/// Returns the plan on which all readings agree that are plans; the first error if none is one; none without a reading.
fn chosen(
    text: &str,
    readings: Vec<(&'static str, Result<FoundPlan, Unreadable>)>,
) -> Option<Result<FoundPlan, Unreadable>> {
    let mut error = None;
    let mut plan: Option<(&'static str, FoundPlan)> = None;
    for (name, reading) in readings {
        match (reading, &plan) {
            (Ok(found), None) => plan = Some((name, found)),
            (Ok(found), Some((first, before))) if !before.has_steps_of(&found) => {
                return Some(Err(Unreadable::SeveralReadings {
                    first,
                    position: Position::of(text, before.start),
                    other: name,
                    other_position: Position::of(text, found.start),
                }));
            }
            (Ok(_), Some(_)) => {}
            // Several plans in JSON stay several, whatever stands beside them.
            (Err(several @ Unreadable::SeveralPlans { .. }), _) => return Some(Err(several)),
            (Err(first), _) => {
                error.get_or_insert(first);
            }
        }
    }
    match (plan, error) {
        (Some((_, found)), _) => Some(Ok(found)),
        (None, error) => error.map(Err),
    }
}

/// Returns the name of a notation that has plans and is not read.
fn foreign(text: &str) -> Option<&'static str> {
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let is_xml = text.starts_with("<?xml") || (text.starts_with('<') && (text.contains("</") || text.contains("/>")));
    is_xml.then_some("XML")
}

/// A code block; positions are byte offsets.
struct Block {
    opened: usize,
    inside: Range<usize>,
    closed: bool,
}

/// Iterates over the code blocks of a text.
fn blocks(text: &str) -> impl Iterator<Item = Block> {
    let mut at = 0;
    std::iter::from_fn(move || {
        let opened = at + text[at..].find(FENCE)?;
        // The rest of the line after an opening fence is the language.
        let start = text[opened..].find('\n').map_or(text.len(), |end| opened + end + 1);
        let end = text[start..].find(FENCE).map(|end| start + end);
        at = end.map_or(text.len(), |end| end + FENCE.len());
        Some(Block {
            opened,
            inside: start..end.unwrap_or(text.len()),
            closed: end.is_some(),
        })
    })
}

/// Records the leniencies outside of objects: code blocks, assignments and prose.
fn around(text: &str, gap: Range<usize>, notes: &mut Notes) {
    let mut at = gap.start;
    loop {
        let rest = &text[at..gap.end];
        let fence = rest.find(FENCE);
        words(text, at..at + fence.unwrap_or(rest.len()), notes);
        let Some(fence) = fence else {
            return;
        };
        notes.add(LeniencyKind::CodeFence, at + fence);
        at += fence + FENCE.len();
        let after = &text[at..gap.end];
        let language = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '+');
        at += after.len() - after.trim_start_matches(language).len();
    }
}

fn words(text: &str, piece: Range<usize>, notes: &mut Notes) {
    let byte_order_mark = |c: char| c == '\u{feff}';
    let blank = |c: char| c.is_whitespace() || byte_order_mark(c);
    if let Some(mark) = text[piece.clone()].find(byte_order_mark) {
        notes.add(LeniencyKind::OddSpace, piece.start + mark);
    }
    let words = text[piece.clone()].trim_start_matches(blank);
    let start = piece.end - words.len();
    let words = words.trim_end_matches(blank);
    let line = words.rfind('\n').map_or(0, |newline| newline + 1);
    let target = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | ':' | ' ' | '[' | ']');
    let assigned = words[line..]
        .strip_suffix('=')
        .is_some_and(|name| name.chars().all(target));
    let words = if assigned {
        notes.add(LeniencyKind::Assignment, start + line);
        &words[..line]
    } else {
        words
    };
    if !words.is_empty() {
        notes.add(LeniencyKind::Prose, start);
    }
}
