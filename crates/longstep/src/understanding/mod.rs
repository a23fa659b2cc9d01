//! Understanding: from an instruction in a world to a goal, with one request to a model.
//!
//! Every model gets the same messages and writes the same language: goals, stages, groups, conditions, constraints, and the words that
//! none of these says. An [`Understanding`] builds the request and reads the reply; a [`Profile`] decides when to ask the person; the
//! result is an [`Interpretation`].

mod answer;
mod dialogue;
mod fitted;
mod interpretation;
mod profile;
mod question;
mod request;
mod sayable;
#[cfg(test)]
mod tests;

pub use dialogue::{Examples, Understanding, UnderstandingInput};
pub use fitted::FittedUnderstanding;
pub use interpretation::Interpretation;
pub use profile::Profile;
