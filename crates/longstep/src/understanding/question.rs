//! Questions to the person, in words about the world.

use crate::environment::World;
use crate::goal::Goal;
use crate::instruction::{self, Mentions};

/// A question about an instruction.
pub(super) struct Question {
    pub(super) text: String,
    /// The goal that a yes agrees to; none if only other words answer the question.
    pub(super) goal: Option<Goal>,
}

impl Question {
    /// Returns the question about an instruction whose best goal, if there is one, is not sure enough.
    pub(super) fn about(world: &World, mentions: &Mentions, goal: Option<Goal>) -> Self {
        let Some(goal) = goal.filter(|goal| !goal.is_empty()) else {
            return Self {
                text: "I do not know what you mean. What should I do?".to_owned(),
                goal: None,
            };
        };
        match which(world, mentions, &goal) {
            Some(text) => Self { text, goal: None },
            None => Self {
                text: goal.question(world),
                goal: Some(goal),
            },
        }
    }
}

/// Returns the question which of several things is meant that fit the words. It is asked once: the answer says which.
pub(super) fn which(world: &World, mentions: &Mentions, goal: &Goal) -> Option<String> {
    let which = || instruction::which(world, mentions, goal);
    (!mentions.is_answered()).then(which).flatten()
}
