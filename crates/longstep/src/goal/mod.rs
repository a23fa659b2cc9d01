//! Goals from instructions.
//!
//! A [`Goal`] is written as `put(cup, shelf) & closed(door)`. A model writes one under a grammar that admits only
//! sensible goals ([`offers`]). [`understand`] then compares the answer with the entities that the
//! instruction mentions, and search turns the goal into steps.

mod ambiguous;
#[cfg(test)]
mod conditional_tests;
mod correction;
mod depends;
mod mention;
mod negated;
mod offer;
mod pronoun;
mod request;
#[cfg(test)]
mod tests;

pub use longstep_core::goal::*;

pub(crate) use correction::{Correction, parts};
pub(crate) use depends::{Dependence, cannot_be_told, conditions, governs_all, has_other_case};
pub use mention::{LeftOut, Spoken, Understanding, understand, unknown_thing};
pub(crate) use mention::{guess, understand_spoken};
pub use offer::{Offer, offers};
pub(crate) use offer::{already, is_plain, offers_on};
pub use pronoun::{SpelledOut, spelled_out};
pub(crate) use request::Request;
