//! Evaluation of conditions, and enumeration of the entities for which a condition can hold.

use std::ops::ControlFlow;

use super::{Atom, Condition, EntityId, Fact, Slot, State, Term, TypeId, When, World};
use crate::effort;

/// The entities bound to the slots of a condition.
pub type Bindings = Vec<EntityId>;

/// The current state and, in the world, the initial state of the instruction.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// The entities and their types.
    pub world: &'a World,
    /// The current state.
    pub state: &'a State,
}

/// Returns true if `condition` holds under `bindings`, which are unchanged afterwards.
///
/// Spends one unit for each part and for each entity that a quantifier tries; returns false if the budget is exhausted.
pub fn holds(moment: Moment<'_>, condition: &Condition, bindings: &mut Bindings) -> bool {
    match condition {
        Condition::And(all) => effort::spend(all.len()) && all.iter().all(|c| holds(moment, c, bindings)),
        Condition::Or(any) => effort::spend(any.len()) && any.iter().any(|c| holds(moment, c, bindings)),
        Condition::Forall(slot, kind, inner) => !some(moment, *slot, *kind, inner, false, bindings),
        Condition::Exists(slot, kind, inner) => some(moment, *slot, *kind, inner, true, bindings),
        Condition::Atom { atom, holds, at } => moment.state_of(*at).holds(ground(atom, bindings)) == *holds,
        Condition::Equal { left, right, holds } => {
            (grounded_term(*left, bindings) == grounded_term(*right, bindings)) == *holds
        }
        Condition::Number(test) => effort::spend(1) && test.holds_at(moment, bindings),
    }
}

/// Returns true if `inner` evaluates to `value` for some entity in the slot.
fn some(moment: Moment<'_>, slot: Slot, kind: TypeId, inner: &Condition, value: bool, bindings: &mut Bindings) -> bool {
    for_candidates(moment, (slot, kind), inner, value, bindings, &mut |bindings| {
        if holds(moment, inner, bindings) == value {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    })
    .is_break()
}

/// Calls `visit` with every entity of the type in the slot for which `condition` may evaluate to `value`.
///
/// Most conditions can have a value only where some fact holds: "nothing is in the hand" is false only for an object in
/// the hand. In that case only the entities of such facts are visited, some of them possibly twice.
pub fn for_candidates(
    moment: Moment<'_>,
    (slot, kind): (Slot, TypeId),
    condition: &Condition,
    value: bool,
    bindings: &mut Bindings,
    visit: &mut dyn FnMut(&mut Bindings) -> ControlFlow<()>,
) -> ControlFlow<()> {
    debug_assert_eq!(slot, bindings.len());
    let mut bind = |entity: EntityId, bindings: &mut Bindings| {
        if !effort::spend(1) {
            return ControlFlow::Break(());
        }
        bindings.push(entity);
        let flow = visit(bindings);
        bindings.pop();
        flow
    };
    if guarded(condition, value, slot, &any) {
        return for_guards(
            moment,
            slot,
            condition,
            value,
            &any,
            bindings,
            &mut |entity, bindings| {
                if moment.world.is_of_kind(entity, kind) {
                    bind(entity, bindings)
                } else {
                    ControlFlow::Continue(())
                }
            },
        );
    }
    moment
        .world
        .of_kind(kind)
        .iter()
        .try_for_each(|entity| bind(*entity, bindings))
}

/// Returns true if the facts of an atom, initial or current, may be relied on in every later state.
type Reliable<'a> = &'a dyn Fn(&Atom, When) -> bool;

/// Relies on all facts of the current state.
fn any(_: &Atom, _: When) -> bool {
    true
}

/// Returns the entities of the type for which the condition can ever evaluate to `value`, in order, judged by facts
/// that are reliable in every state. None if such facts do not restrict the entities.
pub fn ever_candidates(
    moment: Moment<'_>,
    (slot, kind): (Slot, TypeId),
    condition: &Condition,
    value: bool,
    bindings: &mut Bindings,
    reliable: Reliable<'_>,
) -> Option<Vec<EntityId>> {
    if !guarded(condition, value, slot, reliable) {
        return None;
    }
    let mut found = Vec::new();
    let _ = for_guards(moment, slot, condition, value, reliable, bindings, &mut |entity, _| {
        if moment.world.is_of_kind(entity, kind) {
            found.push(entity);
        }
        ControlFlow::Continue(())
    });
    found.sort_unstable();
    found.dedup();
    Some(found)
}

/// Returns true if the condition can evaluate to `value` only for entities in certain facts.
fn guarded(condition: &Condition, value: bool, slot: Slot, reliable: Reliable<'_>) -> bool {
    let part_guarded = |part: &Condition| guarded(part, value, slot, reliable);
    if let Condition::And(parts) | Condition::Or(parts) = condition {
        effort::spend(1 + parts.len() / 4);
    }
    match condition {
        Condition::And(parts) if value => parts.iter().any(part_guarded),
        Condition::Or(parts) if !value => parts.iter().any(part_guarded),
        Condition::And(parts) | Condition::Or(parts) => parts.iter().all(part_guarded),
        Condition::Exists(_, _, inner) if value => part_guarded(inner),
        Condition::Forall(_, _, inner) if !value => part_guarded(inner),
        Condition::Forall(..) | Condition::Exists(..) => false,
        Condition::Atom { atom, holds, at } => {
            *holds == value && atom.terms.contains(&Term::Variable(slot)) && reliable(atom, *at)
        }
        Condition::Equal { left, right, holds } => *holds == value && other_side(*left, *right, slot).is_some(),
        Condition::Number(_) => false,
    }
}

/// Returns the term that the slot must equal, if that term is bound before the slot.
fn other_side(left: Term, right: Term, slot: Slot) -> Option<Term> {
    let bound = |term: Term| match term {
        Term::Variable(other) => other < slot,
        Term::Constant(_) => true,
    };
    match (left, right) {
        (Term::Variable(variable), other) | (other, Term::Variable(variable)) if variable == slot && bound(other) => {
            Some(other)
        }
        _ => None,
    }
}

/// Visits the entities of the facts that guard the condition.
fn for_guards(
    moment: Moment<'_>,
    slot: Slot,
    condition: &Condition,
    value: bool,
    reliable: Reliable<'_>,
    bindings: &mut Bindings,
    visit: &mut dyn FnMut(EntityId, &mut Bindings) -> ControlFlow<()>,
) -> ControlFlow<()> {
    match condition {
        Condition::And(parts) | Condition::Or(parts) => {
            let one_is_enough = matches!(condition, Condition::And(_)) == value;
            let counts = |part: &&Condition| !one_is_enough || guarded(part, value, slot, reliable);
            for part in parts.iter().filter(counts) {
                for_guards(moment, slot, part, value, reliable, bindings, visit)?;
                if one_is_enough {
                    break;
                }
            }
            ControlFlow::Continue(())
        }
        Condition::Forall(_, _, inner) | Condition::Exists(_, _, inner) => {
            for_guards(moment, slot, inner, value, reliable, bindings, visit)
        }
        Condition::Equal { left, right, .. } => match other_side(*left, *right, slot) {
            Some(other) => visit(grounded_term(other, bindings), bindings),
            None => ControlFlow::Continue(()),
        },
        Condition::Atom { atom, at, .. } => for_matching(moment.state_of(*at), atom, slot, bindings, visit),
        // Never a guard.
        Condition::Number(_) => ControlFlow::Continue(()),
    }
}

/// Visits the entities that fill the slot in facts of the state that match the atom, given the bindings of the slots
/// before it. Visits none if the budget is exhausted.
pub fn for_matching(
    state: &State,
    atom: &Atom,
    slot: Slot,
    bindings: &mut Bindings,
    visit: &mut dyn FnMut(EntityId, &mut Bindings) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let known = |term: Term, bindings: &Bindings| match term {
        Term::Variable(variable) if variable >= slot => None,
        term => Some(grounded_term(term, bindings)),
    };
    let facts = match atom.terms.first().and_then(|term| known(*term, bindings)) {
        Some(first) => state.of_first(atom.predicate, first),
        None => state.of_predicate(atom.predicate),
    };
    if !effort::spend(1 + facts.len()) {
        return ControlFlow::Break(());
    }
    for fact in facts {
        let mut entity = None;
        let fits = atom.terms.iter().enumerate().all(|(place, term)| {
            let argument = fact.argument(place);
            match *term {
                Term::Variable(variable) if variable == slot => *entity.get_or_insert(argument) == argument,
                term => known(term, bindings).is_none_or(|known| known == argument),
            }
        });
        if let Some(entity) = entity.filter(|_| fits) {
            visit(entity, bindings)?;
        }
    }
    ControlFlow::Continue(())
}

impl<'a> Moment<'a> {
    pub(super) fn state_of(self, at: When) -> &'a State {
        self.world.past(at).unwrap_or(self.state)
    }
}

/// Returns the value of a static atom, an equality, or a requirement on numbers that never change, the same in every
/// state; none for any other condition.
pub fn static_value(world: &World, condition: &Condition, bindings: &[EntityId]) -> Option<bool> {
    match condition {
        Condition::Atom { atom, holds, at } => {
            let past = world.past(*at);
            let unchanging = past.is_some() || !world.domain().words(atom.predicate).fluent;
            let state = past.unwrap_or(&world.state);
            unchanging.then(|| state.holds(ground(atom, bindings)) == *holds)
        }
        Condition::Equal { left, right, holds } => {
            Some((grounded_term(*left, bindings) == grounded_term(*right, bindings)) == *holds)
        }
        Condition::Number(test) => test.fixed(
            Moment {
                world,
                state: &world.state,
            },
            bindings,
        ),
        _ => None,
    }
}

/// Binds open variables so that the atom is the fact; returns false if that is impossible. Variables without a place in
/// `bound` may be any entity.
pub fn unify(atom: &Atom, fact: Fact, bound: &mut [Option<EntityId>]) -> bool {
    atom.terms.iter().enumerate().all(|(place, term)| {
        let entity = fact.argument(place);
        match *term {
            Term::Constant(constant) => constant == entity,
            Term::Variable(slot) => bound
                .get_mut(slot)
                .is_none_or(|own| *own.get_or_insert(entity) == entity),
        }
    })
}

/// Returns the atom grounded with `bindings`.
pub fn ground(atom: &Atom, bindings: &[EntityId]) -> Fact {
    Fact::new(
        atom.predicate,
        atom.terms.iter().map(|term| grounded_term(*term, bindings)),
    )
}

/// Returns the entity of a term under `bindings`.
pub fn grounded_term(term: Term, bindings: &[EntityId]) -> EntityId {
    match term {
        Term::Variable(slot) => bindings[slot],
        Term::Constant(entity) => entity,
    }
}
