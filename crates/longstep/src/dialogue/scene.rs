//! The scene of a goal prompt: one line for each entity, with everyday names.

use rustc_hash::FxHashSet;

use super::example::scene_text;
use crate::environment::{EntityId, Fact, World};
use crate::instruction;

/// Renders the scene: every object with its place, and every place that a goal can be about.
pub fn scene(world: &World) -> String {
    let domain = world.domain();
    let is_object = |id: EntityId| domain.types.is_a(world.entity(id).kind, domain.environment.object);
    let goals = domain
        .goal_words
        .iter()
        .flat_map(|word| instruction::sayable(world, word));
    let sensed = instruction::conditions(world)
        .into_iter()
        .flat_map(|own| domain.arguments(own.fact).collect::<Vec<_>>());
    let mut shown: FxHashSet<EntityId> = goals.flatten().chain(sensed).collect();
    shown.extend(world.entities().map(|(id, _)| id).filter(|id| is_object(*id)));
    let (objects, places) = scene_lists(world, &shown);
    scene_text(&objects, &places)
}

/// The lines of a scene: each name with its description.
type Lines = Vec<(String, String)>;

/// Returns the lines of the objects and of the places among the shown entities.
pub fn scene_lists(world: &World, shown: &FxHashSet<EntityId>) -> (Lines, Lines) {
    let domain = world.domain();
    let is_object = |id: EntityId| domain.types.is_a(world.entity(id).kind, domain.environment.object);
    let facts: Vec<_> = world.known().iter().collect();
    let (mut objects, mut places) = (Vec::new(), Vec::new());
    for (id, entity) in world.entities().filter(|(id, _)| shown.contains(id)) {
        let object = is_object(id);
        let descriptions: Vec<String> = facts
            .iter()
            .filter_map(|fact| line(world, *fact, id, object, shown))
            .collect();
        let list = if object { &mut objects } else { &mut places };
        list.push((entity.name.clone(), descriptions.join(", ")));
    }
    (objects, places)
}

/// Returns the text that a fact adds to the line of `id`, if any. Relations of places are omitted.
fn line(world: &World, fact: Fact, id: EntityId, object: bool, shown: &FxHashSet<EntityId>) -> Option<String> {
    let domain = world.domain();
    let arity = domain.predicate(fact.predicate()).parameters.len();
    let short = domain.words(fact.predicate()).short.as_ref()?;
    let others_shown = || (1..arity).all(|place| shown.contains(&fact.argument(place)));
    let fits = arity > 0 && fact.argument(0) == id && (arity == 1 || object) && others_shown();
    fits.then(|| short.fill(|place| world.entity(fact.argument(place)).name.clone()))
}
