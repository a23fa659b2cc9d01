//! Environments: states of the world in the paper's JSON, converted to and from facts.

mod claim;
mod implied;
mod observation;
mod origin;
mod read;
mod statement;
mod subworld;
mod successor;
#[cfg(test)]
mod tests;
mod write;

pub use crate::model::{
    AssumptionSource, Bindings, Difference, Distinctions, Entity, EntityId, Environment, EnvironmentError, Fact,
    FactSet, Fluent, Moment, Number, Prohibition, State, StepPattern, Voice, Words, World, differences, fact_text,
    fluent_text, holds, subject_of,
};
pub use claim::Claim;
pub use observation::{Observation, ObservationError, ObservedFacts};
pub use origin::Origin;
pub use read::{parse, read};
pub use write::{fact_of, write};
