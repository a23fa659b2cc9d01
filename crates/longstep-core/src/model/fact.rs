//! Facts and states.

use std::hash::{Hash, Hasher};
use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::{PredicateId, id};
use crate::effort;

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
    /// use longstep_core::{domain::PredicateId, environment::{EntityId, Fact}};
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
///
/// The facts of each predicate stand in a sorted list of their own, shared until one of its copies changes: a copy of
/// a state costs next to nothing, what holds of a predicate is at hand without looking at the rest, and everything
/// comes out in order.
#[derive(Debug, Clone, Default)]
pub struct State {
    by_predicate: Vec<Arc<Vec<Fact>>>,
}

impl State {
    /// Whether the fact holds.
    pub fn holds(&self, fact: Fact) -> bool {
        self.of_predicate(fact.predicate()).binary_search(&fact).is_ok()
    }

    /// Makes the fact hold, or not; tells whether that changed anything.
    pub fn set(&mut self, fact: Fact, holds: bool) -> bool {
        let index = fact.predicate().index();
        if self.by_predicate.len() <= index {
            self.by_predicate.resize_with(index + 1, Arc::default);
        }
        let facts = &mut self.by_predicate[index];
        match (facts.binary_search(&fact), holds) {
            (Err(place), true) => Arc::make_mut(facts).insert(place, fact),
            (Ok(place), false) => {
                Arc::make_mut(facts).remove(place);
            }
            _ => return false,
        }
        // A list that is shared is copied.
        effort::spend(1 + facts.len() / 8);
        true
    }

    /// Everything that holds, in order.
    pub fn iter(&self) -> impl Iterator<Item = Fact> + '_ {
        self.by_predicate.iter().flat_map(|facts| facts.iter().copied())
    }

    /// What holds of one predicate, in order.
    pub fn of_predicate(&self, predicate: PredicateId) -> &[Fact] {
        self.by_predicate
            .get(predicate.index())
            .map_or(&[], |facts| facts.as_slice())
    }

    /// What holds of one predicate and this first argument, in order.
    pub fn of_first(&self, predicate: PredicateId, first: EntityId) -> &[Fact] {
        let facts = self.of_predicate(predicate);
        let from = facts.partition_point(|fact| fact.argument(0) < first);
        let length = facts[from..].partition_point(|fact| fact.argument(0) == first);
        &facts[from..from + length]
    }

    /// What of it is not as in another state, list by list: two states that come from that one are the same if these
    /// are. Lists that both share need no look, so this costs as much as has changed.
    pub(crate) fn changed_lists(&self, from: &State) -> ChangedLists {
        let empty = Arc::default();
        let changed = |(index, facts): (usize, &Arc<Vec<Fact>>)| {
            let other = from.by_predicate.get(index).unwrap_or(&empty);
            (!Arc::ptr_eq(facts, other) && facts != other).then(|| (index, facts.clone()))
        };
        self.by_predicate.iter().enumerate().filter_map(changed).collect()
    }

    /// How many facts hold.
    pub fn len(&self) -> usize {
        self.by_predicate.iter().map(|facts| facts.len()).sum()
    }

    /// Whether nothing holds.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl PartialEq for State {
    fn eq(&self, other: &Self) -> bool {
        // A predicate of which nothing ever held may have no list at all.
        self.iter().eq(other.iter())
    }
}

impl Eq for State {}

impl Hash for State {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        self.iter().for_each(|fact| fact.hash(hasher));
    }
}

/// The lists of a state that are not as in another one, by predicate.
pub(crate) type ChangedLists = Vec<(usize, Arc<Vec<Fact>>)>;

/// Facts in no order that anybody may see.
pub type FactSet = FxHashSet<Fact>;
