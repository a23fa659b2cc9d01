//! Goals from instructions.
//!
//! A [`Goal`] is written as `put(cup, shelf) & closed(door)`. A model writes one ([`understanding`](crate::understanding)), and search
//! turns it into steps.

mod ambiguous;
#[cfg(test)]
mod conditional_tests;
mod dependence;
mod mentions;
mod offer;
mod pronoun;
mod reference_words;
#[cfg(test)]
mod tests;

pub use longstep_core::goal::*;

pub(crate) use dependence::{Dependence, conditions};
pub use mentions::Mentions;
pub(crate) use offer::sayable;
pub use offer::{Offer, offers};

pub(crate) use ambiguous::which;
pub use pronoun::{SpelledOut, spelled_out};
