//! Entities that an instruction names in full. Names are data of the environment and the domain, in any language.

use std::ops::Range;

use rustc_hash::FxHashMap;

use crate::environment::{EntityId, World};
use crate::model::{plain_words, singular};

/// From this character on, scripts are written without spaces between words (Chinese, Japanese, Korean particles).
const WITHOUT_SPACES: char = '\u{2e80}';

/// A name in an instruction.
#[derive(Debug, Clone)]
struct Mention {
    range: Range<usize>,
    /// The entities with this name.
    entities: Vec<EntityId>,
}

/// The names of entities in an instruction: of overlapping ones, the longest.
#[derive(Debug, Clone)]
pub(super) struct FullNames(Vec<Mention>);

impl FullNames {
    pub(super) fn of(world: &World, instruction: &str) -> Self {
        let words = words(instruction);
        let mut places: FxHashMap<&str, Vec<usize>> = FxHashMap::default();
        for (place, (word, _)) in words.iter().enumerate() {
            places.entry(word).or_default().push(place);
        }
        let mut found: FxHashMap<(usize, usize), Mention> = FxHashMap::default();
        // A value comes from the text that mentions it; `literal` decides whether a goal has it.
        for (id, entity) in world.entities().filter(|(_, entity)| !entity.is_value) {
            for name in entity.called() {
                let ranges = if name.contains(|character| character >= WITHOUT_SPACES) {
                    occurrences(instruction, &name)
                } else {
                    sequences(&words, &places, &name)
                };
                ranges.into_iter().for_each(|range| enter(&mut found, range, id));
            }
        }
        let identified = world.identifiers_in(instruction);
        // An identifier is no name of the entities that have its words.
        found.retain(|_, mention| identified.iter().all(|(place, _)| mention.range != *place));
        for (place, id) in identified {
            enter(&mut found, place, id);
        }
        let mut all: Vec<Mention> = found.into_values().collect();
        all.sort_by_key(|mention| (std::cmp::Reverse(mention.range.len()), mention.range.start));
        let mut kept: Vec<Mention> = Vec::new();
        for mention in all {
            let overlaps =
                |other: &Mention| mention.range.start < other.range.end && other.range.start < mention.range.end;
            if !kept.iter().any(overlaps) {
                kept.push(mention);
            }
        }
        kept.sort_by_key(|mention| mention.range.start);
        Self(kept)
    }

    /// Returns true if the range is part of a name.
    pub(super) fn cover(&self, range: &Range<usize>) -> bool {
        let covers = |mention: &Mention| mention.range.start <= range.start && range.end <= mention.range.end;
        self.0.iter().any(covers)
    }

    /// Returns true if an entity is named, and not right before `place` ("cart" before "7").
    pub(super) fn contain_elsewhere(&self, entity: EntityId, instruction: &str, place: usize) -> bool {
        let is_before = |end: usize| {
            instruction
                .get(end..place)
                .is_some_and(|between| between.trim().is_empty())
        };
        self.0
            .iter()
            .any(|mention| mention.entities.contains(&entity) && !is_before(mention.range.end))
    }

    /// Returns the entities that are named within a range.
    pub(super) fn within(&self, range: &Range<usize>) -> impl Iterator<Item = EntityId> {
        let inside = |mention: &&Mention| range.start <= mention.range.start && mention.range.end <= range.end;
        self.0
            .iter()
            .filter(inside)
            .flat_map(|mention| mention.entities.iter().copied())
    }
}

/// Records that a range names an entity.
fn enter(found: &mut FxHashMap<(usize, usize), Mention>, range: Range<usize>, id: EntityId) {
    let mention = found.entry((range.start, range.end)).or_insert_with(|| Mention {
        range,
        entities: Vec::new(),
    });
    if !mention.entities.contains(&id) {
        mention.entities.push(id);
    }
}

/// Returns the places at which the words of a name stand in the instruction, in the singular.
fn sequences(words: &[(String, Range<usize>)], places: &FxHashMap<&str, Vec<usize>>, name: &str) -> Vec<Range<usize>> {
    let name: Vec<String> = plain_words(name).iter().map(|word| singular(word)).collect();
    let Some(first) = name.first() else { return Vec::new() };
    let starts = places.get(first.as_str()).into_iter().flatten();
    starts
        .filter_map(|start| {
            let window = words.get(*start..start + name.len())?;
            let is_name = window.iter().zip(&name).all(|((word, _), part)| word == part);
            is_name.then(|| window[0].1.start..window[name.len() - 1].1.end)
        })
        .collect()
}

/// Returns the places at which a text contains a name.
fn occurrences(instruction: &str, name: &str) -> Vec<Range<usize>> {
    instruction
        .match_indices(name)
        .map(|(at, found)| at..at + found.len())
        .collect()
}

/// Returns the words of a text in the singular, as [`plain_words`] finds them, with their places.
pub(super) fn words(text: &str) -> Vec<(String, Range<usize>)> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    let mut last = ' ';
    for (at, character) in text.char_indices() {
        let end = at + character.len_utf8();
        let joins = character.is_alphanumeric()
            && last.is_alphanumeric()
            && character.is_ascii_digit() == last.is_ascii_digit();
        match ranges.last_mut() {
            Some(range) if joins => range.end = end,
            _ if character.is_alphanumeric() => ranges.push(at..end),
            _ => {}
        }
        last = match character {
            '\'' | '\u{2019}' => last,
            other => other,
        };
    }
    let word = |range: Range<usize>| (singular(&plain_words(&text[range.clone()]).concat()), range);
    ranges.into_iter().map(word).collect()
}
