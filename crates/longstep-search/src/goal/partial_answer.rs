//! Partial answers: goals that a model has not finished writing.

use super::conditional::{AND, ELSE, IF, THEN};
use super::{Goal, GoalError, GoalFact, JOINT, WrittenConditional, parse};
use longstep_model::model::World;

/// The possible continuation of a partial answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// The end of the answer.
    Nothing,
    /// Another goal.
    Goal,
    /// A goal of the branch in which the condition holds.
    Then,
    /// A goal of the other branch.
    Otherwise,
}

/// The contents of a partial answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Begun {
    /// The complete goals.
    pub facts: Vec<GoalFact>,
    /// Of the incomplete conditional goal: the goals of the branch that continues.
    pub side: Vec<GoalFact>,
    /// The goals of the first branch, if the second one continues.
    pub other_side: Vec<GoalFact>,
    /// The possible continuation.
    pub next: Next,
}

impl Begun {
    /// Parses goals that may end after "&", "then", "and" or "else".
    ///
    /// # Errors
    ///
    /// The error in the first unreadable part.
    pub fn read(world: &World, answer: &str) -> Result<Self, GoalError> {
        let answer = answer.trim();
        if let Some(finished) = answer.strip_suffix(JOINT.trim()) {
            return Ok(Self {
                facts: goals(world, finished)?,
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
                facts: goals(world, answer)?,
                side: Vec::new(),
                other_side: Vec::new(),
                next: if answer.is_empty() { Next::Goal } else { Next::Nothing },
            });
        };
        let open = last.trim().strip_suffix(word).unwrap_or_default();
        let written = WrittenConditional::read(open);
        let in_otherwise = word == ELSE || written.as_ref().is_some_and(|written| !written.otherwise.is_empty());
        // A branch without goals is not yet a complete conditional.
        let (then, otherwise) = match &written {
            Some(written) => (all_goals(world, &written.then)?, all_goals(world, &written.otherwise)?),
            None => (Vec::new(), Vec::new()),
        };
        let (side, other_side) = if in_otherwise {
            (otherwise, then)
        } else {
            (then, Vec::new())
        };
        Ok(Self {
            facts: goals(world, before)?,
            side,
            other_side,
            next: if in_otherwise { Next::Otherwise } else { Next::Then },
        })
    }

    /// Returns the goals so far that will be pursued together with the next one.
    pub fn preceding(&self) -> Vec<GoalFact> {
        let parts = self.facts.iter().flat_map(GoalFact::parts);
        parts.chain(&self.side).cloned().collect()
    }

    /// Returns true if a goal is conditional.
    pub fn has_condition(&self) -> bool {
        matches!(self.next, Next::Then | Next::Otherwise) || self.facts.iter().any(GoalFact::is_conditional)
    }
}

/// Parses goals; none in an empty text.
fn goals(world: &World, text: &str) -> Result<Vec<GoalFact>, GoalError> {
    match text.trim() {
        "" => Ok(Vec::new()),
        text => Ok(parse(world, text)?.facts),
    }
}

fn all_goals(world: &World, parts: &[&str]) -> Result<Vec<GoalFact>, GoalError> {
    let mut all = Vec::new();
    for part in parts {
        all.extend(goals(world, part)?);
    }
    Ok(all)
}

/// Parses an answer that has ended, possibly with a word that requires a continuation; that word is ignored.
///
/// # Errors
///
/// The error in the first unreadable part.
pub fn ended(world: &World, answer: &str) -> Result<Goal, GoalError> {
    let mut text = answer.trim();
    while let Some(less) = [JOINT.trim(), AND, ELSE]
        .iter()
        .find_map(|word| text.strip_suffix(word))
    {
        text = less.trim_end();
    }
    // A condition without a goal in its branch requires nothing.
    if text.ends_with(THEN) {
        text = text.rsplit_once('&').map_or("", |(before, _)| before);
    }
    match text.trim() {
        "" => Ok(Goal::default()),
        text => parse(world, text),
    }
}
