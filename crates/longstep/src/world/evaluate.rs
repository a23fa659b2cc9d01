//! Whether a condition holds.

use super::{EntityId, Fact, State, World};
use crate::domain::{Atom, Condition, Term};

/// The entities that the slots of a condition are bound to.
pub type Bindings = Vec<EntityId>;

/// The state that a condition is asked of, and the one in which the instruction was given.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// The entities and their types.
    pub world: &'a World,
    /// The state at hand.
    pub state: &'a State,
}

/// Whether `condition` holds under `bindings`, which are the same again afterwards.
pub fn holds(moment: Moment<'_>, condition: &Condition, bindings: &mut Bindings) -> bool {
    match condition {
        Condition::And(all) => all.iter().all(|c| holds(moment, c, bindings)),
        Condition::Or(any) => any.iter().any(|c| holds(moment, c, bindings)),
        Condition::Forall(slot, kind, inner) => {
            debug_assert_eq!(*slot, bindings.len());
            moment.world.of_kind(*kind).iter().all(|entity| {
                bindings.push(*entity);
                let result = holds(moment, inner, bindings);
                bindings.pop();
                result
            })
        }
        Condition::Exists(slot, kind, inner) => {
            debug_assert_eq!(*slot, bindings.len());
            moment.world.of_kind(*kind).iter().any(|entity| {
                bindings.push(*entity);
                let result = holds(moment, inner, bindings);
                bindings.pop();
                result
            })
        }
        Condition::Atom { atom, holds, initially } => {
            let state = if *initially { &moment.world.state } else { moment.state };
            state.holds(ground(atom, bindings)) == *holds
        }
        Condition::Equal { left, right, holds } => {
            (grounded_term(*left, bindings) == grounded_term(*right, bindings)) == *holds
        }
    }
}

/// The fact that an atom is under `bindings`.
pub(crate) fn ground(atom: &Atom, bindings: &[EntityId]) -> Fact {
    Fact::new(
        atom.predicate,
        atom.terms.iter().map(|term| grounded_term(*term, bindings)),
    )
}

/// The entity that a term is under `bindings`.
pub(crate) fn grounded_term(term: Term, bindings: &[EntityId]) -> EntityId {
    match term {
        Term::Variable(slot) => bindings[slot],
        Term::Constant(entity) => entity,
    }
}
