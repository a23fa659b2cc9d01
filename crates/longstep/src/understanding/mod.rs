//! Understanding: from an instruction in a world to a goal, with one request to a model.
//!
//! [`request`] builds the messages, [`answer`] the form of the answer and its reading. Every model gets the same messages and
//! writes the same language: goals, stages, groups, conditions, constraints, and the words that none of these says.

mod answer;
mod request;
mod sayable;

pub use answer::{Answer, read};
pub use request::{UnderstandingDialogue, UnderstandingInput};
