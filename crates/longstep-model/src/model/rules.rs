//! Evaluation of rules: the bindings that violate a rule.

use super::{Atom, Bindings, Condition, EntityId, Moment, Rule, State, Term, When, World, holds};
use crate::effort;

/// Returns the bindings of the rule's variables under which its condition is false, in order.
///
/// Most rules have the form "not (A and B)". Candidates therefore come from the facts that hold, not from all
/// combinations of entities.
pub fn broken_bindings(rule: &Rule, world: &World, state: &State) -> Vec<Bindings> {
    let parts = match &rule.condition {
        Condition::Or(parts) => parts.as_slice(),
        other => std::slice::from_ref(other),
    };
    // A binding violates the rule only if every negated atom of the alternatives holds.
    let mut partial = vec![vec![None; rule.variables.len()]];
    for (atom, at) in parts.iter().flat_map(denied_atoms) {
        partial = join(&partial, atom, world.past(at).unwrap_or(state));
    }
    let mut broken = Vec::new();
    for bindings in partial {
        complete(rule, world, state, &bindings, &mut Vec::new(), &mut broken);
    }
    broken.sort();
    broken.dedup();
    broken
}

/// Returns the negated atoms that must hold for the alternative to be false, with the state in which each is
/// evaluated.
fn denied_atoms(part: &Condition) -> Vec<(&Atom, When)> {
    match part {
        Condition::Atom { atom, holds: false, at } => vec![(atom, *at)],
        Condition::Or(parts) => parts.iter().flat_map(denied_atoms).collect(),
        _ => Vec::new(),
    }
}

/// Extends each partial binding by every fact that matches the atom.
fn join(partial: &[Vec<Option<EntityId>>], atom: &Atom, state: &State) -> Vec<Vec<Option<EntityId>>> {
    let mut joined = Vec::new();
    for bindings in partial {
        // Facts are sorted by first argument, so a known first argument selects a range of them.
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
                    // A variable quantified inside the rule has no place in these bindings.
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
            // Charges the list and the violation made from it.
            effort::spend((2 * bindings.len()).saturating_sub(2).max(4) * effort::KEPT);
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
