//! Goals that words request by themselves, whatever else the instruction before them was about.

use super::Spoken;
use super::mention::among;
use crate::environment::{EntityId, World};
use crate::model::{GoalWordId, plain_words};
use longstep_core::model::Domain;

/// Pronouns that stand for an entity of an earlier sentence.
const PRONOUNS: &str = "it them these those that this one ones both all";

/// The words of a person, as evidence for goals.
#[derive(Debug, Clone)]
pub(crate) struct Request {
    spoken: Spoken,
    /// True if the words name no entity and refer to one by a pronoun.
    has_pronoun: bool,
}

impl Request {
    /// Reads what the words mention.
    pub(crate) fn of(world: &World, words: &str) -> Self {
        let spoken = Spoken::of(world, words);
        let refers = plain_words(words).iter().any(|word| among(PRONOUNS, word));
        Self {
            has_pronoun: refers && spoken.entities.is_empty(),
            spoken,
        }
    }

    /// Returns true if the words have a cue of the goal word and mention its subject.
    pub(crate) fn asks_for(&self, domain: &Domain, id: GoalWordId, arguments: &[EntityId]) -> bool {
        let word = domain.goal_word(id);
        let cues = match word.cues.is_empty() {
            true => &word.destination_verbs,
            false => &word.cues,
        };
        let subjects = match word.subject {
            Some(parameter) => &arguments[parameter..=parameter],
            None => arguments,
        };
        let mentioned = subjects.iter().any(|entity| self.spoken.entities.contains(entity));
        (cues.is_empty() || self.spoken.has_any(cues)) && (mentioned || self.has_pronoun)
    }
}
