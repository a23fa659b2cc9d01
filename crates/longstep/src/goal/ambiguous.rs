//! Questions about ambiguous references that affect the plan.

use super::mention::{DETERMINERS, among};
use super::{Goal, GoalFact, Spoken};
use crate::environment::{EntityId, Fact, Moment, Voice, World, holds};
use crate::model::{base_name, head, singular};
use longstep_core::model::Domain;

/// Indefinite articles.
const ANY: &str = "a an";

/// Returns a question if the instruction refers to a definite object and several in different places fit: "the mug".
/// Returns none if the reference is clear or the choice makes no difference.
pub(super) fn which(world: &World, spoken: &Spoken, goal: &Goal) -> Option<String> {
    let domain = world.domain();
    let is_open = |fact: &&GoalFact| matches!(fact, GoalFact::Word { .. }) && goal.grouped_part(fact).is_none();
    let facts = goal.facts.iter().filter(is_open);
    for fact in facts {
        let GoalFact::Word { word, arguments } = fact else {
            continue;
        };
        let word = domain.goal_word(*word);
        let Some(parameter) = word.subject else { continue };
        let subject = arguments[parameter];
        if !is_certain(world, spoken, subject) || spoken.several(&world.entity(subject).names) {
            continue;
        }
        let taken = |other: EntityId| {
            let mut others = goal.facts.iter();
            others.any(|fact| fact.subject(domain) == Some(other))
        };
        let wish_is_open = |other: EntityId| {
            let mut instead = arguments.clone();
            instead[parameter] = other;
            let moment = Moment {
                world,
                state: &world.state,
            };
            holds(moment, &word.offered, &mut instead) && !holds(moment, &word.condition, &mut instead)
        };
        let kind = base_name(&world.entity(subject).identifier);
        let here = places(world, subject);
        let told = |places: &[Fact]| {
            let mut places = places.iter().flat_map(|fact| domain.arguments(*fact).skip(1));
            places.any(|place| spoken.entities.contains(&place))
        };
        let rivals: Vec<EntityId> = spoken
            .entities
            .iter()
            .copied()
            .filter(|other| *other != subject && base_name(&world.entity(*other).identifier) == kind)
            .filter(|other| !taken(*other) && wish_is_open(*other))
            .filter(|other| where_from(domain, &places(world, *other)) != where_from(domain, &here))
            .collect();
        // A mentioned place identifies the object.
        if rivals.is_empty() || told(&here) || rivals.iter().any(|rival| told(&places(world, *rival))) {
            continue;
        }
        let mut all = vec![subject];
        all.extend(rivals);
        all.sort_unstable();
        let described: Vec<String> = all.iter().map(|entity| described(world, *entity)).collect();
        let name = head(&world.entity(subject).name);
        return Some(format!("Which {name} do you mean: {}?", described.join(", or ")));
    }
    None
}

/// Returns true if the instruction refers to the entity with a definite determiner: "the mug", "my mug".
fn is_certain(world: &World, spoken: &Spoken, entity: EntityId) -> bool {
    let heads: Vec<String> = world.entity(entity).names.iter().map(|name| head(name)).collect();
    let words = spoken.words();
    let places = words
        .iter()
        .enumerate()
        .filter(|(_, word)| heads.contains(&singular(word)));
    // Up to two words of description may follow the determiner: "the big red mug".
    places.into_iter().any(|(place, _)| {
        let before = words[place.saturating_sub(3)..place].iter().rev();
        let article = before.into_iter().find(|word| among(DETERMINERS, word));
        article.is_some_and(|article| !among(ANY, article))
    })
}

/// Returns the facts about where an entity is.
fn places(world: &World, entity: EntityId) -> Vec<Fact> {
    let domain = world.domain();
    let about =
        |fact: &Fact| domain.is_relation(*fact) && domain.words(fact.predicate()).fluent && fact.argument(0) == entity;
    world.state.iter().filter(about).collect()
}

/// Returns the places of an entity, without the entity itself, for comparison.
fn where_from(domain: &Domain, places: &[Fact]) -> Vec<(usize, Vec<EntityId>)> {
    let rest = |fact: &Fact| (fact.predicate().index(), domain.arguments(*fact).skip(1).collect());
    places.iter().map(rest).collect()
}

fn described(world: &World, entity: EntityId) -> String {
    let name = &world.entity(entity).name;
    // The last fact is the most specific: the surface rather than the room.
    let place = places(world, entity).into_iter().rev().find_map(|fact| {
        let says = Voice::Person.fact(world, fact, true);
        says.strip_prefix(&format!("{name} is ")).map(str::to_owned)
    });
    match place {
        Some(place) => format!("{name} {place}"),
        None => name.clone(),
    }
}
