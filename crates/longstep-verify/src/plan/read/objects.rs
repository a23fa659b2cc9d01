//! Plans in JSON and in Python literals, with the prose around them.

use std::ops::Range;

use super::step_value::{PlanCandidate, candidates};
use super::unreadable::Unreadable;
use super::{FoundPlan, around, shape};
use crate::plan::WrittenStep;
use longstep_model::diagnostic::Position;
use longstep_model::json::Path;
use longstep_model::literal::{self, DEEPEST, Fault, FaultReason, LeniencyKind, LiteralValue, Notes, ParsedLiteral};

/// Contents of a reply; positions are byte offsets.
#[derive(Default)]
pub(super) struct Survey {
    plan: Option<FirstPlan>,
    /// Objects that are one step each.
    steps: Vec<(WrittenStep, usize)>,
    /// The first list of steps that may be no plan to carry out.
    unsure: Option<(Vec<WrittenStep>, usize)>,
    /// The first malformed object that is not known to be a plan: its start and the fault.
    pub(super) broken: Option<(usize, Fault)>,
    /// Start of the first well-formed object.
    object: Option<usize>,
    /// The well-formed objects.
    pub(super) read: Vec<Range<usize>>,
    notes: Notes,
}

/// The first plan in a reply.
struct FirstPlan {
    found: FoundPlan,
    /// Number of plans.
    count: usize,
    /// Start of the first plan that differs.
    other: Option<usize>,
}

/// Examines every object and list of a reply. A plan that cannot be read is an error, whatever else the reply contains.
pub(super) fn survey(text: &str, depth: usize) -> Result<Survey, Unreadable> {
    let mut seen = Survey::default();
    let mut read_to = 0;
    for (start, value) in Values::new(text) {
        let literal = match value {
            Ok(literal) => literal,
            Err(fault) if fault.of_plan || !matches!(fault.reason, FaultReason::Malformed(_)) => {
                return Err(unreadable(text, start, fault));
            }
            Err(fault) => {
                seen.broken.get_or_insert((start, fault));
                continue;
            }
        };
        let ParsedLiteral { node, end, notes } = literal;
        let found = candidates(&text[..start], &node, depth);
        // A list without objects and steps, such as `[1]`, belongs to the prose.
        if found.is_empty() && is_plain_list(&node.value) {
            continue;
        }
        around(text, read_to..start, &mut seen.notes);
        read_to = end;
        seen.read.push(start..end);
        seen.object.get_or_insert(start);
        seen.add_all(text, found, start, notes)?;
    }
    around(text, read_to..text.len(), &mut seen.notes);
    Ok(seen)
}

/// Finds the plan of one value, which stands at `start` and has the notes of its reader.
pub(super) fn plan_of_value(text: &str, literal: ParsedLiteral, depth: usize) -> Option<Result<FoundPlan, Unreadable>> {
    let ParsedLiteral { node, notes, .. } = literal;
    let found = candidates("", &node, depth);
    let mut seen = Survey::default();
    if found.is_empty() {
        return None;
    }
    let added = seen.add_all(text, found, node.at, notes);
    Some(added.and_then(|()| seen.plan(text)?))
}

fn is_plain_list(value: &LiteralValue) -> bool {
    matches!(value, LiteralValue::List(items) if !items.iter().any(|item| matches!(item.value, LiteralValue::Object(_))))
}

impl Survey {
    /// Adds the plans and steps of a value that stands at `start`.
    fn add_all(&mut self, text: &str, found: Vec<PlanCandidate>, start: usize, notes: Notes) -> Result<(), Unreadable> {
        if found.is_empty() {
            self.notes.add(LeniencyKind::OtherObject, start);
        }
        let mut used = Some(notes);
        let wrapped = |notes: &mut Notes, path: Path| {
            if path != Path::default() {
                notes.add_about(LeniencyKind::Wrapped, start, path);
            }
        };
        for candidate in found {
            let mut notes = used.take().unwrap_or_default();
            match candidate {
                // This object may be a part of the broken one, whose other content would be lost.
                PlanCandidate::Plan { is_part: true, .. } if self.broken.is_some() => {}
                PlanCandidate::Plan { node, path, .. } => {
                    wrapped(&mut notes, path.clone());
                    let file = shape::plan(text, node, &path, &mut notes)?;
                    self.add(FoundPlan { file, start, notes });
                }
                PlanCandidate::Steps {
                    steps, is_sure: false, ..
                } => {
                    self.unsure.get_or_insert((steps, start));
                }
                PlanCandidate::Steps {
                    steps, ignored, path, ..
                } => {
                    for key in &ignored {
                        notes.add_about(LeniencyKind::ExtraKey, start, path.push(&literal::shorten(key)));
                    }
                    wrapped(&mut notes, path);
                    notes.add(LeniencyKind::Notation("a list of steps"), start);
                    self.add(FoundPlan::of_steps(text, steps, start, notes)?);
                }
                PlanCandidate::Step(step) => {
                    self.notes.append(notes);
                    self.steps.push((step, start));
                }
                PlanCandidate::Refused { at, message } => {
                    return Err(Unreadable::Malformed {
                        position: Position::of(text, at),
                        message,
                    });
                }
                PlanCandidate::NotWhole { at, key, reason } => {
                    return Err(Unreadable::NotWhole {
                        position: Position::of(text, at),
                        key,
                        reason,
                    });
                }
                PlanCandidate::Inner { found, at, path } => {
                    let found = found.map_err(|error| Unreadable::Inside {
                        position: Position::of(text, at),
                        path: path.clone(),
                        error: Box::new(error),
                    })?;
                    // The other notes have their places in the inner text.
                    found
                        .notes
                        .notations()
                        .for_each(|name| notes.add(LeniencyKind::Notation(name), at));
                    wrapped(&mut notes, path);
                    self.add(FoundPlan { notes, start, ..*found });
                }
            }
        }
        Ok(())
    }

    fn add(&mut self, found: FoundPlan) {
        let Some(first) = &mut self.plan else {
            self.plan = Some(FirstPlan {
                found,
                count: 1,
                other: None,
            });
            return;
        };
        first.count += 1;
        if first.found.file == found.file {
            self.notes.add(LeniencyKind::RepeatedPlan, found.start);
        } else {
            first.other.get_or_insert(found.start);
        }
    }

    /// Returns the plan, or the error of a text that has one and cannot be read.
    ///
    /// # Errors
    ///
    /// The reason why the text has no plan.
    pub(super) fn plan(mut self, text: &str) -> Result<Result<FoundPlan, Unreadable>, Unreadable> {
        let position = |at| Position::of(text, at);
        if let [(_, start), ..] = self.steps[..] {
            let count = self.steps.len();
            let steps = std::mem::take(&mut self.steps)
                .into_iter()
                .map(|(step, _)| step)
                .collect();
            let mut notes = Notes::default();
            let name = if count == 1 {
                "a call of one step"
            } else {
                "objects of one step each"
            };
            notes.add(LeniencyKind::Notation(name), start);
            match FoundPlan::of_steps(text, steps, start, notes) {
                Ok(found) => self.add(found),
                Err(error) => return Ok(Err(error)),
            }
        }
        if let (Some(plan), Some((steps, start))) = (&mut self.plan, self.unsure)
            && FoundPlan::of_steps(text, steps, start, Notes::default())
                .is_ok_and(|other| !other.has_steps_of(&plan.found))
        {
            plan.count += 1;
            plan.other.get_or_insert(start);
        }
        match (self.plan, self.broken, self.object) {
            (
                Some(FirstPlan {
                    other: Some(other),
                    count,
                    found,
                }),
                ..,
            ) => Ok(Err(Unreadable::SeveralPlans {
                count,
                first: position(found.start),
                other: position(other),
            })),
            (Some(FirstPlan { mut found, .. }), ..) => {
                found.notes.append(self.notes);
                Ok(Ok(found))
            }
            (None, Some((start, fault)), _) => Err(unreadable(text, start, fault)),
            (None, None, Some(first)) => Err(Unreadable::NoPlan { first: position(first) }),
            (None, None, None) if self.notes.contain(LeniencyKind::Prose) => {
                Err(Unreadable::Refusal { text: beginning(text) })
            }
            (None, None, None) => Err(Unreadable::Empty),
        }
    }
}

/// The number of lists that are begun and do not end, after which only objects are read: each takes a pass over the text.
const OPEN_LISTS: usize = 8;

/// Iterator over the outermost objects and lists of a text, with their start offsets.
struct Values<'t> {
    text: &'t str,
    at: usize,
    open_lists: usize,
}

impl<'t> Values<'t> {
    fn new(text: &'t str) -> Self {
        Self {
            text,
            at: 0,
            open_lists: 0,
        }
    }
}

impl Iterator for Values<'_> {
    type Item = (usize, Result<ParsedLiteral, Fault>);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let lists = self.open_lists < OPEN_LISTS;
            let begins = |c: char| c == '{' || (c == '[' && lists);
            let start = self.at + self.text[self.at..].find(begins)?;
            let is_list = self.text[start..].starts_with('[');
            match literal::bracketed(self.text, start) {
                Ok(literal) => {
                    self.at = literal.end;
                    return Some((start, Ok(literal)));
                }
                // A bracket in prose. Continuing at the fault, never before it, keeps the time linear.
                Err(fault) if is_list && !fault.of_plan && matches!(fault.reason, FaultReason::Malformed(_)) => {
                    self.at = fault.at.max(start + 1);
                }
                Err(fault) if is_list && !fault.of_plan => {
                    self.open_lists += 1;
                    self.at = start + 1;
                }
                Err(fault) => {
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
        FaultReason::CutOff => Unreadable::CutOff {
            position,
            opened: Position::of(text, start),
        },
        FaultReason::TooDeep => Unreadable::TooDeep {
            position,
            limit: DEEPEST,
        },
        FaultReason::Malformed(message) => Unreadable::Malformed { position, message },
    }
}

/// Returns the error for an entry at a place of a text that is no step.
pub(super) fn no_step(text: &str, at: usize, entry: &str) -> Unreadable {
    Unreadable::NoStep {
        position: Position::of(text, at),
        text: beginning(entry),
    }
}

/// Returns the first words of the text, on one line.
pub(super) fn beginning(text: &str) -> String {
    const SHOWN: usize = 120;
    let line: Vec<&str> = text.split_whitespace().take(SHOWN).collect();
    let line = line.join(" ");
    match line.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line,
    }
}
