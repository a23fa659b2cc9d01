//! Selection of the relevant part of a large world.

use std::cmp::Reverse;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::environment::{EntityId, World};
use crate::instruction::Mentions;
use crate::model::{PredicateId, plain_words, singular, stem};

/// Maximum candidates for an ambiguous reference to one entity of a kind.
const CANDIDATES: usize = 12;
/// Maximum entities of a kind when the instruction refers to all of them.
const ALL: usize = 100;
/// Maximum number of required entities.
const NEEDED: usize = 200;
/// Maximum neighbours of an entity: entities on or in it, or its parts.
const NEIGHBOURS: usize = 30;
/// Maximum length of a chain of relations, such as on or in.
const DEPTH: usize = 8;
/// A changing unary fact of at most this many entities describes the robot: an object in its hand.
const FEW: usize = 3;

/// The entities of a world, ranked by relevance to an instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Focus {
    /// All entities, each once.
    pub ranked: Vec<EntityId>,
    /// Length of the prefix of `ranked` that must be kept: named entities, their places and parts, and objects in the
    /// robot's hand.
    pub needed: usize,
}

/// Ranks the entities of a world by relevance to an instruction.
///
/// Entities that the instruction names come first, then objects in the robot's hand. Each is followed by its parts,
/// such as a handle, and by its place, the place of that place, and so on. Next come entities on or in these, then
/// entities with a name that shares a word with the instruction. The rest follows with places before objects, and one
/// entity of each kind before the second, because an unnamed tool or place is rarely the twentieth of its kind.
///
/// Among entities with one name, a number or identifier in the instruction decides; otherwise those at a named place
/// come first. If a large group is meant, only its first members are required.
///
/// ```
/// use longstep::{domain, dialogue};
/// use longstep_core::environment;
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<jar>", "<cup>"],
///     "object_states": {"<cup>": "on_something(<shelf>)", "<jar>": "on_something(<table>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let focus = dialogue::focus(&world, "Bring me the cup");
/// let names: Vec<&str> = focus.ranked.iter().map(|id| world.entity(*id).name.as_str()).collect();
/// assert_eq!(names, ["cup", "shelf", "table", "jar"]);
/// assert_eq!(focus.needed, 2);
/// ```
pub fn focus(world: &World, instruction: &str) -> Focus {
    let domain = world.domain();
    let near = Nearness::of(world);
    let named = named(world, instruction, &near);
    let mut ranking = Ranking {
        near: &near,
        ranked: Vec::new(),
        seen: FxHashSet::default(),
    };
    for id in named {
        ranking.push(id, DEPTH);
    }
    for id in handled(world) {
        ranking.push(id, DEPTH);
    }
    let needed = ranking.ranked.len().min(NEEDED);
    for id in ranking.ranked.clone() {
        for other in near.held_by.get(&id).into_iter().flatten().take(NEIGHBOURS) {
            ranking.push(*other, DEPTH);
        }
    }
    let words: Vec<String> = plain_words(instruction).iter().map(|word| singular(word)).collect();
    let mentioned = |id: EntityId| {
        let mut parts = world.entity(id).names.iter().flat_map(|name| plain_words(name));
        parts.any(|part| part.len() > 2 && words.contains(&singular(&part)))
    };
    let mut rest: Vec<(usize, bool, bool, EntityId)> = Vec::new();
    let mut ordinals: FxHashMap<String, usize> = FxHashMap::default();
    for (id, entity) in world.entities() {
        let ordinal = ordinals.entry(stem(&entity.identifier)).or_default();
        let movable = domain.types.is_a(entity.kind, domain.environment.object);
        rest.push((*ordinal, !mentioned(id), movable, id));
        *ordinal += 1;
    }
    // Partial mentions, then one entity of each kind, places first.
    rest.sort_by_key(|(ordinal, unmentioned, movable, id)| (*unmentioned || *ordinal > 0, *ordinal, *movable, *id));
    for (.., id) in rest {
        ranking.push(id, DEPTH);
    }
    Focus {
        ranked: ranking.ranked,
        needed,
    }
}

impl Focus {
    /// Finds the longest prefix of the ranking for which `attempt` succeeds, and returns its result. The prefix is
    /// never shorter than `needed`.
    ///
    /// The binary search assumes that a longer prefix costs more.
    pub(crate) fn most<T, E>(
        &self,
        at_most: usize,
        mut attempt: impl FnMut(&[EntityId]) -> Result<T, E>,
    ) -> Result<T, E> {
        let mut good = self.needed.min(self.ranked.len());
        let mut bad = at_most.clamp(good, self.ranked.len()) + 1;
        let mut made = attempt(&self.ranked[..good])?;
        while bad - good > 1 {
            let middle = good + (bad - good) / 2;
            match attempt(&self.ranked[..middle]) {
                Ok(better) => (made, good) = (better, middle),
                Err(_) => bad = middle,
            }
        }
        Ok(made)
    }
}

/// Relations between entities.
struct Nearness {
    /// For each entity, its places and the entities that it belongs to.
    around: FxHashMap<EntityId, Vec<EntityId>>,
    /// For each entity, its permanent parts.
    parts: FxHashMap<EntityId, Vec<EntityId>>,
    /// For each entity, the entities that are currently on or in it.
    held_by: FxHashMap<EntityId, Vec<EntityId>>,
}

impl Nearness {
    fn of(world: &World) -> Self {
        let domain = world.domain();
        let mut near = Self {
            around: FxHashMap::default(),
            parts: FxHashMap::default(),
            held_by: FxHashMap::default(),
        };
        for fact in world.state.iter().filter(|fact| domain.is_relation(*fact)) {
            let arguments: Vec<EntityId> = domain.arguments(fact).collect();
            near.around.entry(arguments[0]).or_default().extend(&arguments[1..]);
            let back = if domain.words(fact.predicate()).fluent {
                &mut near.held_by
            } else {
                &mut near.parts
            };
            for other in &arguments[1..] {
                back.entry(*other).or_default().push(arguments[0]);
            }
        }
        near
    }
}

/// Entities in order of first insertion.
struct Ranking<'a> {
    near: &'a Nearness,
    ranked: Vec<EntityId>,
    seen: FxHashSet<EntityId>,
}

impl Ranking<'_> {
    fn push(&mut self, id: EntityId, depth: usize) {
        if !self.seen.insert(id) {
            return;
        }
        self.ranked.push(id);
        if depth == 0 {
            return;
        }
        let near = self.near;
        let parts = near.parts.get(&id).into_iter().flatten().take(NEIGHBOURS);
        for other in parts.chain(near.around.get(&id).into_iter().flatten()) {
            self.push(*other, depth - 1);
        }
    }
}

/// Returns the objects in the robot's hand, and its location: arguments of changing facts that hold for few entities.
fn handled(world: &World) -> Vec<EntityId> {
    let domain = world.domain();
    let ids = (0..domain.predicates.len()).map(PredicateId::new);
    let few = ids.filter(|id| domain.words(*id).fluent && domain.predicate(*id).parameters.len() == 1);
    few.map(|id| world.state.of_predicate(id))
        .filter(|facts| facts.len() <= FEW)
        .flat_map(|facts| facts.iter().map(|fact| fact.argument(0)))
        .collect()
}

/// Returns the entities that the instruction names, in the order of the world.
fn named(world: &World, instruction: &str, near: &Nearness) -> Vec<EntityId> {
    let mentioned = Mentions::of(world, instruction);
    let words = plain_words(instruction);
    let exactly = |id: EntityId| {
        let entity = world.entity(id);
        let name = plain_words(&entity.name);
        let numbered = name
            .last()
            .is_some_and(|word| word.starts_with(|c: char| c.is_ascii_digit()));
        // A name without a number denotes the kind and identifies no single entity.
        instruction.contains(&entity.identifier) || (numbered && words.windows(name.len()).any(|part| part == name))
    };
    let mut kinds: Vec<(String, Vec<EntityId>)> = Vec::new();
    let mut places: FxHashMap<String, usize> = FxHashMap::default();
    for id in &mentioned.entities {
        let kind = stem(&world.entity(*id).identifier);
        let place = *places.entry(kind.clone()).or_insert_with(|| {
            kinds.push((kind, Vec::new()));
            kinds.len() - 1
        });
        kinds[place].1.push(*id);
    }
    let mut named: Vec<EntityId> = Vec::new();
    let mut open: Vec<Vec<EntityId>> = Vec::new();
    for (_, members) in kinds {
        let exact: Vec<EntityId> = members.iter().copied().filter(|id| exactly(*id)).collect();
        let several = || mentioned.several(&world.entity(members[0]).names);
        if !exact.is_empty() {
            named.extend(exact);
        } else if members.len() <= CANDIDATES || several() {
            named.extend(members.into_iter().take(ALL));
        } else {
            open.push(members);
        }
    }
    let certain: FxHashSet<EntityId> = named.iter().copied().collect();
    for mut members in open {
        let at_named = |id: &EntityId| {
            let around = near.around.get(id).into_iter().flatten();
            around.filter(|other| certain.contains(other)).count()
        };
        members.sort_by_key(|id| (Reverse(at_named(id)), *id));
        named.extend(members.into_iter().take(CANDIDATES));
    }
    named
}

#[cfg(test)]
mod tests {
    use super::*;
    use longstep_core::testing;

    const BOAT: &str = r#"{"assets": ["<deck>", "<cabin>", "<galley_table>", "<locker>", "<trash_bin>"],
        "asset_states": {"<galley_table>": "on_something(<cabin>)"},
        "objects": ["<rope>", "<locker_handle>", "<flag>", "<map>", "<spoon>",
                    "<tin_1>", "<tin_2>", "<tin_3>", "<tin_4>", "<tin_5>", "<tin_6>", "<tin_7>", "<tin_8>",
                    "<tin_9>", "<tin_10>", "<tin_11>", "<tin_12>", "<tin_13>", "<tin_14>"],
        "object_states": {"<rope>": "inside_something(<locker>)", "<locker_handle>": "closed()",
                          "<flag>": "inside_hand()", "<map>": "on_something(<galley_table>)",
                          "<spoon>": "on_something(<galley_table>)", "<tin_13>": "on_something(<galley_table>)"}}"#;

    /// Compares the required entities of the boat, by identifier.
    #[track_caller]
    fn check(instruction: &str, expected: &str) {
        let world = testing::world("household", BOAT);
        let found = focus(&world, instruction);
        let named: Vec<&str> = found.ranked[..found.needed]
            .iter()
            .map(|id| world.entity(*id).identifier.trim_matches(['<', '>']))
            .collect();
        assert_eq!(named.join(" "), expected);
        assert_eq!(found.ranked.len(), world.entities().count());
    }

    #[test]
    fn focus_adds_entities_that_named_entities_depend_on() {
        check("Hoist something", "locker_handle locker flag");
        check("Get the rope", "rope locker locker_handle flag");
        check("Read the map", "map galley_table cabin locker_handle locker flag");
        check(
            "Lay the spoon on the deck",
            "deck spoon galley_table cabin locker_handle locker flag",
        );
        check(
            "Put the rope in the trash bin",
            "trash_bin rope locker locker_handle flag",
        );
        check("Hand me tin 5", "tin_5 locker_handle locker flag");
        check("Hand me <tin_11>", "tin_11 locker_handle locker flag");
    }

    #[test]
    fn focus_prefers_alike_objects_at_a_named_place() {
        check(
            "Take the tin from the galley table",
            "galley_table cabin tin_13 tin_1 tin_2 tin_3 tin_4 tin_5 tin_6 tin_7 tin_8 tin_9 tin_10 tin_11 \
             locker_handle locker flag",
        );
        check(
            "Take all tins",
            "tin_1 tin_2 tin_3 tin_4 tin_5 tin_6 tin_7 tin_8 tin_9 tin_10 tin_11 tin_12 tin_13 galley_table cabin tin_14 \
             locker_handle locker flag",
        );
    }
}
