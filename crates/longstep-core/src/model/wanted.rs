//! A condition to be reached.

use super::{Atom, Condition, Domain, EntityId, Fact, Term};

/// A condition to be reached, with the entities that its first slots are bound to.
#[derive(Debug, Clone)]
pub struct Wanted {
    /// The condition.
    pub condition: Condition,
    /// Slots from 0.
    pub bindings: Vec<EntityId>,
}

impl Wanted {
    /// A fact as a condition to be reached.
    pub fn of_fact(domain: &Domain, fact: Fact) -> Self {
        let arity = domain.predicate(fact.predicate()).parameters.len();
        let atom = Atom {
            predicate: fact.predicate(),
            terms: (0..arity).map(Term::Variable).collect(),
        };
        Self {
            condition: Condition::Atom {
                atom,
                holds: true,
                initially: false,
            },
            bindings: (0..arity).map(|place| fact.argument(place)).collect(),
        }
    }
}
