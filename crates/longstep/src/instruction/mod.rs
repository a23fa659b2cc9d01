//! The words of an instruction in a world: the entities that it names, its pronouns, ambiguous references, and the goals and
//! conditions that it may ask for.

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

pub(crate) use dependence::{Dependence, conditions};
pub use mentions::Mentions;
pub(crate) use offer::sayable;
pub use offer::{Offer, offers};

pub(crate) use ambiguous::which;
pub use pronoun::{SpelledOut, spelled_out};
