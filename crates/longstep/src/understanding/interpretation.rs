//! The meaning of an instruction.

use crate::coverage::LeftOut;
use crate::dialogue::Reading;
use crate::environment::World;
use crate::goal::Goal;
use crate::model::Domain;

/// The meaning of an instruction in a world.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Interpretation {
    /// The goal. Where there is a question, it is what the model takes to be meant; none if it has no idea.
    pub goal: Option<Goal>,
    /// The words of the instruction that the goal does not say.
    pub left_out: Vec<LeftOut>,
    /// The question to the person; none if the goal is to be acted on.
    pub question: Option<String>,
    /// How the words were understood: the answers, their likelihoods, and the row of the table that decided.
    pub reading: Reading,
}

impl Interpretation {
    /// Returns the interpretation for another world with these entities (see [`Goal::carried`]); none if the other world lacks
    /// one of them.
    pub fn carried(self, domain: &Domain, from: &World, to: &World) -> Option<Self> {
        let goal = match &self.goal {
            Some(goal) => Some(goal.carried(domain, from, to)?),
            None => None,
        };
        Some(Self { goal, ..self })
    }
}
