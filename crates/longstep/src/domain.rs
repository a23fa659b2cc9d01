//! Robot domains with their prompts: shipped ones, and ones loaded from a folder.
//!
//! A domain is a folder: `domain.pddl` holds the semantics, `domain.toml` the vocabulary, `prompt/` the texts for a
//! model. [`load`] reads all three and reports every contradiction between them. [`from_pddl`] needs the PDDL only.

pub use crate::load::{from_pddl, load, shipped};
pub use crate::model::*;
