//! Reader for model replies: extracts a plan file from text.
//!
//! The reader is lenient about form and lists every leniency; it is strict about content and guesses nothing. One
//! parser handles all replies; strict JSON produces no leniencies.

mod scripts;
mod shape;
#[cfg(test)]
mod tests;
mod unreadable;

pub use crate::literal::{Leniency, LeniencyKind};
pub use unreadable::Unreadable;

use std::ops::Range;

use super::PlanFile;
use crate::diagnostic::Position;
use crate::literal::{self, DEEPEST, FENCE, Fault, Literal, Notes, PLAN_KEYS, Reason};
use shape::Likeness;
use unreadable::LARGEST;

/// A plan from a model's reply.
#[derive(Debug, Clone, PartialEq)]
pub struct Draft {
    /// The plan; its steps are not resolved.
    pub file: PlanFile,
    /// The deviations from the plan format, in text order.
    pub leniencies: Vec<Leniency>,
}

/// Extracts the plan from a model's reply.
///
/// The plan is an object in the paper's format, as JSON or as a Python literal, alone or inside prose and a code block;
/// or a script (see [`super::script`]), alone or in a code block. Takes time linear in the length of the text.
///
/// # Errors
///
/// [`Unreadable`] if the reply contains no plan, several different plans, or a plan that is truncated, malformed or of
/// the wrong type.
///
/// ```
/// use longstep_core::plan::{Unreadable, read};
///
/// let reply = "Sure!\n```python\n{'task_cohesion': {'task_sequence': ['move_hand()'],\n\
///     'step_instructions': ['move the robot's hand near the cup']}}\n```";
/// let draft = read(reply).unwrap();
/// assert_eq!(draft.file.task_cohesion.step_instructions, ["move the robot's hand near the cup"]);
/// assert_eq!(draft.leniencies[0].message(), "line 1, column 1: words around the plan were ignored");
///
/// let cut_off = read(&reply[..100]).unwrap_err();
/// assert!(matches!(cut_off, Unreadable::CutOff { .. }));
/// ```
pub fn read(text: &str) -> Result<Draft, Unreadable> {
    if text.len() > LARGEST {
        return Err(Unreadable::TooLarge {
            bytes: text.len(),
            limit: LARGEST,
        });
    }
    let surveyed = survey(text);
    let may_be_script = match &surveyed {
        Ok(seen) => seen.plan.is_none(),
        // Without any plan key, the broken object was not meant as a plan in JSON.
        Err(_) => !PLAN_KEYS.iter().any(|key| text.contains(key)),
    };
    if may_be_script && let Some(draft) = scripts::read(text) {
        return draft;
    }
    let seen = surveyed?;
    let position = |at| Position::of(text, at);
    match (seen.plan, seen.broken, seen.object) {
        (
            Some(Found {
                other: Some(other),
                count,
                start,
                ..
            }),
            ..,
        ) => Err(Unreadable::SeveralPlans {
            count,
            first: position(start),
            other: position(other),
        }),
        (Some(Found { file, .. }), ..) => Ok(Draft {
            file,
            leniencies: seen.notes.into_leniencies(text),
        }),
        (None, Some((start, fault)), _) => Err(unreadable(text, start, fault)),
        (None, None, Some(first)) => Err(Unreadable::NoPlan { first: position(first) }),
        (None, None, None) if seen.notes.contain(LeniencyKind::Prose) => {
            Err(Unreadable::Refusal { text: beginning(text) })
        }
        (None, None, None) => Err(Unreadable::Empty),
    }
}

/// Contents of a reply; positions are byte offsets.
#[derive(Default)]
struct Survey {
    plan: Option<Found>,
    /// The first malformed object that is not known to be a plan: its start and the fault.
    broken: Option<(usize, Fault)>,
    /// Start of the first well-formed object.
    object: Option<usize>,
    notes: Notes,
}

/// The first plan in a reply.
struct Found {
    file: PlanFile,
    start: usize,
    /// Number of plans.
    count: usize,
    /// Start of the first plan that differs.
    other: Option<usize>,
}

/// Examines every object of a reply. A plan that cannot be read is an error, whatever else the reply contains.
fn survey(text: &str) -> Result<Survey, Unreadable> {
    let mut seen = Survey::default();
    let mut read_to = 0;
    for (start, object) in (Objects { text, at: 0 }) {
        let literal = match object {
            Ok(literal) => literal,
            Err(fault) if fault.of_plan || !matches!(fault.reason, Reason::Malformed(_)) => {
                return Err(unreadable(text, start, fault));
            }
            Err(fault) => {
                seen.broken.get_or_insert((start, fault));
                continue;
            }
        };
        around(text, read_to..start, &mut seen.notes);
        read_to = literal.end;
        seen.object.get_or_insert(start);
        match shape::likeness(&literal.node) {
            None => seen.notes.add(LeniencyKind::OtherObject, start),
            // This object may be a part of the broken one, whose other content would be lost.
            Some(Likeness::Part) if seen.broken.is_some() => {}
            Some(_) => {
                let mut used = literal.notes;
                let file = shape::plan(text, &literal.node, &mut used)?;
                seen.add(file, start, used);
            }
        }
    }
    around(text, read_to..text.len(), &mut seen.notes);
    Ok(seen)
}

impl Survey {
    fn add(&mut self, file: PlanFile, start: usize, used: Notes) {
        let Some(found) = &mut self.plan else {
            self.notes.append(used);
            self.plan = Some(Found {
                file,
                start,
                count: 1,
                other: None,
            });
            return;
        };
        found.count += 1;
        if found.file == file {
            self.notes.add(LeniencyKind::RepeatedPlan, start);
        } else {
            found.other.get_or_insert(start);
        }
    }
}

/// Iterator over the outermost objects of a text, with their start offsets.
struct Objects<'t> {
    text: &'t str,
    at: usize,
}

impl Iterator for Objects<'_> {
    type Item = (usize, Result<Literal, Fault>);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let start = self.at + self.text[self.at..].find('{')?;
            match literal::object(self.text, start) {
                Ok(literal) => {
                    self.at = literal.end;
                    return Some((start, Ok(literal)));
                }
                Err(fault) => {
                    // Continuing at the fault, never before it, keeps the time linear.
                    let placeholder = placeholder(self.text, start).filter(|end| *end > fault.at);
                    self.at = placeholder.unwrap_or(fault.at).max(start + 1);
                    if placeholder.is_none() || fault.of_plan {
                        return Some((start, Err(fault)));
                    }
                }
            }
        }
    }
}

/// Returns the end of a placeholder, such as `{object}` in a sentence.
fn placeholder(text: &str, start: usize) -> Option<usize> {
    let inside = start + 1;
    let end = inside + text[inside..].find(['{', '}', '\n'])?;
    text[end..].starts_with('}').then_some(end + 1)
}

fn unreadable(text: &str, start: usize, fault: Fault) -> Unreadable {
    let position = Position::of(text, fault.at);
    match fault.reason {
        Reason::CutOff => Unreadable::CutOff {
            position,
            opened: Position::of(text, start),
        },
        Reason::TooDeep => Unreadable::TooDeep {
            position,
            limit: DEEPEST,
        },
        Reason::Malformed(message) => Unreadable::Malformed { position, message },
    }
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

/// Returns the first words of the text, on one line.
fn beginning(text: &str) -> String {
    const SHOWN: usize = 120;
    let line: Vec<&str> = text.split_whitespace().take(SHOWN).collect();
    let line = line.join(" ");
    match line.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line,
    }
}
