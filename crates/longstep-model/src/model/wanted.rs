//! A goal condition with its bindings.

use super::{Atom, Condition, Domain, EntityId, Fact, Term, When};

/// A condition to achieve, with the entities bound to its first slots.
#[derive(Debug, Clone)]
pub struct Wanted {
    /// The condition.
    pub condition: Condition,
    /// The entities bound to the slots from 0.
    pub bindings: Vec<EntityId>,
}

impl Wanted {
    /// Creates the goal condition that a fact holds.
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
                at: When::Now,
            },
            bindings: (0..arity).map(|place| fact.argument(place)).collect(),
        }
    }
}
