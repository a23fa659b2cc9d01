//! One state of the world, as facts and as the paper's JSON: read, written, claimed, carried on.

mod carry;
mod claim;
mod narrow;
mod read;
#[cfg(test)]
mod tests;
mod write;

pub use crate::model::{
    Bindings, Difference, Entity, EntityId, Environment, Fact, FactSet, Ground, Moment, State, Voice, Words, World,
    differences, fact_text, holds, subject_of,
};
pub use claim::Claim;
pub use read::read;
pub use write::{fact_of, word_for, write};
