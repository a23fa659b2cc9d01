//! Further tries at an answer that is a guess.
//!
//! A model writes the goal word that is likeliest at its place and must then go on, although an answer with another word is
//! likelier as a whole. A beam over whole answers would find that; a further answer that may not begin in the same way
//! finds most of it, and costs something only where the first one was a guess.

use super::ending::Endings;
use crate::goal::{Goal, GoalFact, Offer};

/// Maximum number of further tries.
const TRIES: usize = 2;

/// The answers so far to one instruction.
#[derive(Debug, Clone, Default)]
pub(super) struct Tries {
    /// The first goals of the answers so far.
    begins: Vec<GoalFact>,
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
        self.keep(endings, goal);
        true
    }

    fn keep(&mut self, endings: &Endings, goal: &Goal) {
        let is_better = |(best, _): &(Endings, Goal)| endings.likelihood() > best.likelihood();
        if self.best.as_ref().is_none_or(is_better) {
            self.best = Some((endings.clone(), goal.clone()));
        }
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

    /// Removes the goals with which the next answer must not begin: those with the goal word of the first answer, then the
    /// very goals with which the answers began.
    pub(super) fn remove(&self, offers: &mut Vec<Offer>) {
        let begins_with_word = |offer: &Offer| match &self.begins[..] {
            [GoalFact::Word { word, .. }] => offer.word == *word,
            _ => false,
        };
        offers.retain(|offer| !begins_with_word(offer));
        for offer in &mut *offers {
            let word = offer.word;
            offer.arguments.retain(|own| {
                let same = |begin: &GoalFact| matches!(begin, GoalFact::Word { word: other, arguments } if *other == word && arguments == own);
                !self.begins.iter().any(same)
            });
        }
        offers.retain(|offer| !offer.arguments.is_empty());
    }
}
