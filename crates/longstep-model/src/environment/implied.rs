//! Facts that an environment implies without stating them: derivations from names, defaults, and assumptions.

use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::{AssumptionSource, Bindings, EntityId, Fact, Moment, World, holds};
use crate::effort;
use crate::model::{Literal, NameForms, PredicateId, Unknown, ground, unified};

/// Adds the facts that the environment implies. `denied` are the facts that it states to be false, `given` the predicates
/// of its properties.
pub(super) fn add_implied(world: &mut World, mut denied: FxHashSet<Fact>, given: &FxHashSet<usize>) {
    let domain = world.domain().clone();
    let listed = world.entities.iter().take_while(|entity| !entity.is_value);
    let forms: Vec<NameForms> = listed.map(|entity| NameForms::of(&entity.identifier)).collect();
    let of_complete = |index: &usize| domain.predicate_words[*index].complete;
    let complete: FxHashSet<usize> = given.iter().copied().filter(of_complete).collect();
    for index in 0..domain.derivations.len() {
        let not = derive(index, world, &forms, &denied, &complete);
        // Properties in the environment take precedence over derivations from names.
        denied.extend(not.into_iter().filter(|fact| !world.state.holds(*fact)));
    }
    for default in &domain.defaults {
        for index in 0..forms.len() {
            let entity = EntityId::new(index);
            let mut bindings: Bindings = vec![entity];
            let moment = Moment {
                world,
                state: &world.state,
            };
            if holds(moment, &default.when, &mut bindings) {
                let fact = ground(&default.atom, &bindings);
                if world.state.set(fact, true) {
                    Arc::make_mut(&mut world.assumed).insert(fact, AssumptionSource::Default);
                }
            }
        }
    }
    for (index, words) in domain.predicate_words.iter().enumerate() {
        if words.unknown == Unknown::Assume && !given.contains(&index) {
            let predicate = &domain.predicates[index];
            for entity in world.of_kind(predicate.parameters[0].kind).to_vec() {
                let fact = Fact::new(PredicateId::new(index), [entity]);
                if !world.entity(entity).is_value && !denied.contains(&fact) && world.state.set(fact, true) {
                    Arc::make_mut(&mut world.assumed).insert(fact, AssumptionSource::Unknown);
                }
            }
        }
    }
}

/// Adds the derived facts to the world; returns those derived to be false, which are then not assumed as unknown.
///
/// `forms` are the forms of the identifiers, in order; `complete` are the predicates of which the environment gives all
/// facts.
fn derive(
    index: usize,
    world: &mut World,
    forms: &[NameForms],
    denied: &FxHashSet<Fact>,
    complete: &FxHashSet<usize>,
) -> Vec<Fact> {
    let domain = world.domain().clone();
    let derivation = &domain.derivations[index];
    let matching = |names: &[String]| -> Vec<EntityId> {
        let fits = |form: &NameForms| names.is_empty() || names.iter().any(|name| form.end_with(name));
        let all = forms.iter().enumerate().filter(|(_, form)| fits(form));
        all.map(|(index, _)| EntityId::new(index)).collect()
    };
    let subjects = matching(&derivation.names);
    let pairs: Vec<(EntityId, EntityId)> = if let Some(pattern) = &derivation.pattern {
        let bare = |id: EntityId| unified(&world.entity(id).identifier);
        let named: FxHashMap<String, EntityId> = subjects.iter().map(|id| (bare(*id), *id)).collect();
        let others = matching(&derivation.other_names);
        let pair = |other| Some((*named.get(&unified(&pattern.replace("{other}", &bare(other))))?, other));
        others.into_iter().filter_map(pair).collect()
    } else if derivation.binary {
        let others = matching(&derivation.other_names);
        let with = |id: EntityId| {
            others
                .iter()
                .map(move |other| (id, *other))
                .filter(|(id, other)| id != other)
        };
        subjects.into_iter().flat_map(with).collect()
    } else {
        subjects.into_iter().map(|id| (id, id)).collect()
    };
    let mut follows = Vec::new();
    for (id, other) in pairs {
        if !effort::spend(1) {
            break;
        }
        let mut bindings: Bindings = vec![id, other];
        let moment = Moment {
            world,
            state: &world.state,
        };
        if holds(moment, &derivation.when, &mut bindings) {
            let grounded = |literal: &Literal| (ground(&literal.atom, &bindings), literal.holds);
            follows.extend(derivation.literals.iter().map(grounded));
        }
    }
    let open = |fact: &Fact| !denied.contains(fact) && !complete.contains(&fact.predicate().index());
    for (fact, _) in follows.iter().filter(|(fact, holds)| *holds && open(fact)) {
        if world.state.set(*fact, true) {
            Arc::make_mut(&mut world.assumed).insert(*fact, AssumptionSource::Derived { derivation: index });
        }
    }
    follows
        .into_iter()
        .filter(|(_, holds)| !holds)
        .map(|(fact, _)| fact)
        .collect()
}
