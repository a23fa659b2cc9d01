//! Further tries at an answer that is a guess.
//!
//! A model writes the goal word that is likeliest at its place and must then go on, although an answer with another word is
//! likelier as a whole. A beam over whole answers would find that; a further answer that may not begin in the same way
//! finds most of it, and costs something only where the first one was a guess.

use super::ending::Endings;
use crate::environment::EntityId;
use crate::goal::{Goal, GoalFact};
use crate::model::GoalWordId;

/// Maximum number of further tries.
const TRIES: usize = 2;

/// The answers so far to one instruction.
#[derive(Debug, Clone, Default)]
pub(super) struct Tries {
    /// The first goals of the answers so far.
    begins: Vec<GoalFact>,
    /// The first goals of answers that the person has rejected.
    refused: Vec<GoalFact>,
    /// The likeliest answer so far.
    best: Option<(Endings, Goal)>,
}

impl Tries {
    /// Takes an answer that is a guess. Returns true if another one is worth a try.
    pub(super) fn again(&mut self, endings: &Endings, goal: &Goal) -> bool {
        let Some(begin @ GoalFact::Word { .. }) = goal.facts.first() else {
            return false;
        };
        if self.begins.len() >= TRIES {
            return false;
        }
        self.begins.push(begin.clone());
        self.best = Some(self.likeliest(endings.clone(), goal.clone()));
        true
    }

    /// Takes an answer that the person has rejected. Returns true if another one is worth a try.
    pub(super) fn refuse(&mut self, goal: &Goal) -> bool {
        let begin = goal
            .facts
            .first()
            .filter(|begin| matches!(begin, GoalFact::Word { .. }));
        let Some(begin) = begin.filter(|_| self.refused.len() < TRIES) else {
            return false;
        };
        self.refused.push(begin.clone());
        true
    }

    /// Returns the likeliest of all answers.
    pub(super) fn likeliest(&mut self, endings: Endings, goal: Goal) -> (Endings, Goal) {
        match self.best.take() {
            Some((best, other)) if best.likelihood() >= endings.likelihood() => (best, other),
            _ => (endings, goal),
        }
    }

    /// Returns true if this is not the first answer.
    pub(super) fn has_begun(&self) -> bool {
        !self.begins.is_empty()
    }

    /// Returns true if the next answer must not begin with this goal: it has the goal word of the first answer, or later, an
    /// answer began with the very goal.
    pub(super) fn bar(&self, word: GoalWordId, arguments: &[EntityId]) -> bool {
        let is_alone = self.begins.len() == 1;
        let has_word = |begin: &GoalFact| matches!(begin, GoalFact::Word { word: begun, .. } if *begun == word);
        self.begins.iter().any(|begin| is_alone && has_word(begin))
            || self
                .begins
                .iter()
                .chain(&self.refused)
                .any(|begin| begin.is_word(word, arguments))
    }
}
