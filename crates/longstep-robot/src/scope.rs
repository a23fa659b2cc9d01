//! The extent of an observation.

/// The entities that an observation is to cover.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Scope {
    /// Every entity that the robot can see.
    All,
    /// These entities. An observation may cover more.
    Entities(Vec<String>),
}
