//! Environments from words and from pictures, by a model.
//!
//! A [`SightDialogue`] lets a model write down what a description or pictures show: names, and states in the words of the
//! domain. A [`View`] is the environment of that [`Sighting`], checked by the domain's own rules, with everything that was
//! assumed or left out. A [`CorrectionDialogue`] reads what a person says about a view; [`View::corrected`] applies it.
//! [`observation`] compares a look with the world of a session.

mod correction;
mod dialogue;
mod example;
mod sentence;
mod sighting;
#[cfg(test)]
mod tests;
mod update;
mod view;
mod vocabulary;

pub use correction::CorrectionDialogue;
pub use dialogue::{SightDialogue, SightInput};
pub use sighting::{Sighting, Statement};
pub use update::{LookSource, observation};
pub use view::{Leniency, View};
