//! What is asked, and what is meant by it.
//!
//! A suite is a folder of data: `suite.toml` says what it is and which domain it is for, `scenes/NAME.json` are
//! environments, and every other `.toml` file holds cases. [`load`] reads all of it or refuses all of it, with every
//! fault at its place.

mod load;
pub mod paper;
mod shipped;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use longstep::environment::World;
use longstep::goal::Goal;

pub use load::{Files, domain_name, load};
pub use shipped::{shipped, shipped_names};

/// Instructions with what is meant by them, for one domain.
#[derive(Debug, Clone)]
pub struct Suite {
    /// What it is called.
    pub name: String,
    /// What it asks for, in a sentence.
    pub about: String,
    /// The domain's name, or its folder.
    pub domain: String,
    /// The worlds that its cases begin in.
    pub scenes: BTreeMap<String, World>,
    /// In the order of the files and of what is in them.
    pub cases: Vec<Case>,
}

/// One instruction, or a chain of them in which each begins in the world that the one before left.
#[derive(Debug, Clone)]
pub struct Case {
    /// Unlike that of every other case.
    pub id: String,
    /// The world that it begins in.
    pub scene: String,
    /// At least one.
    pub steps: Vec<Step>,
    /// For choosing and for grouping.
    pub tags: Vec<String>,
}

/// An instruction and what is meant by it.
#[derive(Debug, Clone)]
pub struct Step {
    /// The instruction.
    pub says: String,
    /// The same in other words, by what kind of words they are.
    pub wordings: BTreeMap<String, String>,
    /// What must come of it.
    pub expected: Expected,
}

/// What must come of an instruction.
#[derive(Debug, Clone, PartialEq)]
pub enum Expected {
    /// A plan to one of these goals, at least one.
    Plan(Vec<Goal>),
    /// A question back.
    Question,
    /// The proof that there is no plan.
    Refusal,
    /// A question back, or word that there is no plan, proven or not.
    Either,
}

impl Expected {
    /// The goals; empty where no plan is expected.
    pub fn goals(&self) -> &[Goal] {
        match self {
            Self::Plan(goals) => goals,
            Self::Question | Self::Refusal | Self::Either => &[],
        }
    }
}

/// The words of a case as its suite has them, when no other wording is asked for.
pub const PLAIN: &str = "plain";

impl Case {
    /// The wordings that all its steps have, [`PLAIN`] first.
    pub fn wordings(&self) -> Vec<&str> {
        let mut wordings = vec![PLAIN];
        if let [step] = &self.steps[..] {
            wordings.extend(step.wordings.keys().map(String::as_str));
        }
        wordings
    }
}

impl Step {
    /// The instruction in a wording, if it has it.
    pub fn in_words(&self, wording: &str) -> Option<&str> {
        match wording {
            PLAIN => Some(&self.says),
            other => self.wordings.get(other).map(String::as_str),
        }
    }
}
