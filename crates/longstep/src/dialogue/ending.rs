//! The end of an answer that is written goal by goal.
//!
//! Token by token, a model goes on after a goal where that is a little more likely than to stop, and must then write some
//! goal, however unlikely. Whole answers are compared here instead: an answer ends where all of its text, with its end, is
//! most likely.

use super::Likelihood;
use crate::goal::{AND, ELSE, JOINT};

/// Likelihoods below which an answer is a guess, in thousandths of a nat (docs/experiments.md has the measurement).
struct Limits {
    /// For an instruction that names an entity of the environment.
    named: i64,
    /// For any other instruction, where nothing else speaks for the answer.
    unnamed: i64,
    /// For an answer with a condition; none if it is never a guess.
    conditional: Option<i64>,
}

/// The limits for a model that was not trained for the task.
const UNTRAINED: Limits = Limits {
    named: -4000,
    unnamed: -1500,
    // It rarely finds the notation of a condition likely.
    conditional: None,
};

/// The limits for a model that was.
const TRAINED: Limits = Limits {
    named: -1500,
    unnamed: -800,
    conditional: Some(-1200),
};

/// A token that the grammar forces counts this many times less than one that the model chose.
///
/// Counted in full, such tokens make each goal unlikely that the model would have put in other words. Not counted, a goal that
/// shares its first letters with a likely one is as likely as that.
const FORCED: i64 = 4;

/// The likelihoods of an answer that ends after one of its goals.
#[derive(Debug, Clone, Default)]
pub(super) struct Endings {
    /// Likelihood of the answer so far, without an end.
    sum: i64,
    /// The likeliest answer with an end: its likelihood and length in bytes.
    best: Option<(i64, usize)>,
    /// True if the model gave a likelihood.
    is_weighed: bool,
    /// True if the model was trained for the task.
    is_trained: bool,
}

impl Endings {
    /// Returns the likelihood below which the answer is a guess; none if it never is.
    pub(super) fn least(&self, names_entities: bool, depends: bool) -> Option<i64> {
        let limits = if self.is_trained { TRAINED } else { UNTRAINED };
        match (depends, names_entities) {
            (true, _) => limits.conditional,
            (false, true) => Some(limits.named),
            (false, false) => Some(limits.unnamed),
        }
    }

    /// Returns the likelihood of the answer where it ends best.
    pub(super) fn likelihood(&self) -> i64 {
        self.best.map_or(self.sum, |(best, _)| best.max(self.sum))
    }

    /// Returns true if the model was trained for the task.
    pub(super) fn is_trained(&self) -> bool {
        self.is_trained
    }

    /// Returns [`Self::likelihood`], if the model gave any.
    pub(super) fn weighed(&self) -> Option<i64> {
        self.is_weighed.then(|| self.likelihood())
    }

    /// Counts the next reply of an answer, which has the given length without it. Returns the length of the answer that
    /// is likelier than this one and any that begins with it, if there is one.
    pub(super) fn count(&mut self, length: usize, reply: &str, likelihood: Likelihood) -> Option<usize> {
        let forced = likelihood.forced / FORCED;
        let goal = [JOINT, AND, ELSE].iter().find_map(|joint| reply.strip_suffix(joint));
        if let (Some(goal), Some(ended)) = (goal, likelihood.ended) {
            let ended = self.sum + ended + forced;
            if self.best.is_none_or(|(best, _)| ended > best) {
                self.best = Some((ended, length + goal.len()));
            }
        }
        self.sum += likelihood.text + forced;
        self.is_weighed = true;
        self.is_trained |= likelihood.is_trained;
        self.best.filter(|(best, _)| *best > self.sum).map(|(_, length)| length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_ends_where_its_whole_text_is_likeliest() {
        // Each reply with the likelihoods of its text and of an end before its joint.
        type Answer<'a> = (&'a [(&'a str, i64, Option<i64>)], Option<&'a str>);
        let answers: [Answer<'_>; 5] = [
            // Going on is likelier than the end, and the goal that follows is not.
            (
                &[("on(lamp) &", -500, Some(-1000)), (" on(radio)", -2000, None)],
                Some("on(lamp)"),
            ),
            (&[("on(lamp) &", -100, Some(-4000)), (" on(radio)", -2000, None)], None),
            (&[("on(lamp)", -900, None)], None),
            // Two goals, and not three.
            (
                &[
                    ("on(lamp) &", -100, Some(-4000)),
                    (" on(radio) &", -700, Some(-1200)),
                    (" on(fan)", -3000, None),
                ],
                Some("on(lamp) & on(radio)"),
            ),
            // No end was possible.
            (
                &[("if dirty(cup) then", -100, None), (" clean(cup)", -5000, None)],
                None,
            ),
        ];
        for (replies, expected) in answers {
            let (mut endings, mut answer, mut found) = (Endings::default(), String::new(), None);
            for (text, likelihood, ended) in replies {
                let likelihood = Likelihood {
                    text: *likelihood,
                    ended: *ended,
                    ..Likelihood::default()
                };
                found = endings.count(answer.len(), text, likelihood);
                answer.push_str(text);
            }
            assert_eq!(found.map(|length| &answer[..length]), expected, "{replies:?}");
        }
    }
}
