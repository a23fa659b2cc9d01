//! Numbers and quotations in an instruction, and whether a goal contains them.

use std::ops::Range;

use rustc_hash::FxHashMap;

use super::names::FullNames;
use super::{Gap, entities};
use crate::environment::{EntityId, World};
use crate::goal::{Goal, GoalFact};
use crate::model::{GoalWordId, label};

/// Pairs of quotation marks. An apostrophe is none: it is part of a word in many languages.
const QUOTATION_MARKS: [(char, char); 7] = [
    ('"', '"'),
    ('\u{201c}', '\u{201d}'),
    ('\u{201e}', '\u{201c}'),
    ('\u{201e}', '\u{201d}'),
    ('\u{ab}', '\u{bb}'),
    ('\u{300c}', '\u{300d}'),
    ('\u{300e}', '\u{300f}'),
];

/// Returns the numbers and quotations that neither the goal nor the name of a mentioned entity contains.
pub(super) fn gaps(world: &World, instruction: &str, goal: &Goal, mentions: &FullNames) -> Vec<(Range<usize>, Gap)> {
    let known = texts(world, goal);
    let quoted = quotations(instruction).into_iter();
    let unknown = |range: &Range<usize>| !contain(&known, &instruction[range.clone()]);
    let quoted = quoted.filter(unknown).map(|range| (range, Gap::Message));
    let numbers = numbers(instruction).into_iter().filter(|range| !mentions.cover(range));
    let numbers = numbers
        .filter(|range| !is_represented(world, instruction, range, goal, mentions))
        .map(|range| (range, Gap::Amount));
    quoted.chain(numbers).collect()
}

/// Returns true if the goal contains a number: in a name, as the number of its parts, or as the label of a thing that it is about.
fn is_represented(world: &World, instruction: &str, range: &Range<usize>, goal: &Goal, mentions: &FullNames) -> bool {
    let number = &instruction[range.clone()];
    let known = texts(world, goal);
    let is_known = known
        .iter()
        .any(|known| numbers(known).into_iter().any(|range| &known[range] == number));
    is_known
        || number
            .parse()
            .is_ok_and(|count: usize| counts(world, goal).contains(&count))
        || is_label(world, instruction, range, goal, mentions)
}

/// Returns true if a number is the label of a thing that the goal is about, or that such a thing is at: "the tray from 22" names a
/// room. What is named in full elsewhere needs no number.
fn is_label(world: &World, instruction: &str, range: &Range<usize>, goal: &Goal, mentions: &FullNames) -> bool {
    let asked = entities(world, goal);
    let is_near = |entity: EntityId| {
        asked.contains(&entity)
            || world.state.iter().any(|fact| {
                let arity = world.domain().predicate(fact.predicate()).parameters.len();
                let has = |entity: EntityId| (0..arity).any(|place| fact.argument(place) == entity);
                has(entity) && asked.iter().any(|asked| has(*asked))
            })
    };
    world
        .entities()
        .filter(|(_, entity)| !entity.is_value && label(&entity.identifier) == instruction[range.clone()])
        .any(|(id, _)| is_near(id) && !mentions.contain_elsewhere(id, instruction, range.start))
}

/// Returns true if one of these texts in lower case contains another one, in any case.
pub(super) fn contain(known: &[String], text: &str) -> bool {
    let text = text.to_lowercase();
    known.iter().any(|known| known.contains(&text))
}

/// Returns the goal in lower case, and all names of its entities.
pub(super) fn texts(world: &World, goal: &Goal) -> Vec<String> {
    let parts = goal.everyday(world).into_iter();
    let names = entities(world, goal)
        .into_iter()
        .flat_map(|entity| &world.entity(entity).names);
    parts.chain(names.cloned()).map(|text| text.to_lowercase()).collect()
}

/// Returns for each goal word with several subjects how many there are: "2 cups" are two goals.
fn counts(world: &World, goal: &Goal) -> Vec<usize> {
    let counts = subjects(world, goal).into_values().map(|own| own.len());
    counts.filter(|count| *count > 1).collect()
}

/// Returns the subjects of each goal word.
fn subjects(world: &World, goal: &Goal) -> FxHashMap<GoalWordId, Vec<EntityId>> {
    let domain = world.domain();
    let mut subjects: FxHashMap<GoalWordId, Vec<EntityId>> = FxHashMap::default();
    for fact in goal.facts.iter().flat_map(GoalFact::parts) {
        if let (GoalFact::Word { word, .. }, Some(subject)) = (fact, fact.subject(domain)) {
            let own = subjects.entry(*word).or_default();
            if !own.contains(&subject) {
                own.push(subject);
            }
        }
    }
    subjects
}

/// Returns the numbers in a text: digits of any script, with points, commas and colons between them.
fn numbers(text: &str) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    let mut last = 0;
    for (at, character) in text.char_indices().filter(|(_, character)| character.is_numeric()) {
        let end = at + character.len_utf8();
        match found.last_mut() {
            Some(number) if number.end == at || (number.end == last && joins(&text[last..at])) => number.end = end,
            _ => found.push(at..end),
        }
        last = end;
    }
    found
}

fn joins(between: &str) -> bool {
    matches!(between, "." | "," | ":" | "/" | "'")
}

/// Returns the texts between quotation marks.
fn quotations(text: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some((open, character)) = text[at..].char_indices().map(|(place, c)| (at + place, c)).find(opens) {
        let start = open + character.len_utf8();
        let closing = |c: char| {
            QUOTATION_MARKS
                .iter()
                .any(|(open, close)| *open == character && *close == c)
        };
        let Some(length) = text[start..].find(closing) else {
            break;
        };
        let end = start + length;
        if !text[start..end].trim().is_empty() {
            found.push(start..end);
        }
        at = end + text[end..].chars().next().map_or(0, char::len_utf8);
    }
    found
}

fn opens((_, character): &(usize, char)) -> bool {
    QUOTATION_MARKS.iter().any(|(open, _)| open == character)
}
