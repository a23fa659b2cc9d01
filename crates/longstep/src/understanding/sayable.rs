//! The parts of goals that can be said in a world: kinds and states of groups, and facts that no goal word is about.

use indexmap::IndexSet;
use longstep_core::model::Domain;

use crate::environment::{EntityId, Fact, World};
use crate::model::{Condition, PredicateId, plain_words, singular};

/// The longest list of states that may select the members of a group.
const STATES: usize = 64;

/// Returns the kinds that some of the entities belong to: types, the last words of their names, and `thing`.
pub(super) fn kinds(world: &World, entities: &[EntityId]) -> Vec<String> {
    let mut kinds: IndexSet<String> = IndexSet::new();
    let called = entities.iter().map(|entity| world.entity(*entity));
    let names = called.flat_map(|entity| std::iter::once(&entity.name).chain(&entity.names));
    for name in names {
        let words = plain_words(name);
        let numbers = words.iter().rev().take_while(|word| is_number(word)).count();
        let words = &words[..words.len() - numbers];
        for start in (0..words.len()).rev() {
            let mut kind = words[start..].to_vec();
            if let Some(last) = kind.last_mut() {
                *last = singular(last);
            }
            kinds.insert(kind.join(" "));
        }
    }
    let domain = world.domain();
    for name in domain.types.names() {
        let own = domain.types.find(name);
        if own.is_some_and(|kind| entities.iter().any(|entity| world.is_of_kind(*entity, kind))) {
            kinds.insert(name.replace('_', " "));
        }
    }
    kinds.insert("thing".to_owned());
    kinds.into_iter().collect()
}

fn is_number(word: &str) -> bool {
    word.bytes().all(|byte| byte.is_ascii_digit())
}

/// Returns the states that some of the entities are in, and those that some of them are not in, in the notation of groups.
pub(super) fn states(world: &World, entities: &[EntityId]) -> Vec<String> {
    let domain = world.domain();
    let mut states: IndexSet<String> = IndexSet::new();
    for word in &domain.states {
        if domain.is_sensed(word.atom.predicate) || word.parameters.len() > 1 {
            continue;
        }
        for fact in world
            .state
            .iter()
            .filter(|fact| fact.predicate() == word.atom.predicate)
        {
            let Some((member, others)) = member_and_others(&word.atom, fact) else {
                continue;
            };
            if entities.contains(&member) {
                let names: Vec<&str> = others.iter().map(|other| world.entity(*other).name.as_str()).collect();
                states.insert(written(&word.word, &names));
            }
        }
        if word.parameters.is_empty() {
            states.insert(word.word.clone());
        }
    }
    states.extend(domain.properties.iter().map(|property| property.word.clone()));
    let negated: Vec<String> = states.iter().map(|state| format!("not {state}")).collect();
    states.extend(negated);
    states.truncate(STATES);
    states.into_iter().collect()
}

/// Returns the entity that a fact of a state word is about, and its other arguments in the order of the word.
fn member_and_others(atom: &crate::model::Atom, fact: Fact) -> Option<(EntityId, Vec<EntityId>)> {
    let mut slots: Vec<(usize, EntityId)> = Vec::new();
    for (place, term) in atom.terms.iter().enumerate() {
        match term {
            crate::model::Term::Variable(slot) => slots.push((*slot, fact.argument(place))),
            crate::model::Term::Constant(own) if *own == fact.argument(place) => {}
            crate::model::Term::Constant(_) => return None,
        }
    }
    slots.sort_unstable();
    let mut entities = slots.into_iter().map(|(_, entity)| entity);
    Some((entities.next()?, entities.collect()))
}

fn written(word: &str, names: &[&str]) -> String {
    match names {
        [] => word.to_owned(),
        _ => format!("{word}({})", names.join(", ")),
    }
}

/// Returns the facts that change and that no goal word is about: where the robot is, what it holds.
pub(super) fn other_predicates(domain: &Domain) -> Vec<PredicateId> {
    let of_goals = |predicate: PredicateId| {
        let conditions = domain.goal_words.iter().map(|word| &word.condition);
        conditions
            .flat_map(Condition::atoms)
            .any(|(atom, _)| atom.predicate == predicate)
    };
    let all = (0..domain.predicates.len()).map(PredicateId::new);
    all.filter(|id| {
        let words = domain.words(*id);
        let has_arguments = !domain.predicate(*id).parameters.is_empty();
        words.fluent && !words.event && !domain.is_sensed(*id) && !of_goals(*id) && has_arguments
    })
    .collect()
}

/// Returns the word for a fact that no goal word is about.
pub(super) fn fact_word(domain: &Domain, id: PredicateId) -> String {
    domain.predicate(id).name.replace('-', "_")
}
