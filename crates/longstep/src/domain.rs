//! A robot's domain with its prompts, from a folder or from the domains that are shipped.
//!
//! A domain is a folder: `domain.pddl` holds the semantics, `domain.toml` the words, `prompt/` what a model is told.
//! [`load`] reads the three together and reports everything on which they disagree. [`from_pddl`] makes do with the PDDL
//! alone.

pub use crate::lint::{Finding, Lint, lint};
pub use crate::load::{from_pddl, load, shipped};
pub use crate::model::*;
