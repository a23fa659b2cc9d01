//! Bindings under which a rule is broken.

use super::{Atom, Bindings, Condition, EntityId, Moment, Rule, State, Term, World, holds};
use crate::effort;

/// The bindings of the rule's variables under which it does not hold, in order.
///
/// A rule is mostly of the form "not (this and that)", so candidates come from the facts that hold rather
/// than from all combinations of entities.
pub fn broken_bindings(rule: &Rule, world: &World, state: &State) -> Vec<Bindings> {
    let parts = match &rule.condition {
        Condition::Or(parts) => parts.as_slice(),
        other => std::slice::from_ref(other),
    };
    // For the rule to be broken, each atom that must not hold in one of the alternatives has to hold.
    let mut partial = vec![vec![None; rule.variables.len()]];
    for (atom, initially) in parts.iter().flat_map(denied_atoms) {
        partial = join(&partial, atom, if initially { &world.state } else { state });
    }
    let mut broken = Vec::new();
    for bindings in partial {
        complete(rule, world, state, &bindings, &mut Vec::new(), &mut broken);
    }
    broken.sort();
    broken.dedup();
    broken
}

/// Atoms that have to hold for the alternative to fail, and whether they are asked of the start.
fn denied_atoms(part: &Condition) -> Vec<(&Atom, bool)> {
    match part {
        Condition::Atom {
            atom,
            holds: false,
            initially,
        } => vec![(atom, *initially)],
        Condition::Or(parts) => parts.iter().flat_map(denied_atoms).collect(),
        _ => Vec::new(),
    }
}

/// Each partial binding, extended in every way in which the atom holds.
fn join(partial: &[Vec<Option<EntityId>>], atom: &Atom, state: &State) -> Vec<Vec<Option<EntityId>>> {
    let mut joined = Vec::new();
    for bindings in partial {
        // Facts are sorted by their first argument: where that is known, only those are looked at.
        let first = match atom.terms.first() {
            Some(Term::Constant(constant)) => Some(*constant),
            Some(Term::Variable(slot)) => bindings.get(*slot).copied().flatten(),
            None => None,
        };
        let facts = match first {
            Some(first) => state.of_first(atom.predicate, first),
            None => state.of_predicate(atom.predicate),
        };
        if !effort::spend(1 + facts.len()) {
            break;
        }
        for fact in facts {
            let mut extended = bindings.clone();
            let fits = atom.terms.iter().enumerate().all(|(place, term)| {
                let entity = fact.argument(place);
                match term {
                    Term::Constant(constant) => *constant == entity,
                    // A variable that is quantified inside the rule is not one of the rule's own.
                    Term::Variable(slot) => extended
                        .get_mut(*slot)
                        .is_none_or(|bound| *bound.get_or_insert(entity) == entity),
                }
            });
            if fits {
                effort::spend(effort::KEPT);
                joined.push(extended);
            }
        }
    }
    joined
}

fn complete(
    rule: &Rule,
    world: &World,
    state: &State,
    partial: &[Option<EntityId>],
    bindings: &mut Bindings,
    broken: &mut Vec<Bindings>,
) {
    let Some(variable) = rule.variables.get(bindings.len()) else {
        if !holds(Moment { world, state }, &rule.condition, bindings) {
            // A list of its own, and a violation that is made of it.
            effort::spend(4 * effort::KEPT);
            broken.push(bindings.clone());
        }
        return;
    };
    let all = world.of_kind(variable.kind);
    let fixed = partial[bindings.len()];
    let candidates = fixed.as_ref().map_or(all, std::slice::from_ref);
    for entity in candidates
        .iter()
        .filter(|entity| fixed.is_none() || all.contains(entity))
    {
        if !effort::spend(1) {
            return;
        }
        bindings.push(*entity);
        complete(rule, world, state, partial, bindings, broken);
        bindings.pop();
    }
}
