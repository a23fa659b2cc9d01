//! Understanding: from an instruction in a world to a goal, with one request to a model.
//!
//! [`request`] builds the messages, [`answer`] the form of the answer and its reading. Every model gets the same messages and
//! writes the same language: goals, stages, groups, conditions, constraints, and the words that none of these says.

mod answer;
mod left_out;
mod profile;
mod request;
mod sayable;

pub use left_out::{LeftOut, LeftOutKind};
pub use answer::{Answer, read};
pub use profile::{Decision, Profile};
pub use request::{UnderstandingDialogue, UnderstandingInput};
