//! Which of several things is meant, where an instruction fits more than one and it makes a difference.

use super::mention::{DETERMINERS, among};
use super::{Goal, GoalFact, Spoken};
use crate::environment::{EntityId, Fact, Moment, Voice, World, holds};
use crate::model::{Domain, base_name, head, singular};

/// Articles that speak of no certain thing.
const ANY: &str = "a an";

/// The question which of several things is meant: "the mug", where there are two, in different places, and nothing that
/// is said tells one from the other. None if it is clear, or makes no difference.
pub(super) fn which(domain: &Domain, world: &World, spoken: &Spoken, goal: &Goal) -> Option<String> {
    let facts = goal.facts.iter().filter(|fact| matches!(fact, GoalFact::Word { .. }));
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
        let here = places(domain, world, subject);
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
            .filter(|other| where_from(domain, &places(domain, world, *other)) != where_from(domain, &here))
            .collect();
        // Who says where the one stands has said which it is.
        if rivals.is_empty() || told(&here) || rivals.iter().any(|rival| told(&places(domain, world, *rival))) {
            continue;
        }
        let mut all = vec![subject];
        all.extend(rivals);
        all.sort_unstable();
        let described: Vec<String> = all.iter().map(|entity| described(domain, world, *entity)).collect();
        let name = head(&world.entity(subject).name);
        return Some(format!("Which {name} do you mean: {}?", described.join(", or ")));
    }
    None
}

/// Whether the instruction speaks of it as of a certain one: "the mug", "my mug".
fn is_certain(world: &World, spoken: &Spoken, entity: EntityId) -> bool {
    let heads: Vec<String> = world.entity(entity).names.iter().map(|name| head(name)).collect();
    let words = spoken.words();
    let places = words
        .iter()
        .enumerate()
        .filter(|(_, word)| heads.contains(&singular(word)));
    // Up to two words may describe it: "the big red mug".
    places.into_iter().any(|(place, _)| {
        let before = words[place.saturating_sub(3)..place].iter().rev();
        let article = before.into_iter().find(|word| among(DETERMINERS, word));
        article.is_some_and(|article| !among(ANY, article))
    })
}

/// The facts that tell where a thing is.
fn places(domain: &Domain, world: &World, entity: EntityId) -> Vec<Fact> {
    let about =
        |fact: &Fact| domain.is_relation(*fact) && domain.words(fact.predicate()).fluent && fact.argument(0) == entity;
    world.state.iter().filter(about).collect()
}

/// Where a thing is, without the thing.
fn where_from(domain: &Domain, places: &[Fact]) -> Vec<(usize, Vec<EntityId>)> {
    let rest = |fact: &Fact| (fact.predicate().index(), domain.arguments(*fact).skip(1).collect());
    places.iter().map(rest).collect()
}

fn described(domain: &Domain, world: &World, entity: EntityId) -> String {
    let name = &world.entity(entity).name;
    // The last is the nearest: what it stands on rather than the room.
    let place = places(domain, world, entity).into_iter().rev().find_map(|fact| {
        let says = Voice::Person.fact(domain, world, fact, true);
        says.strip_prefix(&format!("{name} is ")).map(str::to_owned)
    });
    match place {
        Some(place) => format!("{name} {place}"),
        None => name.clone(),
    }
}
