//! When an answer of a model is acted on, and when the person is asked: one table.

use crate::dialogue::nats;
use crate::reading::Decision;

/// The kind of model that answers, and the limits that follow. Likelihoods are in thousandths of a nat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Profile {
    /// The name, for `--explain`.
    pub name: &'static str,
    /// The likelihood below which a goal is a question; none for a model that is believed.
    pub goal: Option<i64>,
    /// The likelihood below which a goal is a question although no other answer is nearly as likely: by `ahead`.
    pub goal_ahead: Option<i64>,
    /// The likelihood above which the best goal is acted on although the model would ask.
    pub instead_of_question: Option<i64>,
    /// The likelihood of a prohibition behind a goal that has none, from which on the person is asked whether it is meant; none for a
    /// model that is not asked for it.
    pub prohibition: Option<i64>,
    /// True if the person is asked which one is meant where the words name several things that the goal could be about.
    pub asks_which: bool,
}

impl Profile {
    /// A model with the adapter for this request. The limits were set on development data: `kitchen`, `test`, and the prohibitions for
    /// four robots.
    pub const TRAINED: Self = Self {
        name: "trained",
        goal: Some(-700),
        goal_ahead: Some(-4000),
        instead_of_question: Some(-700),
        prohibition: Some(-8_000),
        asks_which: false,
    };
    /// A model that gives likelihoods and was not trained: it is sure of little.
    pub const UNTRAINED: Self = Self {
        name: "untrained",
        goal: Some(-1500),
        goal_ahead: None,
        instead_of_question: None,
        prohibition: None,
        asks_which: true,
    };
    /// A model without likelihoods, as servers have them. It is strong, or chosen by somebody who knows it: it is believed.
    pub const BELIEVED: Self = Self {
        name: "believed",
        goal: None,
        goal_ahead: None,
        instead_of_question: None,
        prohibition: None,
        asks_which: false,
    };
}

impl Profile {
    /// Returns the limit that a decision came from, in nats.
    pub(super) fn limit(&self, decision: Decision) -> Option<f64> {
        match decision {
            Decision::Act | Decision::AskForUnlikely => self.goal,
            Decision::ActOnOnly => self.goal_ahead,
            Decision::ActInsteadOfAsking | Decision::Ask => self.instead_of_question,
            Decision::AskForProhibition => self.prohibition,
            Decision::AskWhich => None,
        }
        .map(nats)
    }

    /// Decides about an answer: `question` says that the model would ask, `likelihood` is that of its best goal, and `ahead` by how much it is
    /// likelier than every other answer.
    pub fn decide(&self, question: bool, likelihood: Option<i64>, ahead: Option<i64>) -> Decision {
        let reaches = |limit: Option<i64>| match (limit, likelihood) {
            (Some(limit), Some(likelihood)) => likelihood >= limit,
            _ => false,
        };
        if question {
            return if reaches(self.instead_of_question) {
                Decision::ActInsteadOfAsking
            } else {
                Decision::Ask
            };
        }
        let is_alone = ahead.is_some_and(|ahead| ahead >= AHEAD);
        match self.goal.is_none() || likelihood.is_none() || reaches(self.goal) {
            true => Decision::Act,
            false if is_alone && reaches(self.goal_ahead) => Decision::ActOnOnly,
            false => Decision::AskForUnlikely,
        }
    }
}

/// The distance to every other answer, in thousandths of a nat, from which on an answer is the only one. The words of a goal
/// that a grammar allows can be others than those that the model would choose.
const AHEAD: i64 = 1500;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profile_decides_each_kind_of_answer() {
        let near = Some(200);
        for (profile, question, likelihood, ahead, expected) in [
            (Profile::TRAINED, false, Some(-10), None, Decision::Act),
            (Profile::TRAINED, false, Some(-3000), near, Decision::AskForUnlikely),
            (Profile::TRAINED, false, Some(-3000), Some(2000), Decision::ActOnOnly),
            (
                Profile::TRAINED,
                false,
                Some(-9000),
                Some(2000),
                Decision::AskForUnlikely,
            ),
            (Profile::TRAINED, true, Some(-10), None, Decision::ActInsteadOfAsking),
            (Profile::TRAINED, true, Some(-5000), Some(2000), Decision::Ask),
            (Profile::TRAINED, true, None, None, Decision::Ask),
            (Profile::UNTRAINED, true, Some(-10), None, Decision::Ask),
            (Profile::BELIEVED, false, None, None, Decision::Act),
            (Profile::BELIEVED, true, None, None, Decision::Ask),
        ] {
            assert_eq!(
                profile.decide(question, likelihood, ahead),
                expected,
                "{}",
                profile.name
            );
        }
    }
}
