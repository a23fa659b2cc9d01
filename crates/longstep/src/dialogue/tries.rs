//! Further tries at an answer that is a guess.
//!
//! A model writes the goal word that is likeliest at its place and must then go on, although an answer with another word is
//! likelier as a whole. A beam over whole answers would find that; a further answer that may not begin in the same way
//! finds most of it, and costs something only where the first one was a guess.

use super::ending::Endings;
use crate::environment::EntityId;
use crate::goal::{Goal, GoalFact, Offer};
use crate::model::GoalWordId;

/// Maximum number of further tries.
const TRIES: usize = 3;

/// The answers so far to one instruction.
#[derive(Debug, Clone, Default)]
pub(super) struct Tries {
    /// The first goals of the answers so far, within a condition or not.
    begins: Vec<GoalFact>,
    /// The first goals of answers that the person has rejected.
    refused: Vec<GoalFact>,
    /// The likeliest answer so far.
    best: Option<(Endings, Goal)>,
    stage: Stage,
}

/// The kind of the next answer.
#[derive(Debug, Clone, Default)]
enum Stage {
    #[default]
    First,
    /// The answer in which names narrow nothing, after one with this first goal.
    Free(Option<GoalFact>),
    Narrowed,
}

impl Tries {
    /// Takes an answer that is a guess. Returns true if another one is worth a try.
    ///
    /// A model that was trained for the task first tries an answer without regard to names: what a person means may have
    /// another name in the instruction ("the oak one"), beside the names of other things.
    pub(super) fn again(&mut self, endings: &Endings, goal: &Goal) -> bool {
        let first = first_goal(goal).cloned();
        let first = match std::mem::replace(&mut self.stage, Stage::Narrowed) {
            Stage::First if endings.is_trained() => {
                self.stage = Stage::Free(first);
                self.best = Some((endings.clone(), goal.clone()));
                return true;
            }
            Stage::Free(first) => first,
            Stage::First | Stage::Narrowed => first,
        };
        let Some(begin @ GoalFact::Word { .. }) = first else {
            return false;
        };
        if self.begins.len() >= TRIES {
            return false;
        }
        self.begins.push(begin);
        self.best = Some(self.likeliest(endings.clone(), goal.clone()));
        true
    }

    /// Takes an answer that the person has rejected. Returns true if another one is worth a try.
    pub(super) fn refuse(&mut self, goal: &Goal) -> bool {
        let begin = first_goal(goal).filter(|begin| matches!(begin, GoalFact::Word { .. }));
        let Some(begin) = begin.filter(|_| self.refused.len() < TRIES) else {
            return false;
        };
        self.refused.push(begin.clone());
        true
    }

    /// Returns the likeliest of all answers. One without a condition is never likelier than one with it: it is shorter, and does
    /// what was asked for in one case only.
    pub(super) fn likeliest(&mut self, endings: Endings, goal: Goal) -> (Endings, Goal) {
        let order = |endings: &Endings, goal: &Goal| (goal.depends(), endings.likelihood());
        match self.best.take() {
            Some((best, other)) if order(&best, &other) >= order(&endings, &goal) => (best, other),
            _ => (endings, goal),
        }
    }

    /// Keeps the first goals that are open to the next answer. The second one begins with goals about nothing but named
    /// entities, and as many of them as there is a goal for, unless the first did. Then the goal words of the answers before
    /// are barred, and in the last one the very goals.
    pub(super) fn keep(&self, offers: &mut Vec<Offer>, named: &[EntityId]) {
        if self.is_free() {
            return;
        }
        let count = |arguments: &[EntityId]| match arguments.iter().all(|entity| named.contains(entity)) {
            true => arguments.len(),
            false => 0,
        };
        if let [GoalFact::Word { arguments, .. }] = self.begins.as_slice() {
            let all = offers.iter().flat_map(|offer| &offer.arguments);
            let most = all.map(|arguments| count(arguments)).max().unwrap_or(0);
            if count(arguments) < most {
                retain(offers, |_, arguments| count(arguments) == most);
                return;
            }
        }
        let is_last = self.begins.len() == TRIES;
        let has_word = |begin: &GoalFact, own: GoalWordId| matches!(begin, GoalFact::Word { word, .. } if *word == own);
        retain(offers, |word, arguments| {
            let is_begun = self.begins.iter().any(|begin| match is_last {
                true => begin.is_word(word, arguments),
                false => has_word(begin, word),
            });
            !is_begun && !self.refused.iter().any(|begin| begin.is_word(word, arguments))
        });
    }

    /// Returns true if this is not the first answer.
    pub(super) fn has_begun(&self) -> bool {
        !self.begins.is_empty() || self.is_free()
    }

    /// Returns true if names narrow nothing in this answer.
    pub(super) fn is_free(&self) -> bool {
        matches!(self.stage, Stage::Free(_))
    }
}

/// Returns the first goal of an answer: of one with a condition, what is to be done then.
fn first_goal(goal: &Goal) -> Option<&GoalFact> {
    goal.facts.first()?.parts().first().copied()
}

/// Keeps the arguments that fit.
fn retain(offers: &mut Vec<Offer>, fits: impl Fn(GoalWordId, &[EntityId]) -> bool) {
    for offer in offers.iter_mut() {
        let word = offer.word;
        offer.arguments.retain(|arguments| fits(word, arguments));
    }
    offers.retain(|offer| !offer.arguments.is_empty());
}
