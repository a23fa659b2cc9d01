//! Conditions and effects over variables, with names resolved.
//!
//! Code that visits conditions uses [`Condition::iter`], [`Condition::atoms`] and [`Condition::conjuncts`]. Evaluation and
//! grounding, which bind slots on the way, match on conditions themselves.

use super::{Application, EntityId, NumberTest, PredicateId, TypeId};

/// The index of a variable in the bindings: parameters first, then quantified variables, outermost first.
pub type Slot = usize;

/// An argument of an atom.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Term {
    /// A parameter or a quantified variable.
    Variable(Slot),
    /// A constant of the domain. Constants are the first entities of every world.
    Constant(EntityId),
}

/// A predicate applied to terms.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Atom {
    /// The predicate.
    pub predicate: PredicateId,
    /// The arguments.
    pub terms: Vec<Term>,
}

/// A condition in negation normal form: negation applies only to atoms and equalities.
///
/// Exhaustive on purpose: code that does not know a new condition would be wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Condition {
    /// Conjunction; true if empty.
    And(Vec<Condition>),
    /// Disjunction; false if empty.
    Or(Vec<Condition>),
    /// Universal quantifier over the entities of a type, bound to the slot.
    Forall(Slot, TypeId, Box<Condition>),
    /// Existential quantifier over the entities of a type, bound to the slot.
    Exists(Slot, TypeId, Box<Condition>),
    /// An atom or its negation.
    Atom {
        /// The atom.
        atom: Atom,
        /// True for the atom, false for its negation.
        holds: bool,
        /// The state in which it is evaluated.
        at: When,
    },
    /// An equality of two terms or its negation.
    Equal {
        /// The left side.
        left: Term,
        /// The right side.
        right: Term,
        /// True for equality, false for inequality.
        holds: bool,
    },
    /// A requirement on numbers.
    Number(NumberTest<Application>),
}

/// The state in which a fact or number of a condition is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum When {
    /// The state in which the condition is evaluated.
    Now,
    /// The one in which the plan, or what is left of it, begins: what others have changed is no change of the plan.
    Start,
    /// The one in which the instruction was given.
    Initially,
}

impl Condition {
    /// The condition that is always true.
    pub const TRUE: Condition = Condition::And(Vec::new());

    /// Returns the negation, in negation normal form.
    #[must_use]
    pub fn negated(self) -> Self {
        let all = |conditions: Vec<Condition>| conditions.into_iter().map(Self::negated).collect();
        match self {
            Self::And(conditions) => Self::Or(all(conditions)),
            Self::Or(conditions) => Self::And(all(conditions)),
            Self::Forall(slot, kind, inner) => Self::Exists(slot, kind, Box::new(inner.negated())),
            Self::Exists(slot, kind, inner) => Self::Forall(slot, kind, Box::new(inner.negated())),
            Self::Atom { atom, holds, at } => Self::Atom {
                atom,
                holds: !holds,
                at,
            },
            Self::Equal { left, right, holds } => Self::Equal {
                left,
                right,
                holds: !holds,
            },
            Self::Number(test) => Self::Number(test.negated()),
        }
    }

    /// Returns the condition that holds exactly where this one does not: unlike the [negation](Self::negated), it holds
    /// where a comparison fails because a number is unknown.
    #[must_use]
    pub fn complement(self) -> Self {
        self.negated().map(&|slot| slot, &|literal| match literal {
            Self::Number(NumberTest::Compare(left, comparison, right)) => {
                let unknown = [left.clone(), right.clone()].map(|side| NumberTest::Known(side, false));
                let compare = NumberTest::Compare(left, comparison, right);
                Self::Or([compare].into_iter().chain(unknown).map(Self::Number).collect())
            }
            other => other,
        })
    }

    /// Returns the condition with renumbered slots.
    #[must_use]
    pub fn with_slots(self, slot: &impl Fn(Slot) -> Slot) -> Self {
        let term = |term: Term| match term {
            Term::Variable(variable) => Term::Variable(slot(variable)),
            constant @ Term::Constant(_) => constant,
        };
        self.with_terms(slot, &term)
    }

    /// Returns the condition with the slots of its quantifiers renumbered, and other terms.
    pub(crate) fn with_terms(self, slot: &impl Fn(Slot) -> Slot, term: &impl Fn(Term) -> Term) -> Self {
        self.map(slot, &|literal| match literal {
            Self::Atom { mut atom, holds, at } => {
                atom.terms.iter_mut().for_each(|place| *place = term(*place));
                Self::Atom { atom, holds, at }
            }
            Self::Equal { left, right, holds } => Self::Equal {
                left: term(left),
                right: term(right),
                holds,
            },
            Self::Number(test) => Self::Number(test.with_terms(term)),
            other => other,
        })
    }

    /// Returns the condition with entities in place of its first slots; later slots move down.
    #[must_use]
    pub fn bound(self, entities: &[EntityId]) -> Self {
        let slot = |slot: Slot| slot.saturating_sub(entities.len());
        let term = |term: Term| match term {
            Term::Variable(variable) => match entities.get(variable) {
                Some(entity) => Term::Constant(*entity),
                None => Term::Variable(slot(variable)),
            },
            constant @ Term::Constant(_) => constant,
        };
        self.with_terms(&slot, &term)
    }

    /// Returns the condition, evaluated in the initial state.
    #[must_use]
    pub fn initially(self) -> Self {
        self.map(&|slot| slot, &|literal| match literal {
            Self::Atom { atom, holds, .. } => Self::Atom {
                atom,
                holds,
                at: When::Initially,
            },
            Self::Number(test) => Self::Number(test.initially()),
            other => other,
        })
    }

    /// Rebuilds the condition: replaces the slot of each quantifier, and each part without parts.
    fn map(self, slot: &impl Fn(Slot) -> Slot, literal: &impl Fn(Self) -> Self) -> Self {
        let all = |parts: Vec<Self>| parts.into_iter().map(|part| part.map(slot, literal)).collect();
        match self {
            Self::And(parts) => Self::And(all(parts)),
            Self::Or(parts) => Self::Or(all(parts)),
            Self::Forall(own, kind, inner) => Self::Forall(slot(own), kind, Box::new(inner.map(slot, literal))),
            Self::Exists(own, kind, inner) => Self::Exists(slot(own), kind, Box::new(inner.map(slot, literal))),
            other => literal(other),
        }
    }

    /// Returns the direct parts of the condition; atoms, equalities and requirements on numbers have none.
    pub fn parts(&self) -> &[Condition] {
        match self {
            Self::And(parts) | Self::Or(parts) => parts,
            Self::Forall(_, _, inner) | Self::Exists(_, _, inner) => std::slice::from_ref(inner),
            Self::Atom { .. } | Self::Equal { .. } | Self::Number(_) => &[],
        }
    }

    /// Iterates over the condition and everything inside it in preorder.
    pub fn iter(&self) -> impl Iterator<Item = &Condition> {
        let mut open = vec![self];
        std::iter::from_fn(move || {
            let next = open.pop()?;
            open.extend(next.parts().iter().rev());
            Some(next)
        })
    }

    /// Returns every atom, with `true` for a positive and `false` for a negated one.
    pub fn atoms(&self) -> impl Iterator<Item = (&Atom, bool)> {
        self.iter().filter_map(|part| match part {
            Self::Atom { atom, holds, .. } => Some((atom, *holds)),
            _ => None,
        })
    }

    /// Returns every requirement on numbers.
    pub fn numbers(&self) -> impl Iterator<Item = &NumberTest<Application>> {
        self.iter().filter_map(|part| match part {
            Self::Number(test) => Some(test),
            _ => None,
        })
    }

    /// Returns the conjuncts of the condition, through nested `and`s.
    pub fn conjuncts(&self) -> impl Iterator<Item = &Condition> {
        let mut open = vec![self];
        std::iter::from_fn(move || {
            loop {
                match open.pop()? {
                    Self::And(parts) => open.extend(parts.iter().rev()),
                    other => return Some(other),
                }
            }
        })
    }
}

/// An effect that makes one atom true or false, for every binding of `forall` under which `condition` held before the
/// action.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Effect {
    /// The quantified variables with their types.
    pub forall: Vec<(Slot, TypeId)>,
    /// The condition, evaluated in the state before the action.
    pub condition: Condition,
    /// The atom that changes.
    pub atom: Atom,
    /// True for an add effect, false for a delete effect.
    pub adds: bool,
}
