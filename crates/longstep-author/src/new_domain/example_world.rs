//! The environment of a new domain.

use indexmap::IndexMap;

use super::Blueprint;
use longstep::domain::TypeId;
use longstep_core::call::Call;
use longstep_core::environment::{EntityId, Environment, Words as Statements, World};
use longstep_core::model::{Domain, state_word};

/// Returns the types of an environment's two lists, assets and objects. They are two types if every entity is of one of
/// them; otherwise both lists admit everything.
pub(super) fn lists(domain: &Domain, blueprint: &Blueprint, world: &World) -> (TypeId, TypeId) {
    let types = &domain.types;
    let all: Vec<TypeId> = (1..types.names().count()).map(TypeId::new).collect();
    let below = |parent: TypeId| -> Vec<TypeId> {
        let inside = |kind: &&TypeId| **kind != parent && types.is_a(**kind, parent);
        let inside: Vec<TypeId> = all.iter().filter(inside).copied().collect();
        let direct = inside.iter().filter(|kind| {
            let mut others = inside.iter();
            !others.any(|other| other != *kind && types.is_a(**kind, *other))
        });
        direct.copied().collect()
    };
    let mut tops = below(TypeId::OBJECT);
    while let [only] = tops[..] {
        let inside = below(only);
        if inside.is_empty() {
            break;
        }
        tops = inside;
    }
    let both = (TypeId::OBJECT, TypeId::OBJECT);
    let [left, right] = tops[..] else { return both };
    let entities = world.entities().skip(domain.constants.len());
    let mut kinds = entities.map(|(_, entity)| entity.kind);
    if !kinds.all(|kind| types.is_a(kind, left) || types.is_a(kind, right)) {
        return both;
    }
    let is_place = |kind: TypeId| {
        blueprint
            .places
            .as_ref()
            .map(|places| places.iter().any(|p| p == types.name(kind)))
    };
    // What is moved is what relations that change are about.
    let moves = |kind: TypeId| {
        let mut predicates = domain.predicates.iter().zip(&domain.predicate_words);
        let related = |first: TypeId| types.is_a(first, kind) || types.is_a(kind, first);
        is_place(kind).map_or_else(
            || predicates.any(|(p, words)| words.fluent && p.parameters.len() > 1 && related(p.parameters[0].kind)),
            |place| !place,
        )
    };
    match (moves(left), moves(right)) {
        (true, false) => (right, left),
        (false, true) => (left, right),
        _ => both,
    }
}

/// Writes the world of a problem as an environment of the domain with words.
pub(super) fn environment(domain: &Domain, world: &World, (assets, objects): (TypeId, TypeId)) -> Environment {
    let types = &domain.types;
    let mut environment = Environment::default();
    let mut kinds = IndexMap::new();
    let identifier = |name: &str| format!("<{name}>");
    for (_, entity) in world.entities().skip(domain.constants.len()) {
        let is_object = types.is_a(entity.kind, objects);
        let (list, of) = if is_object {
            (&mut environment.objects, objects)
        } else {
            (&mut environment.assets, assets)
        };
        list.push(identifier(&entity.identifier));
        if entity.kind != of {
            kinds.insert(identifier(&entity.identifier), types.name(entity.kind).to_owned());
        }
    }
    environment.types = (!kinds.is_empty()).then_some(kinds);
    let named = |id: EntityId| {
        let own = &world.entity(id).identifier;
        if id.index() < domain.constants.len() {
            own.clone()
        } else {
            identifier(own)
        }
    };
    let mut states: [IndexMap<String, Vec<String>>; 2] = [IndexMap::new(), IndexMap::new()];
    let mut facts = Vec::new();
    let mut state = |name: &str, mut arguments: Vec<EntityId>, number: Option<String>| {
        let subject = (!arguments.is_empty()).then(|| arguments.remove(0));
        let call = Call {
            name: name.to_owned(),
            arguments: arguments.into_iter().map(named).chain(number).collect(),
        };
        let Some(subject) = subject else {
            return facts.push(call.to_string());
        };
        let section = usize::from(types.is_a(world.entity(subject).kind, objects));
        states[section]
            .entry(named(subject))
            .or_default()
            .push(call.to_string());
    };
    for fact in world.state.iter() {
        if let Some(word) = state_word(domain, fact.predicate()) {
            state(&word.word, domain.arguments(fact).collect(), None);
        }
    }
    for (fluent, number) in world.state.numbers() {
        let word = &domain.function(fluent.function()).word;
        state(word, domain.arguments_of(*fluent).collect(), Some(number.to_string()));
    }
    let alone = world.state.iter().map(|fact| domain.predicate(fact.predicate()));
    facts.extend(alone.filter(|p| p.parameters.is_empty()).map(|p| p.name.clone()));
    let statements = |states: IndexMap<String, Vec<String>>| {
        let one = |(name, words)| (name, Statements::Many(words));
        states.into_iter().map(one).collect()
    };
    let [of_assets, of_objects] = states;
    environment.asset_states = statements(of_assets);
    environment.object_states = statements(of_objects);
    let alone = domain.predicates.iter().zip(&domain.predicate_words);
    let mut alone = alone.filter(|(predicate, _)| predicate.parameters.is_empty());
    let numbers = domain.functions.iter().any(|function| function.parameters.is_empty());
    environment.facts = (alone.next().is_some() || numbers).then_some(facts);
    environment
}

/// Returns the environment as a file.
pub(super) fn json(environment: &Environment, schema: &str) -> String {
    // An environment is plain data with string keys; its serialization does not fail.
    let value = serde_json::json!({ "$schema": schema, "environment": environment });
    let mut text = serde_json::to_string_pretty(&value).unwrap_or_default();
    text.push('\n');
    text
}
