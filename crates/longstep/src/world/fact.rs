//! Facts and states.

use rustc_hash::FxHashSet;

use crate::domain::{PredicateId, id};

id!(
    /// Something in the world: an asset, an object, or a constant of the domain.
    EntityId
);

/// A predicate applied to entities, packed into one number: copied, compared and hashed at once.
///
/// Facts sort by predicate, then by arguments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Fact(u128);

impl Fact {
    /// The fact that `predicate` holds of `arguments`, of which there are at most seven.
    ///
    /// ```
    /// use longstep::{domain::PredicateId, world::{EntityId, Fact}};
    /// let on = Fact::new(PredicateId::new(3), [EntityId::new(5), EntityId::new(8)]);
    /// assert_eq!((on.predicate().index(), on.argument(1).index()), (3, 8));
    /// ```
    pub fn new(predicate: PredicateId, arguments: impl IntoIterator<Item = EntityId>) -> Self {
        let mut packed = (predicate.index() as u128) << 112;
        for (place, argument) in arguments.into_iter().enumerate() {
            debug_assert!(place < 7);
            packed |= (argument.index() as u128) << (96 - 16 * place);
        }
        Self(packed)
    }

    /// The predicate.
    pub fn predicate(self) -> PredicateId {
        PredicateId::new((self.0 >> 112) as usize)
    }

    /// The argument at `place`, from 0; the domain knows how many there are.
    pub fn argument(self, place: usize) -> EntityId {
        EntityId::new((self.0 >> (96 - 16 * place)) as usize & 0xffff)
    }
}

/// What is true, all else being false.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct State {
    facts: FxHashSet<Fact>,
}

impl State {
    /// Whether the fact holds.
    pub fn holds(&self, fact: Fact) -> bool {
        self.facts.contains(&fact)
    }

    /// Makes the fact hold, or not; tells whether that changed anything.
    pub fn set(&mut self, fact: Fact, holds: bool) -> bool {
        if holds {
            self.facts.insert(fact)
        } else {
            self.facts.remove(&fact)
        }
    }

    /// What holds, sorted.
    pub fn sorted(&self) -> Vec<Fact> {
        let mut facts: Vec<Fact> = self.facts.iter().copied().collect();
        facts.sort_unstable();
        facts
    }

    /// What holds of one predicate, sorted.
    pub fn of_predicate(&self, predicate: PredicateId) -> Vec<Fact> {
        let mut facts: Vec<Fact> = self
            .facts
            .iter()
            .copied()
            .filter(|f| f.predicate() == predicate)
            .collect();
        facts.sort_unstable();
        facts
    }

    /// How many facts hold.
    pub fn len(&self) -> usize {
        self.facts.len()
    }

    /// Whether nothing holds.
    pub fn is_empty(&self) -> bool {
        self.facts.is_empty()
    }
}

/// Facts in no order that anybody may see.
pub type FactSet = FxHashSet<Fact>;
