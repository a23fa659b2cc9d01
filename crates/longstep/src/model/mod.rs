//! A domain together with its prompts, as data.

mod prompts;

use std::ops::Deref;

pub use longstep_core::domain::*;

pub(crate) use prompts::Source;
pub use prompts::{Example, FeedbackExample, PartTexts, Prompts};

/// A verifier [domain](longstep_core::model::Domain) with its prompts. It dereferences to the verifier domain.
#[derive(Debug, Clone)]
pub struct Domain {
    pub(crate) domain: longstep_core::model::Domain,
    /// The texts of its `prompt/` folder.
    pub prompts: Prompts,
    /// The name or the folder with which the domain is loaded again, for the logs of sessions.
    pub origin: String,
}

/// The domain with the default prompts of this library; its name is its origin.
impl From<longstep_core::model::Domain> for Domain {
    fn from(domain: longstep_core::model::Domain) -> Self {
        Self {
            origin: domain.name.clone(),
            domain,
            prompts: Prompts::default(),
        }
    }
}

impl Deref for Domain {
    type Target = longstep_core::model::Domain;

    fn deref(&self) -> &Self::Target {
        &self.domain
    }
}
