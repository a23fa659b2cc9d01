//! Conditions and effects over variables, with names resolved.

use super::{EntityId, PredicateId, TypeId};

/// A variable's place among the bindings: parameters first, then quantified variables, outermost first.
pub type Slot = usize;

/// What stands in an argument place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Term {
    /// A parameter or a quantified variable.
    Variable(Slot),
    /// A constant of the domain; constants are the first entities of every world.
    Constant(EntityId),
}

/// A predicate applied to terms.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Atom {
    /// Which predicate.
    pub predicate: PredicateId,
    /// Its arguments.
    pub terms: Vec<Term>,
}

/// A condition in negation normal form: `not` stands only before atoms and equalities.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Condition {
    /// All of them; an empty one is true.
    And(Vec<Condition>),
    /// At least one of them; an empty one is false.
    Or(Vec<Condition>),
    /// For every entity of the type, bound to the slot.
    Forall(Slot, TypeId, Box<Condition>),
    /// For some entity of the type, bound to the slot.
    Exists(Slot, TypeId, Box<Condition>),
    /// The atom holds, or does not.
    Atom {
        /// The atom.
        atom: Atom,
        /// Whether it must hold (`true`) or must not.
        holds: bool,
        /// Asked of the state in which the instruction was given, not of the state at hand.
        initially: bool,
    },
    /// The terms are the same entity, or are not.
    Equal {
        /// One side.
        left: Term,
        /// The other side.
        right: Term,
        /// Whether they must be equal (`true`) or must differ.
        holds: bool,
    },
}

impl Condition {
    /// The condition that always holds.
    pub const TRUE: Condition = Condition::And(Vec::new());

    /// The opposite condition, in negation normal form again.
    #[must_use]
    pub fn negated(self) -> Self {
        let all = |conditions: Vec<Condition>| conditions.into_iter().map(Self::negated).collect();
        match self {
            Self::And(conditions) => Self::Or(all(conditions)),
            Self::Or(conditions) => Self::And(all(conditions)),
            Self::Forall(slot, kind, inner) => Self::Exists(slot, kind, Box::new(inner.negated())),
            Self::Exists(slot, kind, inner) => Self::Forall(slot, kind, Box::new(inner.negated())),
            Self::Atom { atom, holds, initially } => Self::Atom {
                atom,
                holds: !holds,
                initially,
            },
            Self::Equal { left, right, holds } => Self::Equal {
                left,
                right,
                holds: !holds,
            },
        }
    }

    /// The condition with every slot from `from` on moved by so many places: room for variables that are bound between
    /// those outside of the condition and its own.
    #[must_use]
    pub(crate) fn shifted(self, from: Slot, by: usize) -> Self {
        let slot = |slot: Slot| if slot < from { slot } else { slot + by };
        let term = |term: Term| match term {
            Term::Variable(variable) => Term::Variable(slot(variable)),
            constant @ Term::Constant(_) => constant,
        };
        let all = |parts: Vec<Self>| parts.into_iter().map(|part| part.shifted(from, by)).collect();
        match self {
            Self::And(parts) => Self::And(all(parts)),
            Self::Or(parts) => Self::Or(all(parts)),
            Self::Forall(variable, kind, inner) => {
                Self::Forall(slot(variable), kind, Box::new(inner.shifted(from, by)))
            }
            Self::Exists(variable, kind, inner) => {
                Self::Exists(slot(variable), kind, Box::new(inner.shifted(from, by)))
            }
            Self::Atom { atom, holds, initially } => Self::Atom {
                atom: Atom {
                    predicate: atom.predicate,
                    terms: atom.terms.into_iter().map(term).collect(),
                },
                holds,
                initially,
            },
            Self::Equal { left, right, holds } => Self::Equal {
                left: term(left),
                right: term(right),
                holds,
            },
        }
    }

    /// Calls `visit` for every atom, with whether it must hold.
    pub fn for_each_atom(&self, visit: &mut impl FnMut(&Atom, bool)) {
        match self {
            Self::And(conditions) | Self::Or(conditions) => {
                conditions.iter().for_each(|c| c.for_each_atom(visit));
            }
            Self::Forall(_, _, inner) | Self::Exists(_, _, inner) => inner.for_each_atom(visit),
            Self::Atom { atom, holds, .. } => visit(atom, *holds),
            Self::Equal { .. } => {}
        }
    }
}

/// One atom that an action makes true or false, for every binding of `forall` under which `condition` held
/// before the action.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Effect {
    /// Quantified variables.
    pub forall: Vec<(Slot, TypeId)>,
    /// Asked of the state before the action.
    pub condition: Condition,
    /// What changes.
    pub atom: Atom,
    /// Whether it becomes true (`true`) or false.
    pub adds: bool,
}
