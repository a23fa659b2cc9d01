//! The literals of an action: what it needs, what it makes true, and what it makes false.

use longstep::domain::{Action, Atom, Condition, Effect, Term, When};

/// The literals of an action that hold in every case: conjuncts of its precondition, and effects without a condition.
pub(super) struct ActionFacts<'a> {
    pub(super) action: &'a Action,
    /// Facts that have to be true before it.
    pub(super) needs: Vec<&'a Atom>,
    /// Facts that have to be false before it.
    pub(super) excludes: Vec<&'a Atom>,
    /// Facts that it makes true.
    pub(super) adds: Vec<&'a Atom>,
}

impl<'a> ActionFacts<'a> {
    pub(super) fn of(action: &'a Action) -> Self {
        let literals = |wanted: bool| {
            let literal = move |part: &'a Condition| match part {
                Condition::Atom { atom, holds, at } => (*holds == wanted && *at == When::Now).then_some(atom),
                _ => None,
            };
            action.precondition.conjuncts().filter_map(literal).collect()
        };
        Self {
            action,
            needs: literals(true),
            excludes: literals(false),
            adds: action
                .effects
                .iter()
                .filter(|effect| effect.adds && is_certain(effect))
                .map(|effect| &effect.atom)
                .collect(),
        }
    }

    /// Returns the name of the action.
    pub(super) fn name(&self) -> &'a str {
        &self.action.name
    }

    /// Returns true if an effect can make the fact false; conditional and universal effects count.
    pub(super) fn removes(&self, atom: &Atom) -> bool {
        self.effect_on(atom, false)
    }

    /// Returns true if an effect makes the fact true, or one that includes it.
    pub(super) fn makes(&self, atom: &Atom) -> bool {
        self.effect_on(atom, true)
    }

    fn effect_on(&self, atom: &Atom, adds: bool) -> bool {
        let mut effects = self.action.effects.iter().filter(|effect| effect.adds == adds);
        effects.any(|effect| covers(effect, atom))
    }

    /// Returns true if an effect makes a fact about the term true.
    pub(super) fn adds_about(&self, term: Term) -> bool {
        let mut effects = self.action.effects.iter().filter(|effect| effect.adds);
        effects.any(|effect| {
            let of_all = |own: &Term| is_quantified(effect, *own);
            effect.atom.terms.iter().any(|own| *own == term || of_all(own))
        })
    }

    /// Returns the parameters that occur in the atom.
    pub(super) fn parameters_of(&self, atom: &Atom) -> Vec<usize> {
        let slots = atom.terms.iter().filter_map(|term| match term {
            Term::Variable(slot) if *slot < self.action.parameters.len() => Some(*slot),
            _ => None,
        });
        slots.collect()
    }
}

/// Returns true for an effect without a condition and a quantifier.
pub(super) fn is_certain(effect: &Effect) -> bool {
    effect.forall.is_empty() && effect.condition == Condition::TRUE
}

pub(super) fn is_quantified(effect: &Effect, term: Term) -> bool {
    matches!(term, Term::Variable(slot) if effect.forall.iter().any(|(own, _)| *own == slot))
}

/// Returns true if the effect is about the atom, by name or as one of all.
fn covers(effect: &Effect, atom: &Atom) -> bool {
    let mut pairs = effect.atom.terms.iter().zip(&atom.terms);
    effect.atom.predicate == atom.predicate && pairs.all(|(own, term)| own == term || is_quantified(effect, *own))
}
