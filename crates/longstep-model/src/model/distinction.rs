//! Descriptions of entities that share a name, by the facts in which they differ.

use rustc_hash::FxHashMap;

use super::{EntityId, Fact, Voice, World};
use crate::effort;

/// Maximum number of facts in a description.
const FACTS: usize = 3;

/// Maximum number of facts of one entity that are combined.
const CANDIDATES: usize = 24;

/// A fact, or the lack of one, that describes an entity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Trait {
    fact: Fact,
    holds: bool,
}

/// Maximum number of entities that are described.
const DESCRIBED: usize = 8;

/// The facts of a world's initial state by entity, to tell entities apart.
#[derive(Debug)]
pub struct Distinctions<'w> {
    world: &'w World,
    /// The facts with the entity as first argument, those that actions change first: a place says more than a property
    /// that follows from a name.
    facts: FxHashMap<EntityId, Vec<Fact>>,
}

impl<'w> Distinctions<'w> {
    /// Collects the facts.
    pub fn of(world: &'w World) -> Self {
        let domain = world.domain();
        let mut facts: FxHashMap<EntityId, Vec<Fact>> = FxHashMap::default();
        for fact in world.state.iter() {
            if let Some(entity) = domain.arguments(fact).next() {
                facts.entry(entity).or_default().push(fact);
            }
        }
        for own in facts.values_mut() {
            let is_static = |fact: &Fact| !domain.words(fact.predicate()).fluent;
            own.sort_by_key(|fact| (world.assumed(*fact).is_some(), is_static(fact), *fact));
        }
        Self { world, facts }
    }

    /// Describes the entities by the fewest facts that hold of no other one of them, in the domain's words: "pallet 2
    /// (red)", "pallet 3 (blue, at bay 2)". An entity that no fact distinguishes has its name alone. Of more than eight
    /// entities, the first eight are described.
    ///
    /// The facts of a description are the first combination of the smallest size in the order of the domain's predicates,
    /// so it depends on the world alone.
    ///
    /// ```
    /// use longstep_model::{domain, environment::{self, Distinctions}};
    /// let household = domain::shipped("household").unwrap().unwrap();
    /// let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<cup_1>", "<cup_2>"],
    ///     "object_states": {"<cup_1>": "on_something(<table>)", "<cup_2>": "on_something(<shelf>)"}}"#;
    /// let world = environment::parse(&household, "env.json", text).unwrap();
    /// let described = Distinctions::of(&world).describe(&world.named("cup"));
    /// assert_eq!(described, ["cup 1 (on the table)", "cup 2 (on the shelf)"]);
    /// ```
    pub fn describe(&self, entities: &[EntityId]) -> Vec<String> {
        let described = |entity: &EntityId| {
            let name = self.world.entity(*entity).name.clone();
            let traits = self.distinguishing(*entity, entities);
            let words: Vec<String> = traits.iter().map(|own| own.words(self.world)).collect();
            if words.is_empty() {
                name
            } else {
                format!("{name} ({})", words.join(", "))
            }
        };
        entities.iter().take(DESCRIBED).map(described).collect()
    }

    /// Returns true if a fact holds of one of two entities and not of the other.
    pub fn differ(&self, one: EntityId, other: EntityId) -> bool {
        let own = self.facts_of(one).iter();
        let mut moved: Vec<Fact> = own.map(|fact| self.instead(*fact, one, other)).collect();
        let mut kept = self.facts_of(other).to_vec();
        moved.sort_unstable();
        kept.sort_unstable();
        moved != kept
    }

    fn facts_of(&self, entity: EntityId) -> &[Fact] {
        self.facts.get(&entity).map_or(&[], Vec::as_slice)
    }

    /// Returns the fact with `other` in place of `entity`.
    fn instead(&self, fact: Fact, entity: EntityId, other: EntityId) -> Fact {
        let arguments = self.world.domain().arguments(fact);
        let moved = arguments.map(|argument| if argument == entity { other } else { argument });
        Fact::new(fact.predicate(), moved)
    }

    fn distinguishing(&self, entity: EntityId, entities: &[EntityId]) -> Vec<Trait> {
        let state = &self.world.state;
        let others: Vec<EntityId> = entities.iter().copied().filter(|other| *other != entity).collect();
        let own = self.facts_of(entity).iter().map(|fact| Trait {
            fact: *fact,
            holds: true,
        });
        let theirs = others.iter().flat_map(|other| {
            let facts = self.facts_of(*other).iter();
            facts.map(|fact| self.instead(*fact, *other, entity))
        });
        let mut lacking: Vec<Fact> = theirs.filter(|fact| !state.holds(*fact)).collect();
        lacking.sort_unstable();
        lacking.dedup();
        // Each trait with the other entities that share it.
        let mut traits: Vec<(Trait, Vec<EntityId>)> = Vec::new();
        for own in own.chain(lacking.into_iter().map(|fact| Trait { fact, holds: false })) {
            if traits.len() >= CANDIDATES || !effort::spend(1 + others.len()) {
                break;
            }
            let is_shared = |other: &EntityId| state.holds(self.instead(own.fact, entity, *other)) == own.holds;
            let shared: Vec<EntityId> = others.iter().copied().filter(is_shared).collect();
            if shared.len() < others.len() {
                traits.push((own, shared));
            }
        }
        for size in 1..=FACTS {
            let mut chosen = Vec::new();
            if combination(&traits, &others, size, &mut chosen) {
                return chosen;
            }
        }
        // No combination fits the entity alone: the trait that the fewest others share says the most.
        let rarest = traits.iter().min_by_key(|(_, shared)| shared.len());
        rarest.map(|(own, _)| *own).into_iter().collect()
    }
}

/// Extends `chosen` by the first combination of `size` traits that none of `rest` shares.
fn combination(traits: &[(Trait, Vec<EntityId>)], rest: &[EntityId], size: usize, chosen: &mut Vec<Trait>) -> bool {
    if rest.is_empty() {
        return true;
    }
    if size == 0 {
        return false;
    }
    for (index, (own, shared)) in traits.iter().enumerate() {
        if !effort::spend(1 + rest.len()) {
            return false;
        }
        let left: Vec<EntityId> = rest.iter().copied().filter(|other| shared.contains(other)).collect();
        if left.len() == rest.len() {
            continue;
        }
        chosen.push(*own);
        if combination(&traits[index + 1..], &left, size - 1, chosen) {
            return true;
        }
        chosen.pop();
    }
    false
}

impl Trait {
    /// Returns the fact in the domain's words, without its subject where a template permits that.
    fn words(self, world: &World) -> String {
        let words = world.domain().words(self.fact.predicate());
        let name = |place: usize| Voice::Person.name(world, self.fact.argument(place));
        match (self.holds, &words.short) {
            (true, Some(short)) => short.fill(name),
            (true, None) => words.says.fill_after_subject(name),
            (false, _) => words.denies.fill_after_subject(name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::parse;
    use crate::testing;

    #[track_caller]
    fn check(states: &str, expected: &[&str]) {
        let household = testing::domain("household");
        let text = format!(
            r#"{{"assets": ["<table>", "<shelf>"], "objects": ["<cup_1>", "<cup_2>", "<cup_3>"], "object_states": {states}}}"#
        );
        let world = parse(&household, "env.json", &text).unwrap();
        assert_eq!(Distinctions::of(&world).describe(&world.named("cup")), expected);
    }

    #[test]
    fn distinction_uses_the_fewest_facts() {
        check(
            r#"{"<cup_1>": "on_something(<table>)", "<cup_2>": "on_something(<shelf>)", "<cup_3>": "inside_hand()"}"#,
            &["cup 1 (on the table)", "cup 2 (on the shelf)", "cup 3 (in the hand)"],
        );
        check(
            r#"{"<cup_1>": ["on_something(<table>)", "next_to(<shelf>)"], "<cup_2>": "on_something(<table>)",
                "<cup_3>": ["on_something(<shelf>)", "next_to(<table>)"]}"#,
            &[
                "cup 1 (is next to the shelf)",
                "cup 2 (on the table, is not next to the shelf)",
                "cup 3 (on the shelf)",
            ],
        );
        check("{}", &["cup 1", "cup 2", "cup 3"]);
    }
}
