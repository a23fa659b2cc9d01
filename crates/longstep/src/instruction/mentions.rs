//! The entities that an instruction names.
//!
//! Names come from the environment and the domain, in any language. They are found as words of the instruction; apart from
//! names, no word means anything here.

use std::ops::Range;

use rustc_hash::{FxHashMap, FxHashSet};

use super::reference_words;
use crate::environment::{EntityId, World};
use crate::model::{head, matches_name, plain_words, singular};

/// The entities that an instruction names, with its words.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Mentions {
    /// Entities that the instruction may refer to, in the order of the world.
    pub entities: Vec<EntityId>,
    /// Words in lower case.
    words: Vec<String>,
    /// True if a later utterance was added, as an answer or as feedback on a plan.
    is_answered: bool,
}

impl Mentions {
    /// Finds the names in an instruction. Among entities that share the last word of their names, those with the most
    /// matching words are meant: "the water glass" excludes the wine glass.
    pub fn of(world: &World, instruction: &str) -> Self {
        let identified = world.identifiers_in(instruction);
        let words = plain_words(&without(instruction, &identified));
        let singulars: Vec<String> = words.iter().map(|word| singular(word)).collect();
        let said = Places::of(&singulars);
        let scored: Vec<(EntityId, usize)> = world
            .entities()
            .map(|(id, entity)| (id, entity.words_where(&|word| said.has(word))))
            .filter(|(_, score)| *score > 0)
            .collect();
        let heads: FxHashMap<EntityId, String> = scored
            .iter()
            .map(|(id, _)| (*id, head(&world.entity(*id).name)))
            .collect();
        let mut best: FxHashMap<&str, usize> = FxHashMap::default();
        for (id, score) in &scored {
            let best = best.entry(&heads[id]).or_default();
            *best = (*best).max(*score);
        }
        let is_beaten = |id: EntityId, score: usize| {
            let name = heads[&id].as_str();
            best[name] > score && said.of_word(name).len() == 1
        };
        let names = FullNames::of(world, &said, &singulars);
        let named: FxHashSet<EntityId> = scored
            .iter()
            .filter(|(id, score)| !is_beaten(*id, *score) && !names.cover(world, &said, *id))
            .map(|(id, _)| *id)
            .collect();
        let all = world.entities().map(|(id, _)| id);
        let entities = all
            .filter(|id| {
                let is_identified = || identified.iter().any(|(_, own)| own == id);
                named.contains(id) || is_identified() || is_implied(world, *id, &words)
            })
            .collect();
        Self {
            entities,
            words,
            is_answered: false,
        }
    }

    /// Appends the names of a later utterance. They replace those with the same last word: after "the red mug", "the blue
    /// mug" is another one.
    pub(crate) fn add(&mut self, world: &World, later: Self) {
        let head_of = |entity: &EntityId| head(&world.entity(*entity).name);
        let heads: FxHashSet<String> = later.entities.iter().map(head_of).collect();
        self.entities.retain(|entity| !heads.contains(&head_of(entity)));
        self.entities.extend(later.entities);
        self.entities.sort_unstable();
        self.words.extend(later.words);
        self.is_answered = true;
    }

    /// Returns true if a later utterance was added.
    pub(crate) fn is_answered(&self) -> bool {
        self.is_answered
    }

    pub(super) fn words(&self) -> &[String] {
        &self.words
    }

    /// Returns true if the instruction can mean several entities with these names: "both jars", "a jar and the other
    /// jar".
    pub fn several(&self, names: &[String]) -> bool {
        let heads: Vec<String> = names.iter().map(|name| head(name)).collect();
        let mut count = 0;
        for word in &self.words {
            let single = singular(word);
            let is_ours = heads.contains(&single);
            if reference_words::mark_several(word) || (is_ours && *word != single) {
                return true;
            }
            count += usize::from(is_ours);
        }
        count > 1
    }
}

/// Returns the text with blanks in place of identifiers, whose words name nothing else.
fn without(text: &str, identified: &[(Range<usize>, EntityId)]) -> String {
    let is_word = |at: usize| !identified.iter().any(|(place, _)| place.contains(&at));
    let letters = text.char_indices();
    letters
        .map(|(at, letter)| if is_word(at) { letter } else { ' ' })
        .collect()
}

/// Returns true if the domain lists a word that speaks of the entity without naming it.
fn is_implied(world: &World, id: EntityId, words: &[String]) -> bool {
    let identifier = &world.entity(id).identifier;
    let implied = world.domain().implied.iter();
    let mut stems = implied
        .filter(|(name, _)| matches_name(identifier, name))
        .flat_map(|(_, stems)| stems);
    stems.any(|stem| words.iter().any(|word| word.starts_with(stem.as_str())))
}

/// Positions of each word in an instruction.
struct Places<'w>(FxHashMap<&'w str, Vec<usize>>);

impl<'w> Places<'w> {
    fn of(words: &'w [String]) -> Self {
        let mut places: FxHashMap<&str, Vec<usize>> = FxHashMap::default();
        for (place, word) in words.iter().enumerate() {
            places.entry(word).or_default().push(place);
        }
        Self(places)
    }

    fn of_word(&self, word: &str) -> &[usize] {
        self.0.get(word).map_or(&[], Vec::as_slice)
    }

    fn has(&self, word: &str) -> bool {
        self.0.contains_key(word)
    }
}

/// Positions at which an instruction contains full names of entities.
///
/// Many entities may share a name ("box"), and an instruction may repeat it often. To keep the work linear, occurrences
/// are found once for each name, and each position stores only its longest name and the longest name of a different
/// entity.
struct FullNames {
    /// For each entity, indices into `occurrences` of the names in the instruction.
    names: FxHashMap<EntityId, Vec<usize>>,
    /// For each name, its length in words and its places.
    occurrences: Vec<(usize, Vec<Range<usize>>)>,
    /// For each position, the longest name that covers it, and the longest one of another entity.
    longest: Vec<[(usize, Option<EntityId>); 2]>,
}

impl FullNames {
    fn of(world: &World, said: &Places<'_>, singulars: &[String]) -> Self {
        let mut numbers: FxHashMap<Vec<String>, Option<usize>> = FxHashMap::default();
        let mut names: FxHashMap<EntityId, Vec<usize>> = FxHashMap::default();
        let mut occurrences: Vec<(usize, Vec<Range<usize>>)> = Vec::new();
        // Two entities with a name suffice to find the longest name of any other entity.
        let mut owners: Vec<[Option<EntityId>; 2]> = Vec::new();
        for (id, entity) in world.entities() {
            for name in entity.called() {
                let parts: Vec<String> = plain_words(&name).iter().map(|part| singular(part)).collect();
                if parts.is_empty() {
                    continue;
                }
                let known = numbers.get(&parts).copied();
                let number = known.unwrap_or_else(|| {
                    let begins = said.of_word(&parts[0]).iter().copied();
                    let places: Vec<Range<usize>> = begins
                        .filter_map(|start| Some(start..start + said_length(&parts, &singulars[start..])?))
                        .collect();
                    let number = (!places.is_empty()).then_some(occurrences.len());
                    if number.is_some() {
                        occurrences.push((parts.len(), places));
                        owners.push([None; 2]);
                    }
                    numbers.insert(parts, number);
                    number
                });
                let Some(number) = number else { continue };
                let own = names.entry(id).or_default();
                if own.contains(&number) {
                    continue;
                }
                own.push(number);
                if let Some(free) = owners[number].iter_mut().find(|owner| owner.is_none()) {
                    *free = Some(id);
                }
            }
        }
        let mut longest = vec![[(0, None); 2]; singulars.len()];
        for ((length, places), owners) in occurrences.iter().zip(&owners) {
            for place in places.iter().cloned().flatten() {
                owners
                    .iter()
                    .flatten()
                    .for_each(|owner| enter(&mut longest[place], *length, *owner));
            }
        }
        Self {
            names,
            occurrences,
            longest,
        }
    }

    /// Returns true if every word that could mean the entity is part of a longer name of another entity: "drawer 2"
    /// mentions no other drawer, and "tv stand" mentions no tv.
    fn cover(&self, world: &World, said: &Places<'_>, id: EntityId) -> bool {
        let heads: FxHashSet<String> = world.entity(id).names.iter().map(|name| head(name)).collect();
        let own = self.names.get(&id).map_or(&[][..], Vec::as_slice);
        let mut own_longest: FxHashMap<usize, usize> = FxHashMap::default();
        for number in own {
            let (length, places) = &self.occurrences[*number];
            for place in places.iter().cloned().flatten() {
                let longest = own_longest.entry(place).or_default();
                *longest = (*longest).max(*length);
            }
        }
        let covered = |place: &usize| {
            let others = self.longest[*place].iter().filter(|(_, owner)| *owner != Some(id));
            let other = others.map(|(length, _)| *length).max().unwrap_or(0);
            other > own_longest.get(place).copied().unwrap_or(1)
        };
        heads.iter().flat_map(|word| said.of_word(word)).all(covered)
    }
}

/// Returns the number of words that a name takes at the beginning of some; none if it is not there. In a name of three words or
/// more, a word may stand between two of them: "the hallway between the kitchen and the bedroom".
pub(super) fn said_length(name: &[String], words: &[String]) -> Option<usize> {
    let most_between = usize::from(name.len() >= 3);
    let mut length = 0;
    for (index, part) in name.iter().enumerate() {
        let most_between = if index == 0 { 0 } else { most_between };
        let ahead = words[length..].iter().take(most_between + 1);
        length += 1 + ahead.into_iter().position(|word| word == part)?;
    }
    Some(length)
}

/// Records a name that covers a position.
fn enter(longest: &mut [(usize, Option<EntityId>); 2], length: usize, owner: EntityId) {
    let [first, second] = longest;
    if first.1 == Some(owner) {
        first.0 = first.0.max(length);
    } else if length > first.0 {
        (*second, *first) = (*first, (length, Some(owner)));
    } else if length > second.0 {
        *second = (length, Some(owner));
    }
}
