//! Changes of a plan that are plausible after an utterance.

use super::reference::References;
use crate::environment::{EntityId, State, World};
use crate::model::ActionId;
use crate::plan::{DraftStep, Plan, Step};
use crate::verify::{apply, can_apply, candidates, unmet};
use indexmap::IndexSet;
use longstep_core::model::Domain;
use rustc_hash::{FxBuildHasher, FxHashSet};

/// An action with the arguments of its call.
pub(super) type Called = (ActionId, Vec<Option<EntityId>>);

/// The changes that a model may write. Steps and positions count from 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Offers {
    /// True if the answer may be that the utterance concerns the goal.
    pub(super) goal: bool,
    /// Calls with the positions where they can be inserted.
    pub(super) inserts: Vec<(Called, Vec<usize>)>,
    pub(super) drops: Vec<usize>,
    pub(super) replaces: Vec<(usize, Vec<Called>)>,
    pub(super) moves: Vec<(usize, Vec<usize>)>,
}

/// Maximum number of listed calls; those about mentioned entities come first.
const LIMIT: usize = 240;

/// Maximum number of calls of one action, so that a world of hundreds of entities has a bound.
const WIDEST: usize = 4000;

/// Returns the changes of a plan that can be written: of every step, with every call about entities of the world. What the
/// person means is for the model to say; an utterance that contains a call cannot be about the goal.
pub(super) fn offers(world: &World, plan: &Plan, references: &References) -> Offers {
    let length = plan.steps().len();
    let calls = calls(world, plan, references);
    let replaces = plan.steps().iter().enumerate().map(|(step, own)| {
        let is_other = |(action, arguments): &&Called| !does(world.domain(), own, *action, arguments);
        let others: Vec<Called> = calls.iter().filter(is_other).cloned().collect();
        (step, others)
    });
    let moves = (0..length).map(|step| {
        let changes = |place: &usize| *place != step && *place != step + 1;
        (step, (0..=length).filter(changes).collect())
    });
    Offers {
        goal: references.actions.is_empty(),
        drops: (0..length).collect(),
        replaces: replaces
            .filter(|(_, others): &(_, Vec<_>)| !others.is_empty())
            .collect(),
        moves: moves.filter(|(_, places): &(_, Vec<_>)| !places.is_empty()).collect(),
        inserts: inserts(world, plan, &calls),
    }
}

/// Returns true if a step does a call: the same action with the arguments that a call shows.
pub(super) fn does(domain: &Domain, step: &Step, action: ActionId, arguments: &[Option<EntityId>]) -> bool {
    let mut shown = domain.action(action).explicit.iter();
    step.action == action && shown.all(|parameter| arguments[*parameter] == Some(step.arguments[*parameter]))
}

/// Returns the calls of all actions, those about entities of the utterance first, then those about the plan's.
fn calls(world: &World, plan: &Plan, references: &References) -> Vec<Called> {
    let domain = world.domain();
    let shown = plan.steps().iter().flat_map(|step| {
        let explicit = domain.action(step.action).explicit.iter();
        explicit.map(|parameter| step.arguments[*parameter])
    });
    let others = world.entities().map(|(entity, _)| entity);
    let spoken = references.entities.iter().copied();
    let known: IndexSet<EntityId, FxBuildHasher> = spoken.chain(shown).chain(others).collect();
    let place = |entity: &EntityId| known.get_index_of(entity).unwrap_or(known.len());
    let mut calls: Vec<Called> = Vec::new();
    for (id, action) in domain.action_ids() {
        let mut all: Vec<Vec<Option<EntityId>>> = vec![vec![None; action.parameters.len()]];
        for parameter in &action.explicit {
            let kind = action.parameters[*parameter].kind;
            let fitting = known.iter().filter(|entity| world.is_of_kind(**entity, kind));
            let longer = |arguments: &Vec<Option<EntityId>>| {
                fitting
                    .clone()
                    .filter(|entity| !arguments.contains(&Some(**entity)))
                    .map(|entity| {
                        let mut arguments = arguments.clone();
                        arguments[*parameter] = Some(*entity);
                        arguments
                    })
                    .take(WIDEST)
                    .collect::<Vec<_>>()
            };
            all = all.iter().flat_map(longer).take(WIDEST).collect();
        }
        calls.extend(all.into_iter().map(|arguments| (id, arguments)));
    }
    // A call that can never be applicable is offered only if the utterance names its action.
    let possible = |(action, arguments): &Called| {
        let shown: Option<Vec<EntityId>> = arguments.iter().copied().collect();
        references.actions.contains(action) || shown.is_none_or(|shown| can_apply(world, *action, &shown))
    };
    if calls.iter().any(possible) {
        calls.retain(possible);
    }
    // The sum of its places: of two entities that are spoken of before one, and before those that nobody speaks of.
    calls.sort_by_key(|(_, arguments)| arguments.iter().flatten().map(place).sum::<usize>());
    calls.truncate(LIMIT);
    calls
}

/// Returns each call with the positions at which it can be done, or all positions if there are none.
fn inserts(world: &World, plan: &Plan, calls: &[Called]) -> Vec<(Called, Vec<usize>)> {
    let domain = world.domain();
    let length = plan.steps().len();
    let states = states(world, plan);
    let objects: Vec<EntityId> = plan.steps().iter().filter_map(|step| step.object(domain)).collect();
    let can_be_at = |call: &Called| -> Vec<usize> {
        let step = DraftStep {
            action: call.0,
            arguments: call.1.clone(),
            explanation: String::new(),
        };
        let choices = candidates(world, &step, &objects, &FxHashSet::default());
        let precondition = &domain.action(call.0).precondition;
        let can_be_done = |state: &State| {
            let done = |choice: &crate::verify::Candidate| {
                unmet(world, state, precondition, &mut choice.arguments.clone()).is_empty()
            };
            choices.iter().any(done)
        };
        (0..=length).filter(|at| can_be_done(&states[*at])).collect()
    };
    let place = |call: &Called| match can_be_at(call) {
        none if none.is_empty() => (0..=length).collect(),
        possible => possible,
    };
    calls.iter().map(|call| (call.clone(), place(call))).collect()
}

/// Returns the state before each step and after the last.
fn states(world: &World, plan: &Plan) -> Vec<State> {
    let mut states = vec![world.state.clone()];
    for step in plan.steps() {
        let mut state = states[states.len() - 1].clone();
        apply(world, &mut state, world.domain().action(step.action), &step.arguments);
        states.push(state);
    }
    states
}
