//! Facts and states.

use std::hash::{Hash, Hasher};
use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::{Fluent, Number, PredicateId, id};
use crate::effort;

id!(
    /// An entity of a world: an asset, an object, or a constant of the domain.
    EntityId
);

/// A predicate applied to entities, packed into one 128-bit number.
///
/// Facts are ordered by predicate, then by arguments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Fact(u128);

impl Fact {
    /// Creates the fact that applies `predicate` to `arguments`, at most seven.
    ///
    /// ```
    /// use longstep_model::{domain::PredicateId, environment::{EntityId, Fact}};
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

    /// The argument at `place`, from 0; the arity is in the domain's predicate.
    pub fn argument(self, place: usize) -> EntityId {
        EntityId::new((self.0 >> (96 - 16 * place)) as usize & 0xffff)
    }
}

/// A state: the set of facts that hold, and the numbers of fluents. All other facts are false, and all other fluents
/// have no number.
///
/// The facts of each predicate are in one sorted list, which copies of the state share until one of them changes it. So
/// copying a state is cheap, the facts of one predicate are found without a scan, and iteration is in order.
#[derive(Debug, Clone, Default)]
pub struct State {
    by_predicate: Vec<Arc<Vec<Fact>>>,
    /// Sorted by fluent.
    numbers: Arc<Vec<(Fluent, Number)>>,
}

impl State {
    /// Returns true if the fact holds.
    pub fn holds(&self, fact: Fact) -> bool {
        self.of_predicate(fact.predicate()).binary_search(&fact).is_ok()
    }

    /// Makes the fact true or false; returns true if that changed the state.
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
        // A shared list is copied.
        effort::spend(1 + facts.len() / 8);
        true
    }

    /// Returns the number of a fluent; none if it has none.
    pub fn number(&self, fluent: Fluent) -> Option<Number> {
        let place = self.numbers.binary_search_by_key(&fluent, |(own, _)| *own).ok()?;
        Some(self.numbers[place].1)
    }

    /// Gives a fluent a number; returns true if that changed the state.
    pub fn set_number(&mut self, fluent: Fluent, number: Number) -> bool {
        match self.numbers.binary_search_by_key(&fluent, |(own, _)| *own) {
            Ok(place) if self.numbers[place].1 == number => return false,
            Ok(place) => Arc::make_mut(&mut self.numbers)[place].1 = number,
            Err(place) => Arc::make_mut(&mut self.numbers).insert(place, (fluent, number)),
        }
        // A shared list is copied.
        effort::spend(1 + self.numbers.len() / 8);
        true
    }

    /// Returns the fluents that have a number, in order.
    pub fn numbers(&self) -> &[(Fluent, Number)] {
        &self.numbers
    }

    /// Drops the facts of all predicates from this number on.
    pub fn truncate(&mut self, predicates: usize) {
        self.by_predicate.truncate(predicates);
    }

    /// Iterates over the facts of all predicates from this number on.
    pub fn iter_from(&self, predicates: usize) -> impl Iterator<Item = Fact> + '_ {
        let lists = self.by_predicate.iter().skip(predicates);
        lists.flat_map(|facts| facts.iter().copied())
    }

    /// Iterates over all facts that hold, in order.
    pub fn iter(&self) -> impl Iterator<Item = Fact> + '_ {
        self.by_predicate.iter().flat_map(|facts| facts.iter().copied())
    }

    /// Returns the facts of a predicate that hold, in order.
    pub fn of_predicate(&self, predicate: PredicateId) -> &[Fact] {
        self.by_predicate
            .get(predicate.index())
            .map_or(&[], |facts| facts.as_slice())
    }

    /// Returns the facts of a predicate with this first argument that hold, in order.
    pub fn of_first(&self, predicate: PredicateId, first: EntityId) -> &[Fact] {
        let facts = self.of_predicate(predicate);
        let from = facts.partition_point(|fact| fact.argument(0) < first);
        let length = facts[from..].partition_point(|fact| fact.argument(0) == first);
        &facts[from..from + length]
    }

    /// Returns the lists of this state that differ from those of `from`. Two states derived from the same `from` are
    /// equal if these lists are equal. Shared lists are not compared, so the cost grows with the number of changes.
    pub fn changed_lists(&self, from: &State) -> ChangedLists {
        let empty = Arc::default();
        let changed = |(index, facts): (usize, &Arc<Vec<Fact>>)| {
            let other = from.by_predicate.get(index).unwrap_or(&empty);
            (!Arc::ptr_eq(facts, other) && facts != other).then(|| (index, facts.clone()))
        };
        ChangedLists {
            facts: self.by_predicate.iter().enumerate().filter_map(changed).collect(),
            numbers: (!Arc::ptr_eq(&self.numbers, &from.numbers) && self.numbers != from.numbers)
                .then(|| self.numbers.clone()),
        }
    }

    /// Returns the number of facts that hold.
    pub fn len(&self) -> usize {
        self.by_predicate.iter().map(|facts| facts.len()).sum()
    }

    /// Returns true if no fact holds.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl PartialEq for State {
    fn eq(&self, other: &Self) -> bool {
        // A predicate without facts may have no list.
        self.iter().eq(other.iter()) && self.numbers == other.numbers
    }
}

impl Eq for State {}

impl Hash for State {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        self.iter().for_each(|fact| fact.hash(hasher));
        self.numbers.hash(hasher);
    }
}

/// The lists of a state that differ from those of another state.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChangedLists {
    /// The lists of facts, with the index of their predicate.
    facts: Vec<(usize, Arc<Vec<Fact>>)>,
    /// All numbers, if one of them differs.
    numbers: Option<Arc<Vec<(Fluent, Number)>>>,
}

impl ChangedLists {
    /// Returns the work units for storing the lists.
    pub fn units(&self) -> usize {
        let facts: usize = self.facts.iter().map(|(_, facts)| 2 * facts.len() + 1).sum();
        facts + self.numbers.as_ref().map_or(0, |numbers| 2 * numbers.len() + 1)
    }
}

/// A set of facts; its order must not reach any output.
pub type FactSet = FxHashSet<Fact>;
