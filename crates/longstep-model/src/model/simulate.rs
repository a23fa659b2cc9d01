//! Simulation of one step: missing preconditions and effects.

use std::ops::ControlFlow;

use rustc_hash::FxHashSet;

use std::sync::Arc;

use super::{
    Action, Bindings, Change, Changes, Condition, Effect, EntityId, Fact, Fluent, GroundTest, Moment, Number,
    NumberChange, State, Term, World, assigned, for_candidates, for_matching, ground, holds,
};
use crate::effort;

/// A precondition that a step lacks.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Missing {
    /// The fact; none for a number, or if nothing could satisfy the precondition.
    pub fact: Option<Fact>,
    /// True if the fact must hold, false if it must not.
    pub holds: bool,
    /// The requirement on numbers; none for a fact.
    pub number: Option<Arc<Shortfall>>,
    /// The step that undid the precondition, counted from 0; none if no step did.
    pub undone_by: Option<usize>,
}

impl Missing {
    /// Returns true if no step can satisfy the precondition.
    pub fn is_impossible(&self) -> bool {
        self.fact.is_none() && self.number.is_none()
    }
}

/// A requirement on numbers that a state does not meet.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Shortfall {
    /// The requirement.
    pub test: GroundTest,
    /// The fluents in the requirement with their numbers in the state, in order; none for a fluent without a number.
    pub numbers: Vec<(Fluent, Option<Number>)>,
}

impl Shortfall {
    /// Records the requirement with the numbers of a state.
    pub fn of(test: GroundTest, state: &State) -> Self {
        let mut numbers = Vec::new();
        test.for_each(&mut |fluent| numbers.push((*fluent, state.number(*fluent))));
        numbers.sort_unstable();
        numbers.dedup();
        Self { test, numbers }
    }
}

/// Applies an action, applicable or not; returns the changes, sorted by fact and by fluent.
pub fn apply(world: &World, state: &mut State, action: &Action, arguments: &[EntityId]) -> Changes {
    let mut changes = Changes::default();
    apply_onto(
        world,
        state,
        action,
        &mut arguments.to_vec(),
        &mut Vec::new(),
        &mut changes,
    );
    changes
}

/// Like [`apply`], but appends to `changes` and reuses the buffers. `bindings` begins with the arguments.
pub fn apply_onto(
    world: &World,
    state: &mut State,
    action: &Action,
    bindings: &mut Bindings,
    fired: &mut Vec<(Fact, bool)>,
    changes: &mut Changes,
) {
    self::fired(world, state, action, bindings, fired);
    let numbers = assigned(world, state, &action.numeric, bindings);
    for (fact, holds) in fired.drain(..) {
        if state.set(fact, holds) {
            effort::spend(effort::KEPT);
            changes.facts.push(Change { fact, holds });
        }
    }
    for (fluent, after) in numbers {
        let before = state.number(fluent);
        if state.set_number(fluent, after) {
            effort::spend(effort::KEPT);
            changes.numbers.push(NumberChange { fluent, before, after });
        }
    }
}

/// Collects the facts that an action sets in a state, each with its new value, whether or not it changes.
pub fn fired(world: &World, state: &State, action: &Action, bindings: &mut Bindings, fired: &mut Vec<(Fact, bool)>) {
    fired.clear();
    for effect in &action.effects {
        fire(world, state, effect, 0, bindings, fired);
    }
    // Conditions were evaluated in the state before. A fact both added and deleted is added.
    fired.sort_unstable_by_key(|(fact, adds)| (*fact, !*adds));
    fired.dedup_by_key(|(fact, _)| *fact);
}

fn fire(
    world: &World,
    state: &State,
    effect: &Effect,
    depth: usize,
    bindings: &mut Bindings,
    fired: &mut Vec<(Fact, bool)>,
) {
    let Some((slot, kind)) = effect.forall.get(depth).copied() else {
        if holds(Moment { world, state }, &effect.condition, bindings) {
            effort::spend(1);
            fired.push((ground(&effect.atom, bindings), effect.adds));
        }
        return;
    };
    if !effect.adds && effect.atom.terms.contains(&Term::Variable(slot)) {
        // Only facts that hold can be deleted.
        let _ = for_matching(state, &effect.atom, slot, bindings, &mut |entity, bindings| {
            if world.is_of_kind(entity, kind) {
                bindings.push(entity);
                fire(world, state, effect, depth + 1, bindings, fired);
                bindings.pop();
            }
            ControlFlow::Continue(())
        });
        return;
    }
    let moment = Moment { world, state };
    let _ = for_candidates(
        moment,
        (slot, kind),
        &effect.condition,
        true,
        bindings,
        &mut |bindings| {
            fire(world, state, effect, depth + 1, bindings, fired);
            ControlFlow::Continue(())
        },
    );
}

/// Returns the facts missing for a condition to hold: the shortest list that would satisfy it, the last one among
/// equally short ones. Empty if the condition holds.
pub fn unmet(world: &World, state: &State, condition: &Condition, bindings: &mut Bindings) -> Vec<Missing> {
    if holds(Moment { world, state }, condition, bindings) {
        return Vec::new();
    }
    let instances = |kind, inner: &Condition, bindings: &mut Bindings| -> Vec<Vec<Missing>> {
        let mut all = Vec::new();
        for entity in world.of_kind(kind) {
            // Charges a list per entity, which each enclosing quantifier copies.
            if !effort::spend(8 * effort::KEPT) {
                break;
            }
            bindings.push(*entity);
            all.push(unmet(world, state, inner, bindings));
            bindings.pop();
        }
        all
    };
    let mut missing: Vec<Missing> = match condition {
        Condition::And(all) => all
            .iter()
            .flat_map(|part| unmet(world, state, part, bindings))
            .collect(),
        Condition::Forall(_, kind, inner) => instances(*kind, inner, bindings).concat(),
        Condition::Or(any) => {
            let alternatives: Vec<_> = any.iter().map(|part| unmet(world, state, part, bindings)).collect();
            shortest(alternatives.into_iter().rev())
        }
        Condition::Exists(_, kind, inner) => shortest(instances(*kind, inner, bindings).into_iter()),
        Condition::Atom { atom, holds, .. } => vec![Missing {
            fact: Some(ground(atom, bindings)),
            holds: *holds,
            number: None,
            undone_by: None,
        }],
        // No step changes the past, nor a number that no action changes.
        Condition::Number(test) if test.fixed(Moment { world, state }, bindings).is_some() => Vec::new(),
        Condition::Number(test) => vec![Missing {
            fact: None,
            holds: true,
            number: Some(Arc::new(Shortfall::of(test.ground(world, bindings), state))),
            undone_by: None,
        }],
        // No step can make two entities equal.
        Condition::Equal { .. } => Vec::new(),
    };
    if missing.is_empty() {
        missing.push(Missing {
            fact: None,
            holds: false,
            number: None,
            undone_by: None,
        });
    }
    missing
}

/// Returns the alternative with the fewest missing facts; alternatives that no fact can satisfy come last.
fn shortest(alternatives: impl Iterator<Item = Vec<Missing>>) -> Vec<Missing> {
    let length = |missing: &Vec<Missing>| {
        let impossible = missing.iter().filter(|missing| missing.is_impossible()).count();
        (impossible, missing.len())
    };
    alternatives.min_by_key(length).unwrap_or_default()
}

/// Adds to `rested` the facts that satisfy the condition, were assumed in the initial state and are not `touched`
/// since.
pub fn rests_on(
    moment: Moment<'_>,
    condition: &Condition,
    bindings: &mut Bindings,
    touched: &dyn Fn(Fact) -> bool,
    rested: &mut FxHashSet<Fact>,
) {
    match condition {
        Condition::And(parts) => parts
            .iter()
            .for_each(|part| rests_on(moment, part, bindings, touched, rested)),
        // Only the first alternative that holds counts.
        Condition::Or(parts) => {
            let holding = parts.iter().find(|part| holds(moment, part, bindings));
            holding
                .into_iter()
                .for_each(|part| rests_on(moment, part, bindings, touched, rested));
        }
        // A universal condition without positive atoms cannot rest on an assumed fact.
        Condition::Forall(_, _, inner) if !has_positive_atom(inner) => {}
        Condition::Forall(_, kind, inner) | Condition::Exists(_, kind, inner) => {
            let all = matches!(condition, Condition::Forall(..));
            for entity in moment.world.of_kind(*kind) {
                if !effort::spend(1) {
                    break;
                }
                bindings.push(*entity);
                let counts = all || holds(moment, inner, bindings);
                if counts {
                    rests_on(moment, inner, bindings, touched, rested);
                }
                bindings.pop();
                if counts && !all {
                    break;
                }
            }
        }
        Condition::Atom { atom, holds: true, .. } => {
            let fact = ground(atom, bindings);
            if moment.world.assumed(fact).is_some() && !rested.contains(&fact) && !touched(fact) {
                rested.insert(fact);
            }
        }
        Condition::Atom { .. } | Condition::Equal { .. } | Condition::Number(_) => {}
    }
}

/// Returns true if the condition has a positive atom.
fn has_positive_atom(condition: &Condition) -> bool {
    matches!(condition, Condition::Atom { holds: true, .. }) || condition.parts().iter().any(has_positive_atom)
}
