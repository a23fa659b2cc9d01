//! One step: what it needs, and what it changes.

use super::violation::Missing;
use crate::domain::{Action, Condition, Effect};
use crate::world::{Bindings, Fact, FactSet, Moment, State, World, ground, holds};

/// A fact that a step made true or false.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// The fact.
    pub fact: Fact,
    /// Whether it holds now.
    pub holds: bool,
}

/// Applies an action, whether or not it is applicable; returns what changed, sorted by fact.
pub fn apply(world: &World, state: &mut State, action: &Action, arguments: &[crate::world::EntityId]) -> Vec<Change> {
    let mut fired: Vec<(Fact, bool)> = Vec::new();
    let mut bindings = arguments.to_vec();
    for effect in &action.effects {
        fire(world, state, effect, 0, &mut bindings, &mut fired);
    }
    // All conditions were asked of the state before; what is both taken away and given stays.
    let given: FactSet = fired.iter().filter(|(_, adds)| *adds).map(|(fact, _)| *fact).collect();
    let mut changes: Vec<Change> = fired
        .into_iter()
        .filter(|(fact, adds)| *adds || !given.contains(fact))
        .filter(|(fact, adds)| state.set(*fact, *adds))
        .map(|(fact, holds)| Change { fact, holds })
        .collect();
    changes.sort_unstable_by_key(|change| change.fact);
    changes
}

fn fire(
    world: &World,
    state: &State,
    effect: &Effect,
    depth: usize,
    bindings: &mut Bindings,
    fired: &mut Vec<(Fact, bool)>,
) {
    match effect.forall.get(depth) {
        Some((_, kind)) => {
            for entity in world.of_kind(*kind) {
                bindings.push(*entity);
                fire(world, state, effect, depth + 1, bindings, fired);
                bindings.pop();
            }
        }
        None => {
            if holds(Moment { world, state }, &effect.condition, bindings) {
                fired.push((ground(&effect.atom, bindings), effect.adds));
            }
        }
    }
}

/// What is missing for a condition to hold: the shortest list of facts that would make it hold, the last
/// written one of equally short ones. Empty if it holds.
pub fn unmet(world: &World, state: &State, condition: &Condition, bindings: &mut Bindings) -> Vec<Missing> {
    if holds(Moment { world, state }, condition, bindings) {
        return Vec::new();
    }
    let instances = |kind, inner: &Condition, bindings: &mut Bindings| -> Vec<Vec<Missing>> {
        let mut all = Vec::new();
        for entity in world.of_kind(kind) {
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
            undone_by: None,
        }],
        // Nothing that a step does makes two things one.
        Condition::Equal { .. } => Vec::new(),
    };
    if missing.is_empty() {
        missing.push(Missing {
            fact: None,
            holds: false,
            undone_by: None,
        });
    }
    missing
}

/// The alternative with the fewest facts missing; one that no fact can bring about comes last.
fn shortest(alternatives: impl Iterator<Item = Vec<Missing>>) -> Vec<Missing> {
    let length = |missing: &Vec<Missing>| {
        let impossible = missing.iter().filter(|m| m.fact.is_none()).count();
        (impossible, missing.len())
    };
    alternatives.min_by_key(length).unwrap_or_default()
}

/// Adds to `rested` the assumed facts that an applicable action's precondition looks at.
pub(super) fn rests_on(
    world: &World,
    state: &State,
    assumed: &FactSet,
    action: &Action,
    arguments: &[crate::world::EntityId],
    rested: &mut FactSet,
) {
    if !assumed.is_empty() {
        look(
            world,
            state,
            assumed,
            &action.precondition,
            &mut arguments.to_vec(),
            rested,
        );
    }
}

fn look(
    world: &World,
    state: &State,
    assumed: &FactSet,
    condition: &Condition,
    bindings: &mut Bindings,
    rested: &mut FactSet,
) {
    match condition {
        Condition::And(parts) => parts
            .iter()
            .for_each(|part| look(world, state, assumed, part, bindings, rested)),
        // Only what makes an alternative hold counts.
        Condition::Or(parts) => {
            let holding = parts.iter().find(|part| holds(Moment { world, state }, part, bindings));
            holding
                .into_iter()
                .for_each(|part| look(world, state, assumed, part, bindings, rested));
        }
        Condition::Forall(_, kind, inner) | Condition::Exists(_, kind, inner) => {
            let all = matches!(condition, Condition::Forall(..));
            for entity in world.of_kind(*kind) {
                bindings.push(*entity);
                let counts = all || holds(Moment { world, state }, inner, bindings);
                if counts {
                    look(world, state, assumed, inner, bindings, rested);
                }
                bindings.pop();
                if counts && !all {
                    break;
                }
            }
        }
        Condition::Atom { atom, holds: true, .. } => {
            let fact = ground(atom, bindings);
            if assumed.contains(&fact) {
                rested.insert(fact);
            }
        }
        Condition::Atom { .. } | Condition::Equal { .. } => {}
    }
}
