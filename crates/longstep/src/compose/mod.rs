//! Plans put together from stored ones: one after the other, in branches, or side by side.
//!
//! Stored plans are accepted plans with a name and a summary ([`Stored`]). A model, or a person, writes a composition
//! of them in the notation of any plan, with the plans' names as calls. [`request`] asks a model for one, [`read`] reads
//! it, and [`inline`] puts each plan's steps in place of its name. What comes out is one plan, and it is verified as one,
//! from the world as it is now ([`Composed`]): nothing is taken over from the verdicts on its parts.

mod asked;
mod composed;
mod examples;
mod grammar;
mod inline;
mod menu;
mod misfit;
mod read;
mod recalled;
mod request;
mod stored;
#[cfg(test)]
mod tests;

pub use composed::Composed;
pub use inline::{Inlined, inline};
pub use misfit::{Misfit, refused};
pub use read::{Said, read};
use recalled::Recalled;
pub use request::request;
pub use stored::{NameClash, Stored, check_names};
