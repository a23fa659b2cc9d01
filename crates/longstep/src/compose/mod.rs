//! Plans composed of stored plans: in sequence, in branches, or in parallel lanes.
//!
//! A [`Stored`] plan is an accepted plan with a name and a summary. A model or a person writes a composition as a plan
//! that calls stored plans by name. A [`CompositionDialogue`] asks a model for one, [`read`] parses it, and
//! [`inline`] replaces each name by the steps of its plan. The result is one plan. [`Composed`] verifies it as a whole,
//! from the current world, and reuses no verdict on its parts.

mod composed;
mod dialogue;
mod examples;
mod grammar;
mod inline;
mod menu;
mod misfit;
mod read;
mod recalled;
mod sensing;
mod stored;
#[cfg(test)]
mod tests;

pub use composed::Composed;
pub use dialogue::{CompositionDialogue, CompositionInput};
pub use inline::{Inlined, inline};
pub use misfit::{Misfit, refused};
pub use read::{CompositionAnswer, read};
use recalled::Recalled;
pub use stored::{NameClash, Stored, check_names};
