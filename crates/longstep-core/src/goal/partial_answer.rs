//! An answer that a model is in the middle of.

use super::conditional::{AND, ELSE, IF, THEN};
use super::{Goal, GoalError, GoalFact, JOINT, Written, parse};
use crate::model::{Domain, World};

/// How an answer can go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// It has come to its end.
    Nothing,
    /// Another goal.
    Goal,
    /// A goal for the case that the condition holds.
    Then,
    /// A goal for the other case.
    Otherwise,
}

/// What an answer has said so far.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Begun {
    /// The goals that are complete.
    pub facts: Vec<GoalFact>,
    /// Of the goal that is not: what is said on the side that goes on.
    pub side: Vec<GoalFact>,
    /// What is said on the other side, if that comes second.
    pub other_side: Vec<GoalFact>,
    /// How the answer can go on.
    pub next: Next,
}

impl Begun {
    /// Reads goals that may end in the middle: after "&", "then", "and" or "else".
    ///
    /// # Errors
    ///
    /// The first part that cannot be read.
    pub fn read(domain: &Domain, world: &World, answer: &str) -> Result<Self, GoalError> {
        let answer = answer.trim();
        let all = |text: &str| -> Result<Vec<GoalFact>, GoalError> {
            match text.trim() {
                "" => Ok(Vec::new()),
                text => Ok(parse(domain, world, text)?.facts),
            }
        };
        if let Some(said) = answer.strip_suffix(JOINT.trim()) {
            return Ok(Self {
                facts: all(said)?,
                side: Vec::new(),
                other_side: Vec::new(),
                next: Next::Goal,
            });
        }
        let cut = [THEN, AND, ELSE]
            .iter()
            .find_map(|word| Some((*word, answer.strip_suffix(word)?)));
        let (before, last) = answer.rsplit_once('&').unwrap_or(("", answer));
        let Some((word, _)) = cut.filter(|_| last.trim_start().starts_with(IF)) else {
            return Ok(Self {
                facts: all(answer)?,
                side: Vec::new(),
                other_side: Vec::new(),
                next: if answer.is_empty() { Next::Goal } else { Next::Nothing },
            });
        };
        let open = last.trim().strip_suffix(word).unwrap_or_default();
        let written = Written::read(open);
        let in_otherwise = word == ELSE || written.as_ref().is_some_and(|written| !written.otherwise.is_empty());
        let read = |parts: &[&str]| -> Result<Vec<GoalFact>, GoalError> {
            let facts: Result<Vec<Vec<GoalFact>>, GoalError> = parts.iter().map(|part| all(part)).collect();
            Ok(facts?.concat())
        };
        // Before the first goal of a side, the text does not read as a whole.
        let (then, otherwise) = match &written {
            Some(written) => (read(&written.then)?, read(&written.otherwise)?),
            None => (Vec::new(), Vec::new()),
        };
        let (side, other_side) = if in_otherwise {
            (otherwise, then)
        } else {
            (then, Vec::new())
        };
        Ok(Self {
            facts: all(before)?,
            side,
            other_side,
            next: if in_otherwise { Next::Otherwise } else { Next::Then },
        })
    }

    /// What must be thought of when the next goal is said: the goals that will be pursued together with it.
    pub fn said(&self) -> Vec<GoalFact> {
        let parts = self.facts.iter().flat_map(GoalFact::parts);
        parts.chain(&self.side).cloned().collect()
    }

    /// Whether any of the goals depends on something.
    pub fn has_condition(&self) -> bool {
        let depends = |fact: &GoalFact| matches!(fact, GoalFact::If(_));
        matches!(self.next, Next::Then | Next::Otherwise) || self.facts.iter().any(depends)
    }
}

/// The goals of an answer that ends, perhaps with a word after which nothing is left to say.
pub fn ended(domain: &Domain, world: &World, answer: &str) -> Result<Goal, GoalError> {
    let mut text = answer.trim();
    while let Some(less) = [JOINT.trim(), AND, ELSE]
        .iter()
        .find_map(|word| text.strip_suffix(word))
    {
        text = less.trim_end();
    }
    // A condition after which nothing can be said wants nothing.
    if text.ends_with(THEN) {
        text = text.rsplit_once('&').map_or("", |(before, _)| before);
    }
    match text.trim() {
        "" => Ok(Goal::default()),
        text => parse(domain, world, text),
    }
}
