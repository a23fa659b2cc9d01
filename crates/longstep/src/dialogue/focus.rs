//! What of a large world an instruction can concern.

use std::cmp::Reverse;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::environment::{EntityId, World};
use crate::goal::Spoken;
use crate::model::{Domain, PredicateId, base_name, plain_words, singular};

/// Of a kind of which the instruction means one thing without saying which, so many are taken to be needed.
const CANDIDATES: usize = 12;
/// Of a kind of which it means all, so many at most: a model cannot count further anyway.
const ALL: usize = 100;
/// Never more than this is needed.
const NEEDED: usize = 200;
/// Of what is on or in a thing, so much is near it.
const NEIGHBOURS: usize = 30;
/// What stands on what, so many times over.
const DEPTH: usize = 8;
/// A changing fact that holds of no more things than this tells of the robot rather than of the place: what is in hand.
const FEW: usize = 3;

/// The entities of a world, those first that an instruction can concern.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Focus {
    /// Every entity, once.
    pub ranked: Vec<EntityId>,
    /// How many of the first ones must not be left out: what the instruction names with what that is on or in and what
    /// belongs to it, and what the robot has in hand.
    pub needed: usize,
}

/// Ranks the entities of a world for an instruction.
///
/// First comes what it names, and what the robot has in hand; each thing is followed by what it is on or in, and what
/// that is on or in, and by what belongs to it, such as a handle. Then comes what is on or in those, then what has a
/// name of which the instruction has a word, and then the rest: places before things, one of each kind before a second
/// one, since a tool or a place that nobody named is hardly ever the twentieth of its kind.
///
/// Of things that share a name, one that is called by its number or identifier is meant; if none is, those that are at
/// a place that is named come first. Of a great many things that are all meant only the first are needed.
///
/// ```
/// use longstep::{domain, json, dialogue, environment};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<jar>", "<cup>"],
///     "object_states": {"<cup>": "on_something(<shelf>)", "<jar>": "on_something(<table>)"}}"#;
/// let environment = environment::Environment::from_json(text).unwrap();
/// let world = environment::read(&household, &environment, "env.json", text, &json::Path::default()).unwrap();
/// let focus = dialogue::focus(&household, &world, "Bring me the cup");
/// let names: Vec<&str> = focus.ranked.iter().map(|id| world.entity(*id).name.as_str()).collect();
/// assert_eq!(names, ["cup", "shelf", "table", "jar"]);
/// assert_eq!(focus.needed, 2);
/// ```
pub fn focus(domain: &Domain, world: &World, instruction: &str) -> Focus {
    let near = Nearness::of(domain, world);
    let named = named(domain, world, instruction, &near);
    let mut ranking = Ranking {
        near: &near,
        ranked: Vec::new(),
        seen: FxHashSet::default(),
    };
    for id in named {
        ranking.push(id, DEPTH);
    }
    for id in handled(domain, world) {
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
        let ordinal = ordinals.entry(base_name(&entity.identifier)).or_default();
        let movable = domain.types.is_a(entity.kind, domain.environment.object);
        rest.push((*ordinal, !mentioned(id), movable, id));
        *ordinal += 1;
    }
    // Mentioned in part, then one of each kind, places first.
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
    /// The most entities, from the first on, with which `attempt` succeeds, and what it made of them: all if possible,
    /// and never fewer than are needed.
    ///
    /// More entities are taken to cost more.
    pub(super) fn most<T, E>(
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

/// What relates to what.
struct Nearness {
    /// What a thing is on or in, and what it belongs to.
    around: FxHashMap<EntityId, Vec<EntityId>>,
    /// What belongs to a thing for good.
    parts: FxHashMap<EntityId, Vec<EntityId>>,
    /// What is on or in a thing for now.
    held_by: FxHashMap<EntityId, Vec<EntityId>>,
}

impl Nearness {
    fn of(domain: &Domain, world: &World) -> Self {
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

/// Entities in the order in which they came first.
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

/// What the robot has in hand, where it is: changing facts that hold of few things.
fn handled(domain: &Domain, world: &World) -> Vec<EntityId> {
    let ids = (0..domain.predicates.len()).map(PredicateId::new);
    let few = ids.filter(|id| domain.words(*id).fluent && domain.predicate(*id).parameters.len() == 1);
    few.map(|id| world.state.of_predicate(id))
        .filter(|facts| facts.len() <= FEW)
        .flat_map(|facts| facts.iter().map(|fact| fact.argument(0)))
        .collect()
}

/// What the instruction names, in the order of the world.
fn named(domain: &Domain, world: &World, instruction: &str, near: &Nearness) -> Vec<EntityId> {
    let spoken = Spoken::of(domain, world, instruction);
    let words = plain_words(instruction);
    let exactly = |id: EntityId| {
        let entity = world.entity(id);
        let name = plain_words(&entity.name);
        let numbered = name
            .last()
            .is_some_and(|word| word.starts_with(|c: char| c.is_ascii_digit()));
        // A name without a number is that of its kind: nothing more exact can be said.
        instruction.contains(&entity.identifier) || (numbered && words.windows(name.len()).any(|part| part == name))
    };
    let mut kinds: Vec<(String, Vec<EntityId>)> = Vec::new();
    let mut places: FxHashMap<String, usize> = FxHashMap::default();
    for id in &spoken.entities {
        let kind = base_name(&world.entity(*id).identifier);
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
        let several = || spoken.several(&world.entity(members[0]).names);
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
    use crate::domain::shipped;
    use crate::environment::{Environment, read};
    use crate::json::Path;

    const BOAT: &str = r#"{"assets": ["<deck>", "<cabin>", "<galley_table>", "<locker>", "<trash_bin>"],
        "asset_states": {"<galley_table>": "on_something(<cabin>)"},
        "objects": ["<rope>", "<locker_handle>", "<flag>", "<map>", "<spoon>",
                    "<tin_1>", "<tin_2>", "<tin_3>", "<tin_4>", "<tin_5>", "<tin_6>", "<tin_7>", "<tin_8>",
                    "<tin_9>", "<tin_10>", "<tin_11>", "<tin_12>", "<tin_13>", "<tin_14>"],
        "object_states": {"<rope>": "inside_something(<locker>)", "<locker_handle>": "closed()",
                          "<flag>": "inside_hand()", "<map>": "on_something(<galley_table>)",
                          "<spoon>": "on_something(<galley_table>)", "<tin_13>": "on_something(<galley_table>)"}}"#;

    /// What must be shown of the boat, by identifier.
    #[track_caller]
    fn check(instruction: &str, expected: &str) {
        let domain = shipped("household").unwrap().unwrap();
        let world = read(
            &domain,
            &Environment::from_json(BOAT).unwrap(),
            "",
            "",
            &Path::default(),
        )
        .unwrap();
        let found = focus(&domain, &world, instruction);
        let named: Vec<&str> = found.ranked[..found.needed]
            .iter()
            .map(|id| world.entity(*id).identifier.trim_matches(['<', '>']))
            .collect();
        assert_eq!(named.join(" "), expected);
        assert_eq!(found.ranked.len(), world.entities().count());
    }

    #[test]
    fn what_is_named_brings_what_it_needs() {
        check("Hoist something", "locker_handle locker flag");
        check("Get the rope", "rope locker locker_handle flag");
        check("Read the map", "map galley_table cabin locker_handle locker flag");
        check(
            "Lay the spoon on the deck",
            "deck spoon galley_table cabin locker_handle locker flag",
        );
        check("Throw the rope away", "trash_bin rope locker locker_handle flag");
        check("Hand me tin 5", "tin_5 locker_handle locker flag");
        check("Hand me <tin_11>", "tin_11 locker_handle locker flag");
    }

    #[test]
    fn of_many_alike_those_at_a_named_place_come_first() {
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
