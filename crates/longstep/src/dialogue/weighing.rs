//! Weighing: how likely a model finds whole answers to a wish, in both of its wordings.
//!
//! A model that writes an answer chooses each token by those before it, and most tokens are forced by the grammar. Here the
//! answers are given, and every token of them counts, with their end. An answer that a model finds likely both for what
//! a person said and for its retelling, and much likelier than every other one, is what was meant; about anything else the
//! person is asked.

use super::{Candidate, Doubt, Reading, ReadingOf, Reply, nats};
use crate::environment::World;
use crate::goal::{self, Goal, JOINT};

/// Maximum number of answers.
const ANSWERS: usize = 6;
/// Maximum number of answers of one reading, without those that begin the chosen one.
const OF_READING: usize = 3;
/// Likelihood for both wordings below which the likeliest answer is a guess, in thousandths of a nat (docs/experiments.md has
/// the measurement).
const LEAST: i64 = -8000;
/// Likelihood for both wordings below which an answer is a guess to which only an unsure retelling led.
const LEAST_RETOLD: i64 = -4000;
/// Distance to the next answer, for both wordings, below which the likeliest one is a guess.
const MARGIN: i64 = 1500;

/// Answers to a wish whose likelihoods are asked for, with one request for each answer and wording.
#[derive(Debug, Clone)]
pub(crate) struct Weighing {
    wordings: [String; 2],
    answers: Vec<Answer>,
    /// Number of replies so far.
    replies: usize,
}

/// An answer with the sum of its likelihoods so far.
#[derive(Debug, Clone)]
struct Answer {
    text: String,
    sum: i64,
    /// True if a reading that can be relied on led to it.
    counts: bool,
}

impl Weighing {
    /// Starts to weigh the answers of these readings, each with true if it can be relied on; none if no answer is a goal. The
    /// answers of the other readings have to be likelier.
    pub(crate) fn new<'a>(
        world: &World,
        wordings: [String; 2],
        readings: impl Iterator<Item = (&'a Reading, bool)>,
    ) -> Option<Self> {
        let mut answers: Vec<Answer> = Vec::new();
        for (reading, counts) in readings {
            for text in answers_of(world, reading) {
                if answers.len() < ANSWERS && answers.iter().all(|own| own.text != text) {
                    answers.push(Answer { text, sum: 0, counts });
                }
            }
        }
        (!answers.is_empty()).then_some(Self {
            wordings,
            answers,
            replies: 0,
        })
    }

    /// Returns true if every answer has been weighed for every wording.
    pub(crate) fn is_done(&self) -> bool {
        self.replies >= self.answers.len() * self.wordings.len()
    }

    /// Returns the wording and the answer that the next reply is about.
    pub(crate) fn next(&self) -> (&str, &str) {
        let wording = (self.replies / self.answers.len()).min(self.wordings.len() - 1);
        let answer = &self.answers[self.replies % self.answers.len()];
        (&self.wordings[wording], &answer.text)
    }

    /// Counts a reply: the answer, or the answer and the joint of a further goal.
    pub(crate) fn count(&mut self, reply: &Reply) {
        let at = self.replies % self.answers.len();
        let whole = reply.likelihood.map(|likelihood| {
            let text = match reply.text.ends_with(JOINT) {
                true => likelihood.ended,
                false => Some(likelihood.text),
            };
            text.map(|text| text + likelihood.forced)
        });
        let counted = &mut self.answers[at].sum;
        *counted = counted.saturating_add(whole.flatten().unwrap_or(i64::from(i32::MIN)));
        self.replies += 1;
    }

    /// Returns the answers with their likelihoods, and if the likeliest one is a guess.
    pub(crate) fn reading(&self) -> Reading {
        let mut sorted: Vec<&Answer> = self.answers.iter().collect();
        sorted.sort_by_key(|answer| std::cmp::Reverse(answer.sum));
        let best = sorted[0];
        let is_ahead = sorted.get(1).is_none_or(|next| best.sum - next.sum >= MARGIN);
        let candidate = |(index, answer): (usize, &&Answer)| {
            let mut candidate = Candidate::new(answer.text.clone(), Some(answer.sum));
            candidate.chosen = index == 0;
            candidate
        };
        Reading {
            of: ReadingOf::Weighing,
            words: self.wordings.join("\" and \""),
            candidates: sorted.iter().enumerate().map(candidate).collect(),
            least: Some(nats(LEAST)),
            doubt: match best {
                best if best.sum < LEAST => Some(Doubt::Unlikely),
                _ if !is_ahead => Some(Doubt::Close),
                best if !best.counts && best.sum < LEAST_RETOLD => Some(Doubt::OnlyRetold),
                _ => None,
            },
        }
    }
}

/// Returns the likeliest answers of a reading that are goals, and what the chosen one begins with: a model that has to write
/// some goal after a joint may have added one that nobody asked for.
fn answers_of(world: &World, reading: &Reading) -> Vec<String> {
    let mut candidates: Vec<&Candidate> = reading.candidates.iter().collect();
    candidates.sort_by(|one, other| {
        let key = |own: &Candidate| (own.chosen, own.likelihood.unwrap_or(f64::NEG_INFINITY));
        let ((one_chosen, one), (other_chosen, other)) = (key(one), key(other));
        other_chosen.cmp(&one_chosen).then(other.total_cmp(&one))
    });
    let mut texts = Vec::new();
    for candidate in candidates.into_iter().take(OF_READING) {
        let Ok(goal) = goal::parse(world, &candidate.text) else {
            continue;
        };
        texts.push(candidate.text.clone());
        if candidate.chosen && goal.constraints.is_empty() && !goal.depends() {
            let begun = (1..goal.facts.len()).map(|end| Goal::from(goal.facts[..end].to_vec()));
            texts.extend(begun.map(|goal| goal.everyday(world).join(" & ")));
        }
    }
    texts
}
