//! Instructions with later utterances about the answers to them.

use super::{GoalFact, Mentions, QUESTION, parse};
use crate::environment::World;

/// An instruction combined with later utterances.
#[derive(Debug, Clone, Default)]
pub(crate) struct Correction {
    /// The names in the instruction and the later utterances.
    pub(crate) mentions: Mentions,
    /// The goals of earlier answers. The person has said something else since, so no answer ends with them again.
    pub(crate) rejected: Vec<Vec<GoalFact>>,
}

impl Correction {
    /// Starts with an instruction.
    pub(crate) fn of(world: &World, instruction: &str) -> Self {
        Self {
            mentions: Mentions::of(world, instruction),
            ..Self::default()
        }
    }

    /// Takes in an utterance about an answer (goals or a question).
    ///
    /// An answer to a question that names nothing ("yes") is about what the question names.
    pub(crate) fn hear(&mut self, world: &World, answer: &str, words: &str) {
        let mut named = Mentions::of(world, words);
        match answer.strip_prefix(QUESTION) {
            Some(question) if named.entities.is_empty() => named = Mentions::of(world, question),
            Some(_) => {}
            None => self.rejected.extend(parse(world, answer).map(|goal| goal.facts)),
        }
        self.mentions.add(world, named);
    }
}
