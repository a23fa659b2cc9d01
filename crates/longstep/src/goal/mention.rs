//! Does the goal fit what the instruction speaks of?
//!
//! The commonest mistake of a small model is a goal too many, about a thing that nobody mentioned. Code can
//! see that: a goal whose subject the instruction does not speak of is left out, and shown as left out. When
//! nothing is left, or when the instruction speaks of a thing that is not there, the person is asked.

use super::{Goal, GoalFact};
use crate::domain::{Domain, plain_words, singular};
use crate::world::{EntityId, World};

/// What was made of a model's answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Understanding {
    /// A goal, and what was left out of it.
    Goal(Goal, Vec<LeftOut>),
    /// The person must say more first.
    Question(String),
}

/// A goal that the model named and the instruction does not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// The goal.
    pub fact: GoalFact,
    /// Why, for a person.
    pub why: String,
}

/// Words that stand between a determiner and its noun's end, and other words that name no thing.
const NOT_THINGS: &[&str] = &[
    "a",
    "about",
    "above",
    "after",
    "again",
    "all",
    "an",
    "and",
    "another",
    "any",
    "anything",
    "around",
    "as",
    "at",
    "away",
    "back",
    "be",
    "before",
    "beside",
    "both",
    "bottom",
    "but",
    "by",
    "can",
    "down",
    "each",
    "every",
    "everything",
    "first",
    "for",
    "from",
    "front",
    "half",
    "here",
    "in",
    "inside",
    "into",
    "is",
    "it",
    "its",
    "last",
    "left",
    "lower",
    "me",
    "middle",
    "my",
    "near",
    "next",
    "now",
    "of",
    "off",
    "on",
    "one",
    "onto",
    "or",
    "other",
    "our",
    "out",
    "over",
    "place",
    "please",
    "rest",
    "right",
    "room",
    "same",
    "second",
    "side",
    "so",
    "some",
    "somewhere",
    "spot",
    "that",
    "the",
    "them",
    "then",
    "there",
    "these",
    "thing",
    "this",
    "those",
    "through",
    "to",
    "together",
    "too",
    "top",
    "two",
    "under",
    "until",
    "up",
    "upper",
    "using",
    "way",
    "where",
    "which",
    "while",
    "with",
    "your",
    "you",
    "bit",
    "little",
    "time",
    "work",
    "rid",
    "use",
    "not",
    "will",
    "would",
    "could",
    "should",
    "still",
];

const DETERMINERS: &[&str] = &[
    "the", "a", "an", "that", "this", "my", "your", "some", "those", "these", "our",
];

/// Looks at a goal against the instruction.
pub fn understand(domain: &Domain, world: &World, instruction: &str, goal: Goal) -> Understanding {
    let meant = spoken_of(world, instruction);
    let subject = |fact: &GoalFact| match fact {
        GoalFact::Word { word, arguments } => domain.goal_word(*word).subject.map(|parameter| arguments[parameter]),
        GoalFact::Plain(_) => None,
    };
    let about = |fact: &GoalFact| subject(fact).is_none_or(|entity| meant.contains(&entity));
    if goal.facts.is_empty() {
        return Understanding::Question("What should I do?".to_owned());
    }
    if goal.facts.iter().any(about) {
        let (kept, dropped): (Vec<_>, Vec<_>) = goal.facts.into_iter().partition(about);
        let left_out = dropped
            .into_iter()
            .map(|fact| LeftOut {
                why: match subject(&fact) {
                    Some(entity) => format!(
                        "the instruction does not speak of {}",
                        world.entity(entity).with_article()
                    ),
                    None => String::new(),
                },
                fact,
            })
            .collect();
        return Understanding::Goal(Goal { facts: kept }, left_out);
    }
    // The goal is about something else. If the instruction names a thing that is not here, that is why.
    if let Some(missing) = unknown_thing(domain, world, instruction) {
        return Understanding::Question(format!("I see no {missing} here. What do you mean by it?"));
    }
    let mut facts = goal.facts.into_iter();
    let first = facts.next().into_iter().collect();
    let why = "the instruction does not speak of it".to_owned();
    let left_out = facts.map(|fact| LeftOut { fact, why: why.clone() }).collect();
    Understanding::Goal(Goal { facts: first }, left_out)
}

/// The entities that an instruction can speak of. Of things that share their last word, those that fit better win:
/// "the water glass" is not the wine glass.
pub fn spoken_of(world: &World, instruction: &str) -> Vec<EntityId> {
    let words: Vec<String> = plain_words(instruction).iter().map(|word| singular(word)).collect();
    let scored: Vec<(EntityId, usize)> = world
        .entities()
        .map(|(id, entity)| (id, entity.words_in(&words)))
        .filter(|(_, score)| *score > 0)
        .collect();
    let head = |id: EntityId| -> Option<String> {
        let name = plain_words(&world.entity(id).name);
        name.into_iter()
            .rev()
            .find(|word| !word.starts_with(|c: char| c.is_ascii_digit()))
            .map(|w| singular(&w))
    };
    let beaten = |id: EntityId, score: usize| {
        scored
            .iter()
            .any(|(other, better)| *better > score && head(*other) == head(id))
            && words
                .iter()
                .filter(|word| Some(word.as_str()) == head(id).as_deref())
                .count()
                == 1
    };
    scored
        .iter()
        .filter(|(id, score)| !beaten(*id, *score))
        .map(|(id, _)| *id)
        .collect()
}

/// A thing that the instruction names with a determiner and that nothing in the world is called.
pub fn unknown_thing(domain: &Domain, world: &World, instruction: &str) -> Option<String> {
    let words = plain_words(instruction);
    let mut known: Vec<String> = Vec::new();
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
        if !DETERMINERS.contains(&words[at - 1].as_str()) {
            continue;
        }
        let phrase: Vec<&String> = words[at..]
            .iter()
            .take_while(|word| !NOT_THINGS.contains(&word.as_str()))
            .collect();
        // Any known word in the phrase makes it one of ours: "the big plate carefully".
        let ours = phrase.iter().any(|word| known.contains(&singular(word)));
        if let (false, Some(first)) = (ours || phrase.is_empty(), phrase.first()) {
            return Some((*first).clone());
        }
    }
    None
}
