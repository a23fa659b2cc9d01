//! The origin of every fact of a world: the environment, a derivation, a default, or an assumption.

use super::{AssumptionSource, EntityId, Fact, World};
use crate::model::matches_name;

/// The origin of a fact of the initial state.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Origin {
    /// The environment gives it.
    Environment,
    /// A derivation of the domain gives it.
    Derived {
        /// The line of the derivation in `domain.toml`.
        line: u32,
        /// The parts of the derivation that apply.
        reason: String,
    },
    /// A default of the domain gives it.
    Default {
        /// The line of the default in `domain.toml`.
        line: u32,
        /// The condition of the default.
        reason: String,
    },
    /// The environment gives neither the fact nor its negation, and the domain assumes it then.
    Unknown,
}

impl Origin {
    /// Returns the origin of a fact that holds in the initial state of the world.
    ///
    /// ```
    /// use longstep_model::{domain, environment::{self, Origin}};
    /// let household = domain::shipped("household").unwrap().unwrap();
    /// let world = environment::parse(&household, "env.json", r#"{"assets": ["<Trash_Bin>"]}"#).unwrap();
    /// let fact = world.state.iter().next().unwrap();
    /// let origin = Origin::of(&world, fact);
    /// assert!(origin.to_string().ends_with("`<Trash_Bin>` matches the name `bin`"), "{origin}");
    /// ```
    pub fn of(world: &World, fact: Fact) -> Self {
        match world.assumed(fact) {
            None => Self::Environment,
            Some(AssumptionSource::Unknown) => Self::Unknown,
            Some(AssumptionSource::Default) => {
                let defaults = world.domain().defaults.iter();
                let found = defaults
                    .clone()
                    .find(|default| default.atom.predicate == fact.predicate());
                Self::Default {
                    line: found.map_or(0, |default| default.line),
                    reason: found.map(|default| default.written.clone()).unwrap_or_default(),
                }
            }
            Some(AssumptionSource::Derived { derivation }) => Self::Derived {
                line: world.domain().derivations[derivation].line,
                reason: reason(world, derivation, fact),
            },
        }
    }
}

impl std::fmt::Display for Origin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Environment => write!(f, "given"),
            Self::Derived { line, reason } => write!(f, "derived, domain.toml:{line}: {reason}"),
            Self::Default { line, reason } => write!(f, "default, domain.toml:{line}: {reason}"),
            Self::Unknown => write!(f, "assumed, the environment does not say"),
        }
    }
}

/// Returns the parts of a derivation that apply to a fact.
fn reason(world: &World, derivation: usize, fact: Fact) -> String {
    let derivation = &world.domain().derivations[derivation];
    let mut parts = Vec::new();
    if let Some(pattern) = &derivation.pattern {
        parts.push(format!("named by the pattern `{pattern}`"));
    }
    for entity in world.domain().arguments(fact) {
        let identifier = &world.entity(entity).identifier;
        let mut names = derivation.names.iter().chain(&derivation.other_names);
        let part = names
            .find(|name| matches_name(identifier, name))
            .map(|name| format!("`{identifier}` matches the name `{name}`"));
        parts.extend(part.filter(|part| !parts.contains(part)));
    }
    parts.extend(derivation.written.clone());
    if parts.is_empty() {
        parts.push("for every entity".to_owned());
    }
    parts.join("; ")
}

impl World {
    /// Returns the facts of the initial state with this entity as first argument, in order.
    pub fn facts_about(&self, entity: EntityId) -> Vec<Fact> {
        let about = |fact: &Fact| self.domain().arguments(*fact).next() == Some(entity);
        let mut facts: Vec<Fact> = self.state.iter().filter(about).collect();
        facts.sort_unstable();
        facts
    }
}
