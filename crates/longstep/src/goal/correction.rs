//! Instructions with later utterances about the answers to them.

use super::mention::unknown_in;
use super::{GoalFact, QUESTION, Spoken, parse};
use crate::environment::{EntityId, World};
use crate::model::{head, plain_words, singular};

/// An instruction combined with later utterances, which take precedence.
#[derive(Debug, Clone, Default)]
pub(crate) struct Correction {
    /// The mentions.
    pub(crate) spoken: Spoken,
    /// Entities that are ruled out.
    pub(crate) excluded: Vec<EntityId>,
    /// Goals of earlier answers that the person rejected.
    pub(crate) rejected: Vec<GoalFact>,
    /// Goals of the last answer, if the last utterance only adds to them.
    pub(crate) begun: Vec<GoalFact>,
    /// An object in the last utterance that does not exist.
    pub(crate) unknown: Option<String>,
}

/// Words that begin a negation, up to the next punctuation mark or "but".
const DENYING: &str = "not dont isnt wasnt never neither nor";
/// Words that reject an answer.
const CORRECTING: &str = "no not dont isnt instead rather wrong other different meant wanted actually nope sorry else";
/// Words that confirm.
const AGREEING: &str = "yes yeah yep right exactly sure correct ok okay please";
/// Words that extend an answer and do not reject it.
const ADDING: &str = "also too well additionally afterwards besides plus";

fn among(list: &str, word: &str) -> bool {
    list.split_whitespace().any(|entry| entry == word)
}

impl Correction {
    /// Starts with an instruction.
    pub(crate) fn of(world: &World, instruction: &str) -> Self {
        let spoken = Spoken::of(world, instruction);
        Self {
            unknown: unknown_in(world, &spoken, instruction),
            spoken,
            ..Self::default()
        }
    }

    /// Takes in an utterance about an answer (goals or a question).
    ///
    /// Words after "not" rule entities out, preferably those of the answer. "The other one" excludes the entity of the
    /// answer. An entity that the utterance names replaces entities with the same last word that only the instruction
    /// mentions.
    pub(crate) fn hear(&mut self, world: &World, answer: &str, said: &str) {
        let domain = world.domain();
        let facts = match answer.starts_with(QUESTION) {
            true => Vec::new(),
            false => parse(world, answer).map_or_else(|_| Vec::new(), |goal| goal.facts),
        };
        let handled: Vec<EntityId> = facts.iter().flat_map(|fact| fact.about(domain)).collect();
        // "Yes" refers to the content of the question.
        let agrees =
            answer.starts_with(QUESTION) && plain_words(said).first().is_some_and(|word| among(AGREEING, word));
        let said = match agrees {
            true => &format!("{said}, {}", answer.trim_start_matches(QUESTION)),
            false => said,
        };
        let (meant, denied) = parts(said);
        let mut not_meant = exactly(world, Spoken::of(world, &denied).entities, &denied);
        // "Not that plate" rules out the plate of the answer.
        if not_meant.iter().any(|entity| handled.contains(entity)) {
            not_meant.retain(|entity| handled.contains(entity));
        }
        let head_of = |entity: &EntityId| head(&world.entity(*entity).name);
        let one = not_meant.first().or(handled.first()).map(head_of);
        let meant = with_noun(&meant, one.as_deref());
        let words: Vec<String> = plain_words(&meant).iter().map(|word| singular(word)).collect();
        if let Some(at) = words
            .iter()
            .position(|word| word == "other" || word == "another" || word == "different")
        {
            let others = handled.iter().filter(|entity| words[at..].contains(&head_of(entity)));
            not_meant.extend(others);
        }
        let heard = Spoken::of(world, &meant);
        let mut named = exactly(world, heard.entities.clone(), &meant);
        named.retain(|entity| !not_meant.contains(entity));
        let stands_for_it = |entity: &EntityId| named.iter().any(|other| head_of(other) == head_of(entity));
        self.unknown = unknown_in(world, &heard, &meant);
        self.spoken.add(heard);
        self.spoken
            .entities
            .retain(|entity| named.contains(entity) || !(not_meant.contains(entity) || stands_for_it(entity)));
        for entity in named
            .iter()
            .filter(|entity| !self.spoken.entities.contains(entity))
            .copied()
            .collect::<Vec<_>>()
        {
            self.spoken.entities.push(entity);
        }
        self.spoken.entities.sort_unstable();
        self.excluded.retain(|entity| !named.contains(entity));
        let tokens = plain_words(said);
        let takes_back = tokens.iter().any(|word| among(CORRECTING, word));
        let adds = tokens.iter().any(|word| among(ADDING, word));
        self.begun = if adds && !takes_back { facts.clone() } else { Vec::new() };
        if takes_back && !adds {
            let all = facts.len() == 1;
            let wrong = |fact: &GoalFact| all || fact.about(domain).iter().any(|entity| not_meant.contains(entity));
            self.rejected.extend(facts.into_iter().filter(wrong));
        }
        self.excluded.extend(not_meant);
    }
}

/// Filters entities that share a last word by an explicit number: "mug 3" excludes the other mugs.
fn exactly(world: &World, mut entities: Vec<EntityId>, words: &str) -> Vec<EntityId> {
    let words = plain_words(words);
    let by_number = |entity: &EntityId| {
        let name = plain_words(&world.entity(*entity).name);
        let numbered = name.last().is_some_and(|last| last.parse::<usize>().is_ok());
        numbered && words.windows(name.len()).any(|window| window == name)
    };
    let exact: Vec<EntityId> = entities.iter().copied().filter(by_number).collect();
    let head_of = |entity: &EntityId| head(&world.entity(*entity).name);
    let numbered_kind = |entity: &EntityId| exact.iter().any(|other| head_of(other) == head_of(entity));
    entities.retain(|entity| exact.contains(entity) || !numbered_kind(entity));
    entities
}

/// Splits an utterance into its asserted and its negated part: "not that plate, the blue one" gives "the blue one" and
/// "that plate".
pub(crate) fn parts(said: &str) -> (String, String) {
    let (mut meant, mut denied) = (String::new(), String::new());
    for clause in said.split([',', '.', ';', '!', '?', ':']) {
        let mut denying = false;
        let words: Vec<&str> = clause.split_whitespace().collect();
        for (at, word) in words.iter().enumerate() {
            let plain = plain_words(word).concat();
            let pair =
                |first: &str, second: &str| plain == first && words.get(at + 1).is_some_and(|next| *next == second);
            if among(DENYING, &plain) || pair("instead", "of") || pair("rather", "than") {
                denying = true;
            } else if plain == "but" {
                denying = false;
            }
            let part = if denying { &mut denied } else { &mut meant };
            part.push_str(word);
            part.push(' ');
        }
        meant.push_str(", ");
    }
    (meant, denied)
}

/// Replaces "one" and "ones" by the noun.
fn with_noun(words: &str, noun: Option<&str>) -> String {
    let Some(noun) = noun else { return words.to_owned() };
    let one = |word: &str| matches!(word.to_lowercase().as_str(), "one" | "ones");
    let replaced = words.split_whitespace().map(|word| match one(word) {
        true => noun,
        false => word,
    });
    replaced.collect::<Vec<_>>().join(" ")
}
