//! Descriptions of entities that share a name, by the facts in which they differ.

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

/// Describes each of these entities by the fewest facts that hold of no other one of them, in the domain's words: "pallet 2
/// (red)", "pallet 3 (blue, at bay 2)". An entity that no fact distinguishes has its name alone.
///
/// The facts of a description are the first combination of the smallest size in the order of the domain's predicates, so
/// it depends on the world alone.
///
/// ```
/// use longstep_core::{domain, environment::{self, distinctions}};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<cup_1>", "<cup_2>"],
///     "object_states": {"<cup_1>": "on_something(<table>)", "<cup_2>": "on_something(<shelf>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let cups = world.named("cup");
/// assert_eq!(distinctions(&world, &cups), ["cup 1 (on the table)", "cup 2 (on the shelf)"]);
/// ```
pub fn distinctions(world: &World, entities: &[EntityId]) -> Vec<String> {
    let described = |entity: &EntityId| {
        let name = world.entity(*entity).name.clone();
        let traits = distinguishing(world, *entity, entities);
        let words: Vec<String> = traits.iter().map(|own| own.words(world)).collect();
        match words.is_empty() {
            true => name,
            false => format!("{name} ({})", words.join(", ")),
        }
    };
    entities.iter().map(described).collect()
}

/// Returns true if a fact holds of one of two entities and not of the other, apart from facts that relate the two.
pub fn differ(world: &World, one: EntityId, other: EntityId) -> bool {
    let with = |entity: EntityId, another: EntityId| -> Vec<Fact> {
        let own = facts_of(world, entity).into_iter();
        own.map(|fact| instead(world, fact, entity, another)).collect()
    };
    let mut moved = with(one, other);
    let mut kept = facts_of(world, other);
    moved.sort_unstable();
    kept.sort_unstable();
    moved != kept
}

fn distinguishing(world: &World, entity: EntityId, entities: &[EntityId]) -> Vec<Trait> {
    let others: Vec<EntityId> = entities.iter().copied().filter(|other| *other != entity).collect();
    let is_so = |own: &Trait, other: EntityId| {
        let fact = instead(world, own.fact, entity, other);
        world.state.holds(fact) == own.holds
    };
    // For each trait the others that share it.
    let mut traits: Vec<(Trait, Vec<EntityId>)> = Vec::new();
    let own = facts_of(world, entity)
        .into_iter()
        .map(|fact| Trait { fact, holds: true });
    let lacking = others.iter().flat_map(|other| {
        let theirs = facts_of(world, *other).into_iter();
        theirs.map(|fact| instead(world, fact, *other, entity))
    });
    let mut lacking: Vec<Fact> = lacking.filter(|fact| !world.state.holds(*fact)).collect();
    lacking.sort_unstable();
    lacking.dedup();
    for own in own.chain(lacking.into_iter().map(|fact| Trait { fact, holds: false })) {
        if traits.len() >= CANDIDATES || !effort::spend(1 + others.len()) {
            break;
        }
        let shared: Vec<EntityId> = others.iter().copied().filter(|other| is_so(&own, *other)).collect();
        if shared.len() < others.len() {
            traits.push((own, shared));
        }
    }
    let mut best: Vec<Trait> = Vec::new();
    for size in 1..=FACTS {
        if combination(&traits, &others, size, &mut best) {
            return best;
        }
    }
    // No combination fits the entity alone: the fact that most others lack says the most.
    let nearest = traits.iter().min_by_key(|(_, shared)| shared.len());
    nearest.map(|(own, _)| *own).into_iter().collect()
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

/// Returns the facts with the entity as first argument, those that actions change first: a place says more than a
/// property that follows from a name.
fn facts_of(world: &World, entity: EntityId) -> Vec<Fact> {
    let domain = world.domain();
    let about = |fact: &Fact| domain.arguments(*fact).next() == Some(entity);
    let mut facts: Vec<Fact> = world.state.iter().filter(about).collect();
    facts.sort_by_key(|fact| {
        (
            world.assumed(*fact).is_some(),
            !domain.words(fact.predicate()).fluent,
            *fact,
        )
    });
    facts
}

/// Returns the fact with `other` in place of its first argument.
fn instead(world: &World, fact: Fact, entity: EntityId, other: EntityId) -> Fact {
    let arguments = world.domain().arguments(fact);
    Fact::new(
        fact.predicate(),
        arguments.map(|argument| if argument == entity { other } else { argument }),
    )
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

    #[track_caller]
    fn check(states: &str, expected: &[&str]) {
        let household = crate::domain::shipped("household").unwrap().unwrap();
        let text = format!(
            r#"{{"assets": ["<table>", "<shelf>"], "objects": ["<cup_1>", "<cup_2>", "<cup_3>"], "object_states": {states}}}"#
        );
        let world = parse(&household, "env.json", &text).unwrap();
        assert_eq!(distinctions(&world, &world.named("cup")), expected);
    }

    #[test]
    fn the_fewest_facts_distinguish() {
        check(
            r#"{"<cup_1>": "on_something(<table>)", "<cup_2>": "on_something(<shelf>)", "<cup_3>": "inside_hand()"}"#,
            &["cup 1 (on the table)", "cup 2 (on the shelf)", "cup 3 (in the hand)"],
        );
        check(
            r#"{"<cup_1>": ["on_something(<table>)", "next_to(<shelf>)"], "<cup_2>": "on_something(<table>)",
                "<cup_3>": ["on_something(<shelf>)", "next_to(<table>)"]}"#,
            &[
                "cup 1 (next to the shelf)",
                "cup 2 (on the table, is not next to the shelf)",
                "cup 3 (on the shelf)",
            ],
        );
        check("{}", &["cup 1", "cup 2", "cup 3"]);
    }
}
