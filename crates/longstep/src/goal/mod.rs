//! Goals from instructions.
//!
//! A [`Goal`] is written as `put(cup, shelf) & closed(door)`. A model writes one under a grammar that admits only
//! sensible goals ([`offers`]). [`understand`] then compares the answer with the entities that the
//! instruction names, and search turns the goal into steps.

mod ambiguous;
#[cfg(test)]
mod conditional_tests;
mod correction;
mod dependence;
mod mentions;
mod offer;
mod pronoun;
mod reference_words;
#[cfg(test)]
mod tests;
mod understanding;

pub use longstep_core::goal::*;

pub(crate) use correction::Correction;
pub(crate) use dependence::{Dependence, conditions};
pub use mentions::Mentions;
pub use offer::{Offer, offers};
pub(crate) use offer::{is_settled, offers_on, possible_goals, settled_offers};
pub use pronoun::{SpelledOut, spelled_out};
pub use understanding::{Understanding, understand};
pub(crate) use understanding::{guess, understand_mentions};
