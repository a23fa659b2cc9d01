//! Steps on lines of their own: lists, tables, and VirtualHome scripts.

use std::ops::Range;

use super::line::{Form, Line};
use super::objects::beginning;
use super::stray::{Known, may_be_steps};
use super::unreadable::Unreadable;
use super::{FoundPlan, around, blocks, scripts};
use crate::plan::WrittenStep;
use longstep_model::call::Call;
use longstep_model::diagnostic::Position;
use longstep_model::literal::{FENCE, LeniencyKind, Notes};

/// Finds steps on lines of their own; none if no line is one.
pub(super) fn find(text: &str) -> Option<Result<FoundPlan, Unreadable>> {
    let mut groups = Groups::default();
    groups.read(text)?;
    if let Some(error) = groups.error(text) {
        return Some(Err(error));
    }
    let mut groups = groups.done.into_iter();
    let first = groups.next()?;
    let mut notes = Notes::default();
    notes.add(LeniencyKind::Notation(first.form.name()), first.start);
    around(text, 0..first.start, &mut notes);
    first.words.iter().for_each(|at| notes.add(LeniencyKind::Prose, *at));
    let mut read_to = first.end;
    for group in groups {
        around(text, read_to..group.start, &mut notes);
        notes.add(LeniencyKind::RepeatedPlan, group.start);
        read_to = group.end;
    }
    around(text, read_to..text.len(), &mut notes);
    Some(FoundPlan::of_steps(text, first.steps, first.start, notes))
}

/// Steps that stand together: in one code block, or in one count of numbers. Places are byte offsets.
struct Group {
    steps: Vec<WrittenStep>,
    form: Form,
    /// The begin of its first line and the end of its last one.
    start: usize,
    end: usize,
    indentation: usize,
    /// The number of its last line.
    number: Option<u32>,
    /// Lines with words between its steps.
    words: Vec<usize>,
    /// The character of a VirtualHome script.
    character: Option<String>,
    /// The parts with a heading of their own: the number of steps before each, and where it begins.
    parts: Vec<(usize, usize)>,
}

impl Group {
    /// Returns the parts with headings as groups of their own, unless the headings are words to one step each.
    fn split(mut self) -> Vec<Self> {
        let ends = self.parts.iter().skip(1).map(|part| part.0).chain([self.steps.len()]);
        let first = self.parts.first().map_or(0, |part| part.0);
        let longest = self.parts.iter().zip(ends).map(|((begin, _), end)| end - begin).max();
        if longest.unwrap_or(0).max(first) < 2 {
            return vec![self];
        }
        let mut groups = Vec::new();
        for (begin, start) in std::mem::take(&mut self.parts).into_iter().rev() {
            groups.push(Self {
                steps: self.steps.split_off(begin),
                form: self.form,
                start,
                end: self.end,
                indentation: self.indentation,
                number: None,
                words: Vec::new(),
                character: self.character.clone(),
                parts: Vec::new(),
            });
            self.end = start;
        }
        groups.push(self);
        groups.reverse();
        groups
    }
}

/// Returns true for a line between parts: `---`.
fn is_rule(line: &str) -> bool {
    let mut signs = line.chars();
    let first = signs.next();
    matches!(first, Some('-' | '=' | '*' | '_')) && line.len() > 2 && signs.all(|sign| Some(sign) == first)
}

/// Returns true for a line of words that says what follows.
fn is_heading(line: &str) -> bool {
    let line = line.trim();
    line.starts_with('#')
        || line.trim_end_matches('*').ends_with([':', '\u{ff1a}'])
        || (line.starts_with("**") && line.ends_with("**"))
}

/// The steps of a text, and what keeps them from being a plan.
#[derive(Default)]
struct Groups {
    done: Vec<Group>,
    open: Option<Group>,
    /// Lines with words behind the last step.
    words: Vec<usize>,
    /// An entry behind the last step that is none, which is a mistake if a step follows.
    doubtful: Option<(usize, String)>,
    no_step: Option<(usize, String)>,
    second_character: Option<usize>,
    /// A code block with steps that does not end.
    cut_off: Option<usize>,
    /// True if the last line belonged to the open group.
    is_next: bool,
    /// True behind a heading that follows a step.
    is_headed: bool,
    /// All lines of words.
    said: Vec<Range<usize>>,
}

impl Groups {
    /// Reads all lines; none if they are code.
    fn read(&mut self, text: &str) -> Option<()> {
        let parts: Vec<Range<usize>> = if text.contains(FENCE) {
            blocks(text).map(|block| block.inside).collect()
        } else {
            std::iter::once(0..text.len()).collect()
        };
        let code = parts.into_iter().filter(|part| scripts::is_meant(&text[part.clone()]));
        let mut code = code.peekable();
        let mut fence = None;
        let mut at = 0;
        for line in text.split_inclusive('\n') {
            let start = at;
            at += line.len();
            while code.next_if(|part| part.end <= start).is_some() {}
            let bare = line.trim();
            if bare.starts_with(FENCE) {
                fence = fence.xor(Some(start));
                self.close();
            } else if is_rule(bare) {
                self.close();
            } else if bare.is_empty() {
                self.is_next = false;
            } else if let Some(read) = Line::read(line) {
                self.add(read, start..at);
            } else if code.peek().is_some_and(|part| part.contains(&start)) {
                if !bare.starts_with('#') {
                    return None;
                }
                if may_be_steps(bare) {
                    self.no_step.get_or_insert((start, beginning(bare)));
                }
            } else {
                self.said.push(start..at);
                self.add_words(line, start);
            }
        }
        self.cut_off = fence.filter(|fence| self.open.as_ref().is_some_and(|open| open.start > *fence));
        self.close();
        Some(())
    }

    fn close(&mut self) {
        self.done.extend(self.open.take().into_iter().flat_map(Group::split));
        self.words.clear();
        self.is_headed = false;
        self.doubtful = None;
        self.is_next = false;
    }

    fn add(&mut self, line: Line, place: Range<usize>) {
        let begins_again = |open: &Group| {
            line.number
                .is_some_and(|number| open.number.is_some_and(|last| number <= last))
        };
        if self.open.as_ref().is_some_and(begins_again) {
            self.close();
        }
        let open = self.open.get_or_insert_with(|| Group {
            steps: Vec::new(),
            form: line.form,
            start: place.start,
            end: place.end,
            indentation: line.indentation,
            number: None,
            words: Vec::new(),
            character: None,
            parts: Vec::new(),
        });
        if std::mem::take(&mut self.is_headed) {
            open.parts.push((open.steps.len(), place.start));
        }
        open.steps.extend(line.steps);
        open.end = place.end;
        open.number = line.number;
        open.words.append(&mut self.words);
        match (&open.character, line.character) {
            (Some(one), Some(other)) if *one != other => {
                self.second_character.get_or_insert(place.start);
            }
            (None, character) => open.character = character,
            _ => {}
        }
        if let Some(doubtful) = self.doubtful.take() {
            self.no_step.get_or_insert(doubtful);
        }
        self.is_next = true;
    }

    /// Adds a line without a step: words, or an entry of the open list.
    fn add_words(&mut self, line: &str, at: usize) {
        if may_be_steps(line) {
            self.no_step.get_or_insert((at, beginning(line)));
        }
        let Some(open) = &self.open else { return };
        self.is_headed |= is_heading(line);
        let entry =
            Form::of_line(line).filter(|(form, indentation, _)| *form == open.form && *indentation == open.indentation);
        let Some((form, _, number)) = entry else {
            self.words.push(at);
            self.is_next = false;
            return;
        };
        let found = (at, beginning(line));
        let follows = number.is_some() && number == open.number.map(|last| last + 1);
        if follows || self.is_next || form == Form::VirtualHome {
            self.no_step.get_or_insert(found);
        } else {
            self.doubtful.get_or_insert(found);
        }
    }

    /// Returns the first reason why the steps are no plan.
    fn error(&self, text: &str) -> Option<Unreadable> {
        let position = |at: usize| Position::of(text, at);
        let first = self.done.first()?;
        if let Some((at, line)) = &self.no_step {
            return Some(Unreadable::NoStep {
                position: position(*at),
                text: line.clone(),
            });
        }
        if let Some(at) = self.second_character {
            return Some(Unreadable::Malformed {
                position: position(at),
                message: "this line is for another character, and a plan is read for one".to_owned(),
            });
        }
        if let Some(opened) = self.cut_off {
            return Some(Unreadable::CutOff {
                position: position(text.len()),
                opened: position(opened),
            });
        }
        let known = Known::new(self.done.iter().flat_map(|group| &group.steps));
        let said = self.said.iter().map(|words| (words.start, &text[words.clone()]));
        let stray = said.filter_map(|(start, words)| known.stray(words).map(|(at, call)| (start + at, call)));
        let explained = self.done.iter().flat_map(|group| {
            let explanations = group.steps.iter().map(|step| &step.explanation);
            explanations.filter_map(|words| known.stray(words).map(|(_, call)| (group.start, call)))
        });
        if let Some((at, call)) = stray.chain(explained).min_by_key(|(at, _)| *at) {
            return Some(Unreadable::StrayCall {
                position: position(at),
                call: beginning(call),
            });
        }
        let calls = |group: &Group| -> Vec<(Call, Vec<(String, String)>)> {
            let steps = group.steps.iter();
            steps.map(|step| (step.call.clone(), step.implicit.clone())).collect()
        };
        let same = calls(first);
        let other = self.done.iter().find(|group| calls(group) != same)?;
        Some(Unreadable::SeveralPlans {
            count: self.done.len(),
            first: position(first.start),
            other: position(other.start),
        })
    }
}
