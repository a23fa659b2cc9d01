//! Comparison of goals with the entities that the instruction mentions.
//!
//! The most frequent error of small models is an extra goal about an entity that the instruction does not mention. Such
//! a goal is left out and reported. If no goal remains, or if the instruction mentions an unknown object, the person is
//! asked.

use rustc_hash::{FxHashMap, FxHashSet};

use super::ambiguous::which;
use super::depends::{Clauses, is_word_of_outcomes};
use super::negated::asserted;
use super::{Conditional, Goal, GoalFact, Group};
use crate::effort;
use crate::environment::{EntityId, World};
use crate::model::{head, matches_name, plain_words, singular};
use longstep_core::model::Domain;

/// Result for a model's answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Understanding {
    /// The accepted goal and the goals that were left out.
    Goal(Goal, Vec<LeftOut>),
    /// A question to the person.
    Question(String),
    /// A question to the person which of several things is meant that fit the same words.
    Which(String),
}

/// A goal of the model's answer that the instruction does not support.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// The goal.
    pub fact: GoalFact,
    /// The reason, for a person.
    pub why: String,
}

impl Understanding {
    /// Returns the understanding for another world with these entities (see [`Goal::carried`]), or none if the other
    /// world lacks one of them.
    pub fn carried(&self, domain: &Domain, from: &World, to: &World) -> Option<Self> {
        Some(match self {
            Self::Question(question) => Self::Question(question.clone()),
            Self::Which(question) => Self::Which(question.clone()),
            Self::Goal(goal, left_out) => {
                let left_out = left_out.iter().map(|left| {
                    Some(LeftOut {
                        fact: left.fact.carried(domain, from, to)?,
                        why: left.why.clone(),
                    })
                });
                Self::Goal(goal.carried(domain, from, to)?, left_out.collect::<Option<Vec<_>>>()?)
            }
        })
    }
}

/// Words that end a noun phrase or name no object by themselves.
pub(super) const NOT_THINGS: &str = "a about above after again all an and another any anything around as at away back be before \
    beside bit both bottom but by can could down each every everything first for from front half here in inside into \
    is it its last left little lower me middle my near next not now of off on one onto or other our out over place \
    please rest rid right room same second should side so some somewhere spot still that the them then there these \
    thing this those through time to together too top two under until up upper use using way where which while will \
    with work would you your";

pub(super) const DETERMINERS: &str = "the a an that this my your some those these our";

/// Frequent English words that are rare in other languages.
const ENGLISH: &str = "the and with please it its this that these them there from into onto of to for is are not you your my \
    put take get bring can could would should all";

/// Words that mark several objects.
const SEVERAL: &str = "all both each every everything two three four five six several many";

pub(super) fn among(list: &str, word: &str) -> bool {
    // A bound on the length first: scanning a list costs more than comparing lengths.
    word.len() <= LONGEST_LISTED && list.split_ascii_whitespace().any(|entry| entry == word)
}

/// Length of the longest word in a list, in bytes.
const LONGEST_LISTED: usize = 16;

/// The mentions in an instruction.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Spoken {
    /// Entities that the instruction may refer to.
    pub entities: Vec<EntityId>,
    /// Words in lower case, without those that only rule something out.
    words: Vec<String>,
    /// Singulars of `words`.
    singulars: Vec<String>,
    /// Singulars of `words` that are no determiners.
    bare: Vec<String>,
    /// Conditions.
    clauses: Clauses,
    /// True if a later utterance was added, as an answer or as feedback on a plan.
    later: bool,
    /// True if the words are English. What a rule about English words does not find says nothing about other languages.
    english: bool,
}

impl Spoken {
    /// Finds the mentions in an instruction. Among entities that share the last word of their names, those with the
    /// most matching words are meant: "the water glass" excludes the wine glass.
    pub fn of(world: &World, instruction: &str) -> Self {
        let words = asserted(instruction);
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
        let beaten = |id: EntityId, score: usize| {
            let name = heads[&id].as_str();
            best[name] > score && said.of_word(name).len() == 1
        };
        let implied = |id: EntityId| {
            let identifier = &world.entity(id).identifier;
            let mut stems = world
                .domain()
                .implied
                .iter()
                .filter(|(name, _)| matches_name(identifier, name));
            stems.any(|(_, stems)| begins_with_any(&words, stems))
        };
        let names = FullNames::of(world, &said, &singulars);
        let named: FxHashSet<EntityId> = scored
            .iter()
            .filter(|(id, score)| !beaten(*id, *score) && !names.cover(world, &said, *id))
            .map(|(id, _)| *id)
            .collect();
        let all = world.entities().map(|(id, _)| id);
        let entities: Vec<EntityId> = all.filter(|id| named.contains(id) || implied(*id)).collect();
        Self {
            entities,
            bare: bare(&words),
            singulars,
            words,
            clauses: Clauses::of(instruction),
            later: false,
            english: plain_words(instruction).iter().any(|word| among(ENGLISH, word)),
        }
    }

    /// Appends the mentions of a later utterance.
    pub(super) fn add(&mut self, later: Self) {
        self.entities.extend(later.entities);
        self.entities.sort_unstable();
        self.entities.dedup();
        self.words.extend(later.words);
        self.bare.extend(later.bare);
        self.singulars.extend(later.singulars);
        self.clauses.add(later.clauses);
        self.later = true;
        self.english |= later.english;
    }

    /// Returns true if the words are English.
    pub(crate) fn is_english(&self) -> bool {
        self.english
    }

    pub(super) fn words(&self) -> &[String] {
        &self.words
    }

    pub(super) fn clauses(&self) -> &Clauses {
        &self.clauses
    }

    /// Returns true if the instruction can mean several entities with these names: "both jars", "a jar and the other
    /// jar".
    pub fn several(&self, names: &[String]) -> bool {
        let heads: Vec<String> = names.iter().map(|name| head(name)).collect();
        let mut said = 0;
        for word in &self.words {
            let single = singular(word);
            let ours = heads.contains(&single);
            if among(SEVERAL, word) || (ours && *word != single) {
                return true;
            }
            said += usize::from(ours);
        }
        said > 1
    }

    /// Returns true if the instruction has `before` directly in front of a name of the entity, apart from articles.
    pub(super) fn has_phrase(&self, world: &World, before: &str, entity: EntityId) -> bool {
        world.entity(entity).names.iter().any(|name| {
            let phrase = bare(&plain_words(&format!("{before} {name}")));
            effort::spend(self.bare.len() / 16 + 1);
            !phrase.is_empty() && self.bare.windows(phrase.len()).any(|window| window == phrase)
        })
    }

    /// Returns true if a word that is no part of a mentioned entity's name begins with one of the stems.
    pub(super) fn says(&self, world: &World, stems: &[String]) -> bool {
        let names = self.entities.iter().flat_map(|entity| &world.entity(*entity).names);
        let parts: Vec<String> = names
            .flat_map(|name| plain_words(name))
            .map(|part| singular(&part))
            .collect();
        let other = self.words.iter().filter(|word| !parts.contains(&singular(word)));
        begins_with_any(&other.cloned().collect::<Vec<_>>(), stems)
    }

    /// Returns true if one of the prepositions in `before` leads to the entity, with at most two words of description
    /// between them: "into the big red box".
    pub(super) fn comes_after(&self, world: &World, entity: EntityId, before: &str) -> bool {
        const APART: &str = "and or with of from off out on onto in into to at by";
        let heads: Vec<String> = world.entity(entity).names.iter().map(|name| head(name)).collect();
        effort::spend(1 + self.words.len() / 4);
        let places = self
            .singulars
            .iter()
            .enumerate()
            .filter(|(_, word)| heads.contains(word));
        places.into_iter().any(|(place, _)| {
            let mut back = self.words[place.saturating_sub(4)..place].iter().rev();
            back.find(|word| among(APART, word) || among(before, word))
                .is_some_and(|word| among(before, word))
        })
    }

    /// Returns true if a word of the instruction begins with one of the stems.
    pub(super) fn has_any(&self, stems: &[String]) -> bool {
        begins_with_any(&self.words, stems)
    }
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
    /// For each name, its length in words and its start positions.
    occurrences: Vec<(usize, Vec<usize>)>,
    /// For each position, the longest name that covers it, and the longest one of another entity.
    longest: Vec<[(usize, Option<EntityId>); 2]>,
}

impl FullNames {
    fn of(world: &World, said: &Places<'_>, singulars: &[String]) -> Self {
        let mut numbers: FxHashMap<Vec<String>, Option<usize>> = FxHashMap::default();
        let mut names: FxHashMap<EntityId, Vec<usize>> = FxHashMap::default();
        let mut occurrences: Vec<(usize, Vec<usize>)> = Vec::new();
        // Two entities with a name suffice to find the longest name of any other entity.
        let mut owners: Vec<[Option<EntityId>; 2]> = Vec::new();
        for (id, entity) in world.entities() {
            for name in std::iter::once(&entity.name).chain(&entity.names) {
                let parts: Vec<String> = plain_words(name).iter().map(|part| singular(part)).collect();
                if parts.is_empty() {
                    continue;
                }
                let known = numbers.get(&parts).copied();
                let number = known.unwrap_or_else(|| {
                    let begins = said.of_word(&parts[0]).iter().copied();
                    let starts: Vec<usize> = begins.filter(|start| singulars[*start..].starts_with(&parts)).collect();
                    let number = (!starts.is_empty()).then_some(occurrences.len());
                    if number.is_some() {
                        occurrences.push((parts.len(), starts));
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
        for ((length, starts), owners) in occurrences.iter().zip(&owners) {
            for place in starts.iter().flat_map(|start| *start..start + length) {
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
            let (length, starts) = &self.occurrences[*number];
            for place in starts.iter().flat_map(|start| *start..start + length) {
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

/// Returns the singulars of the words that are no determiners.
fn bare(words: &[String]) -> Vec<String> {
    let kept = words.iter().filter(|word| !among(DETERMINERS, word));
    kept.map(|word| singular(word)).collect()
}

fn begins_with_any(words: &[String], stems: &[String]) -> bool {
    stems
        .iter()
        .any(|stem| words.iter().any(|word| word.starts_with(stem.as_str())))
}

/// Compares a goal with the instruction.
pub fn understand(world: &World, instruction: &str, goal: Goal) -> Understanding {
    let spoken = Spoken::of(world, instruction);
    let unknown = unknown_in(world, &spoken, instruction);
    understand_spoken(world, &spoken, unknown, goal)
}

/// Splits a goal into its supported and its other parts. A conditional goal keeps its supported parts.
fn sorted_out(fact: GoalFact, about: &impl Fn(&GoalFact) -> bool) -> Vec<GoalFact> {
    let GoalFact::If(conditional) = fact else {
        return vec![fact];
    };
    let (then, mut rest): (Vec<_>, Vec<_>) = conditional.then.into_iter().partition(about);
    let (otherwise, more): (Vec<_>, Vec<_>) = conditional.otherwise.into_iter().partition(about);
    rest.extend(more);
    if !(then.is_empty() && otherwise.is_empty()) {
        rest.push(GoalFact::If(Conditional {
            condition: conditional.condition,
            then,
            otherwise,
        }));
    }
    rest
}

/// Returns the question whether a goal is what the person wants.
pub(crate) fn guess(world: &World, goal: &Goal) -> String {
    let guess = goal.sentences(world).join("; ");
    format!("I am not sure what you want. Do you mean: {guess}?")
}

/// Compares a goal with parsed mentions. `unknown` is an object of the instruction that does not exist.
pub(crate) fn understand_spoken(world: &World, spoken: &Spoken, unknown: Option<String>, goal: Goal) -> Understanding {
    let domain = world.domain();
    let meant = &spoken.entities;
    let subject = |fact: &GoalFact| match fact {
        GoalFact::Word { word, arguments } => domain.goal_word(*word).subject.map(|parameter| arguments[parameter]),
        GoalFact::Plain(_) | GoalFact::Number(_) | GoalFact::If(_) | GoalFact::Choice(_) => None,
    };
    let is_meant = |fact: &GoalFact| {
        let is_mentioned = |entity| meant.contains(&entity);
        !spoken.is_english() || subject(fact).is_none_or(is_mentioned)
    };
    // A type of the domain is no word of the instruction.
    let of_type = |groups: &[Group]| groups.iter().any(|group| group.is_of_type(domain));
    let about_it = |fact: &GoalFact| match fact {
        GoalFact::Choice(choice) => of_type(&choice.groups) || choice.alternatives().any(is_meant),
        other => is_meant(other),
    };
    let about = |fact: &GoalFact| fact.parts().into_iter().all(about_it);
    if goal.is_empty() {
        return Understanding::Question("What should I do?".to_owned());
    }
    // Without one of its parts, an order, a prohibition or a group would mean something else.
    if !goal.stages.is_empty() || !goal.constraints.is_empty() || !goal.groups.is_empty() {
        let about = |fact: &GoalFact| match goal.grouped_part(fact) {
            Some(part) => of_type(&part.groups) || part.facts.iter().any(about),
            None => about(fact),
        };
        if goal.facts.iter().all(about) {
            let unclear = (!spoken.later).then(|| which(world, spoken, &goal)).flatten();
            return unclear.map_or_else(|| Understanding::Goal(goal, Vec::new()), Understanding::Which);
        }
        return Understanding::Question(guess(world, &goal));
    }
    // The goal is about something else because the instruction mentions an unknown object.
    if !goal.facts.iter().all(about)
        && let Some(missing) = unknown
    {
        return Understanding::Question(format!("I see no {missing} here. What do you mean by it?"));
    }
    let in_part = |fact: &GoalFact| fact.parts().into_iter().any(about_it);
    if goal.facts.iter().any(in_part) {
        let (kept, dropped): (Vec<_>, Vec<_>) = goal
            .facts
            .into_iter()
            .flat_map(|fact| sorted_out(fact, &about))
            .partition(about);
        let left_out = dropped
            .into_iter()
            .map(|fact| LeftOut {
                why: match subject(&fact) {
                    Some(entity) => format!("the instruction does not speak of {}", world.with_article(entity)),
                    None => String::new(),
                },
                fact,
            })
            .collect();
        let goal = Goal::from(kept);
        // This question is asked once; the model interprets the answer.
        let unclear = (!spoken.later).then(|| which(world, spoken, &goal)).flatten();
        return match unclear {
            Some(question) => Understanding::Which(question),
            None => Understanding::Goal(goal, left_out),
        };
    }
    // The instruction does not mention the goal's subject. The person is asked to confirm the guess, unless the
    // instruction mentions no entity and contains a cue of the goal ("It is dark in here").
    if let Some(fact @ GoalFact::Word { word, .. }) = goal.facts.first()
        && !(meant.is_empty() && spoken.has_any(&domain.goal_word(*word).cues))
    {
        let guess = fact.sentence(world);
        return Understanding::Question(format!("I am not sure what you want. Do you mean that {guess}?"));
    }
    let mut facts = goal.facts.into_iter();
    let first: Vec<GoalFact> = facts.next().into_iter().collect();
    let why = "the instruction does not speak of it".to_owned();
    let left_out = facts.map(|fact| LeftOut { fact, why: why.clone() }).collect();
    Understanding::Goal(Goal::from(first), left_out)
}

/// Returns an object in a text that does not exist, if the text is English. `spoken` are its mentions.
pub(super) fn unknown_in(world: &World, spoken: &Spoken, text: &str) -> Option<String> {
    spoken.is_english().then(|| unknown_thing(world, text)).flatten()
}

/// Finds a noun phrase after a determiner that matches no entity of the world.
pub fn unknown_thing(world: &World, instruction: &str) -> Option<String> {
    let domain = world.domain();
    let words = plain_words(instruction);
    let mut known: FxHashSet<String> = FxHashSet::default();
    for (_, entity) in world.entities() {
        for name in &entity.names {
            known.extend(plain_words(name).iter().map(|word| singular(word)));
        }
    }
    for word in &domain.goal_words {
        known.extend(plain_words(&word.word));
    }
    let mut at = 0;
    while at < words.len() {
        at += 1;
        if !among(DETERMINERS, &words[at - 1]) {
            continue;
        }
        let phrase: Vec<&String> = words[at..].iter().take_while(|word| !among(NOT_THINGS, word)).collect();
        // One known word makes the phrase known: "the big plate carefully".
        let is_ours = |word: &String| known.contains(&singular(word)) || is_word_of_outcomes(domain, word);
        let ours = phrase.iter().any(|word| is_ours(word));
        if !ours && !phrase.is_empty() {
            return Some(phrase.into_iter().take(3).cloned().collect::<Vec<_>>().join(" "));
        }
    }
    None
}
