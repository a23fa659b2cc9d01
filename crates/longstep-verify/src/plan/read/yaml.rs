//! Plans in YAML: values are taken from the parser's events, so an alias never multiplies a text.

use std::borrow::Cow;
use std::ops::Range;

use rustc_hash::FxHashSet;
use saphyr_parser::{Event, Parser, ScalarStyle};

use super::objects::plan_of_value;
use super::unreadable::Unreadable;
use super::{FoundPlan, around, blocks};
use longstep_model::diagnostic::Position;
use longstep_model::literal::{
    DEEPEST, FENCE, LeniencyKind, LiteralValue, Member, Notes, PLAN_KEYS, ParsedLiteral, ValueNode,
};

/// Finds the plan of a text in YAML, alone or in code blocks; none if nothing there has one.
pub(super) fn find(text: &str) -> Option<Result<FoundPlan, Unreadable>> {
    let whole = 0..text.len();
    let parts: Vec<Range<usize>> = if text.contains(FENCE) {
        blocks(text)
            .filter(|block| block.closed)
            .map(|block| block.inside)
            .collect()
    } else {
        vec![whole]
    };
    let mut plans = parts
        .into_iter()
        .filter_map(|part| Some((part.clone(), plan(text, part)?)));
    let (part, first) = plans.next()?;
    let mut first = match first {
        Ok(first) => first,
        Err(error) => return Some(Err(error)),
    };
    for (_, other) in plans {
        let Ok(other) = other else { continue };
        if !first.has_steps_of(&other) {
            return Some(Err(Unreadable::SeveralPlans {
                count: 2,
                first: Position::of(text, first.start),
                other: Position::of(text, other.start),
            }));
        }
    }
    around(text, 0..part.start, &mut first.notes);
    around(text, part.end..text.len(), &mut first.notes);
    Some(Ok(first))
}

/// Finds the plan in a part of a text.
fn plan(text: &str, part: Range<usize>) -> Option<Result<FoundPlan, Unreadable>> {
    let inside = &text[part.clone()];
    let has_key = |line: &str| {
        let line = line.trim_start_matches(['-', ' ']);
        line.split_once(':')
            .is_some_and(|(key, rest)| !key.contains(' ') && (rest.is_empty() || rest.starts_with(' ')))
    };
    let is_listed = |line: &str| line.trim_start().starts_with("- ");
    if !inside.lines().any(|line| has_key(line.trim_end()) || is_listed(line)) {
        return None;
    }
    let begins_plan = |line: &str| {
        PLAN_KEYS
            .iter()
            .any(|key| line.strip_prefix(key).is_some_and(|rest| rest.starts_with(':')))
    };
    let mut notes = Notes::default();
    notes.add(LeniencyKind::Notation("YAML"), part.start);
    match value(text, part) {
        Ok(Some(node)) => plan_of_value(text, ParsedLiteral::of_node(node, notes), 0),
        Ok(None) => None,
        Err(fault) if inside.lines().any(|line| begins_plan(line.trim_start())) => Some(Err(fault)),
        Err(_) => None,
    }
}

/// A list or an object that is not complete.
enum Open {
    List(usize, Vec<ValueNode>),
    Object(usize, Vec<Member>, Option<(usize, String)>),
}

/// Reads the only document of a part of a text; none for a scalar and for an empty document.
fn value(text: &str, part: Range<usize>) -> Result<Option<ValueNode>, Unreadable> {
    let inside = &text[part.clone()];
    let malformed = |at: usize, message: &str| Unreadable::Malformed {
        position: Position::of(text, at),
        message: message.to_owned(),
    };
    let offsets = Offsets::new(inside, part.start);
    let mut open: Vec<Open> = Vec::new();
    let mut done = None;
    for event in Parser::new_from_str(inside) {
        let (event, span) = event.map_err(|error| {
            let at = offsets.byte(error.marker().index());
            malformed(at, &format!("this is not YAML: {}", error.info()))
        })?;
        let at = offsets.byte(span.start.index());
        let node = match event {
            Event::Alias(_) => return Err(malformed(at, "an alias stands for a value; write the value itself")),
            Event::Scalar(text, style, ..) => ValueNode {
                at,
                value: scalar(text, style),
            },
            Event::SequenceStart(..) | Event::MappingStart(..) if open.len() == DEEPEST => {
                return Err(Unreadable::TooDeep {
                    position: Position::of(text, at),
                    limit: DEEPEST,
                });
            }
            Event::SequenceStart(..) => {
                open.push(Open::List(at, Vec::new()));
                continue;
            }
            Event::MappingStart(..) => {
                open.push(Open::Object(at, Vec::new(), None));
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => match open.pop() {
                Some(Open::List(at, items)) => ValueNode {
                    at,
                    value: LiteralValue::List(items),
                },
                Some(Open::Object(at, members, _)) => {
                    let mut keys = FxHashSet::default();
                    if let Some(again) = members.iter().find(|member| !keys.insert(member.key.as_str())) {
                        return Err(malformed(again.at, "this key stands there twice"));
                    }
                    ValueNode {
                        at,
                        value: LiteralValue::Object(members),
                    }
                }
                None => continue,
            },
            _ => continue,
        };
        match open.last_mut() {
            Some(Open::List(_, items)) => items.push(node),
            Some(Open::Object(_, members, key)) => match (key.take(), node) {
                (Some((at, key)), node) => members.push(Member { at, key, node }),
                (
                    None,
                    ValueNode {
                        at,
                        value: LiteralValue::Text(text),
                    },
                ) => *key = Some((at, text)),
                (None, _) => return Err(malformed(at, "a key is a text")),
            },
            // What follows the end of a document may be empty.
            None if done.is_some() && node.value == LiteralValue::Null => {}
            None if done.is_some() => return Err(malformed(at, "a second document begins here")),
            None => done = Some(node),
        }
    }
    Ok(done.filter(|node| matches!(node.value, LiteralValue::List(_) | LiteralValue::Object(_))))
}

/// Returns the value of a scalar. Names may be numbers, so plain numbers stay texts.
fn scalar(text: Cow<'_, str>, style: ScalarStyle) -> LiteralValue {
    match (style, text.as_ref()) {
        (ScalarStyle::Plain, "" | "~" | "null") => LiteralValue::Null,
        (ScalarStyle::Plain, "true") => LiteralValue::Bool(true),
        (ScalarStyle::Plain, "false") => LiteralValue::Bool(false),
        _ => LiteralValue::Text(text.into_owned()),
    }
}

/// The byte offsets of the characters of a part of a text.
struct Offsets {
    before: usize,
    /// Empty for ASCII, where they are the numbers of the characters.
    offsets: Vec<usize>,
    end: usize,
}

impl Offsets {
    fn new(text: &str, before: usize) -> Self {
        let offsets = if text.is_ascii() {
            Vec::new()
        } else {
            text.char_indices().map(|(at, _)| at).collect()
        };
        let end = text.len();
        Self { before, offsets, end }
    }

    /// Returns the byte offset of a character in the whole text.
    fn byte(&self, character: usize) -> usize {
        let inside = if self.offsets.is_empty() {
            character.min(self.end)
        } else {
            self.offsets.get(character).copied().unwrap_or(self.end)
        };
        self.before + inside
    }
}
