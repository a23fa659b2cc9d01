//! Relations between bodies in space, which a domain maps to its state words.

/// A relation that follows from the poses of bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SpatialRelation {
    /// A body rests on another one, or is attached to its side.
    On,
    /// A body is contained in another one.
    Inside,
    /// Two bodies of one place stand close together.
    NextTo,
    /// A closed hand is at a body.
    Held,
    /// The joint of a body is away from its closed position.
    Open,
    /// The joint of a body is in its closed position.
    Closed,
}

impl SpatialRelation {
    /// All relations.
    pub const ALL: [Self; 6] = [
        Self::On,
        Self::Inside,
        Self::NextTo,
        Self::Held,
        Self::Open,
        Self::Closed,
    ];

    /// The relation in `domain.toml`.
    pub fn name(self) -> &'static str {
        match self {
            Self::On => "on",
            Self::Inside => "inside",
            Self::NextTo => "next-to",
            Self::Held => "held",
            Self::Open => "open",
            Self::Closed => "closed",
        }
    }

    /// The numbers of arguments that a state word of the relation may have, beside the entity of the entry. A word of
    /// `held` may name the hand.
    pub fn arguments(self) -> std::ops::RangeInclusive<usize> {
        match self {
            Self::On | Self::Inside | Self::NextTo => 1..=1,
            Self::Held => 0..=1,
            Self::Open | Self::Closed => 0..=0,
        }
    }
}
