//! Changes of a plan that are plausible after an utterance.

use super::reference::References;
use crate::environment::{EntityId, State, World};
use crate::model::ActionId;
use crate::plan::{DraftStep, Plan};
use crate::verify::{apply, can_apply, candidates, unmet};

/// An action with the arguments of its call.
pub(super) type Called = (ActionId, Vec<Option<EntityId>>);

/// The changes that a model may write. Steps and positions count from 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Offers {
    /// True if the answer may be that the utterance concerns the goal.
    pub(super) goal: bool,
    /// True if the answer may be a question.
    pub(super) question: bool,
    /// Calls with the positions where they can be inserted.
    pub(super) inserts: Vec<(Called, Vec<usize>)>,
    pub(super) drops: Vec<usize>,
    pub(super) replaces: Vec<(usize, Vec<Called>)>,
    pub(super) moves: Vec<(usize, Vec<usize>)>,
    /// True if the answer may contain several changes.
    pub(super) several: bool,
}

/// Maximum number of listed calls; those about mentioned entities come first.
const LIMIT: usize = 240;

/// Returns the changes that fit the references in the utterance: calls, step numbers and entities. An insertion is
/// offered where its action is applicable in the current plan, unless the utterance gives a position or no position
/// fits.
pub(super) fn offers(world: &World, plan: &Plan, references: &References, several: bool) -> Offers {
    let length = plan.steps().len();
    if references.corrects && references.verbs.is_empty() && !references.is_about_steps() {
        return Offers {
            goal: true,
            question: true,
            ..Offers::default()
        };
    }
    let asks =
        |verb: &str| !references.is_about_steps() || references.verbs.is_empty() || references.verbs.contains(&verb);
    let mut offers = Offers {
        goal: !references.is_about_steps(),
        question: !references.is_about_steps() || references.verbs.is_empty(),
        several,
        ..Offers::default()
    };
    let calls = calls(world, plan, references);
    // Moving or removing steps cannot involve an entity that the plan does not mention.
    let in_plan = |thing: &EntityId| plan.steps().iter().any(|step| step.arguments.contains(thing));
    let brings_in =
        !references.is_about_steps() && !references.verbs.contains(&"drop") && !references.entities.iter().all(in_plan);
    if asks("insert") {
        offers.inserts = inserts(world, plan, references, &calls);
    }
    let meant = meant_steps(plan, references);
    if asks("drop") && !brings_in {
        offers.drops.clone_from(&meant);
    }
    if asks("replace") {
        for step in &meant {
            let own = &plan.steps()[*step];
            let same = |(action, arguments): &&Called| {
                let shown = world.domain().action(own.action).explicit.iter();
                *action == own.action && shown.clone().all(|p| arguments[*p] == Some(own.arguments[*p]))
            };
            let others: Vec<Called> = calls.iter().filter(|call| !same(call)).cloned().collect();
            if !others.is_empty() {
                offers.replaces.push((*step, others));
            }
        }
    }
    if asks("move") && !brings_in {
        let near: Vec<usize> = references.steps.iter().flat_map(|step| [*step, *step + 1]).collect();
        for step in &meant {
            let changes = |place: &usize| *place != *step && *place != *step + 1;
            let all: Vec<usize> = (0..=length).filter(changes).collect();
            let placed: Vec<usize> = all
                .iter()
                .copied()
                .filter(|at| references.places.contains(at))
                .collect();
            let beside: Vec<usize> = all.iter().copied().filter(|at| near.contains(at)).collect();
            let ways = match references.places.is_empty() {
                true => vec![beside, all],
                false => vec![placed],
            };
            let places = ways.into_iter().find(|places| !places.is_empty());
            offers.moves.extend(places.map(|places| (*step, places)));
        }
    }
    let nothing = offers.inserts.is_empty() && offers.drops.is_empty() && offers.replaces.is_empty();
    offers.question |= nothing && offers.moves.is_empty();
    offers
}

/// Returns the steps that the utterance can mean: by number, else by call, and of these the ones with the most shared
/// words.
fn meant_steps(plan: &Plan, references: &References) -> Vec<usize> {
    if !references.steps.is_empty() {
        return references.steps.clone();
    }
    let all = 0..plan.steps().len();
    let called = |step: &usize| references.actions.contains(&plan.steps()[*step].action);
    let mut meant: Vec<usize> = match all.clone().any(|step| called(&step)) {
        true => all.filter(called).collect(),
        false => all.collect(),
    };
    let most = meant.iter().map(|step| references.likeness[*step]).max().unwrap_or(0);
    meant.retain(|step| references.likeness[*step] == most);
    meant
}

/// Returns the calls that the utterance can mean: of named actions, about entities of the utterance or the plan.
fn calls(world: &World, plan: &Plan, references: &References) -> Vec<Called> {
    let domain = world.domain();
    let mut pool = references.entities.clone();
    for step in plan.steps() {
        let shown = domain.action(step.action).explicit.iter();
        pool.extend(shown.map(|parameter| step.arguments[*parameter]));
    }
    let mut known: Vec<EntityId> = Vec::new();
    for entity in pool {
        if !known.contains(&entity) {
            known.push(entity);
        }
    }
    let in_plan = |action: ActionId| plan.steps().iter().any(|step| step.action == action);
    let mut calls: Vec<Called> = Vec::new();
    for (id, action) in domain.action_ids() {
        if !references.actions.is_empty() && !references.actions.contains(&id) {
            // The utterance may name only the call to replace and not the new one.
            let only_old =
                references.verbs.contains(&"replace") && references.actions.iter().all(|action| in_plan(*action));
            if !only_old {
                continue;
            }
        }
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
                    .collect::<Vec<_>>()
            };
            all = all.iter().flat_map(longer).collect();
        }
        calls.extend(all.into_iter().map(|arguments| (id, arguments)));
    }
    let named = |(_, arguments): &Called| {
        arguments
            .iter()
            .flatten()
            .any(|thing| references.entities.contains(thing))
    };
    let shows_nothing = |(action, _): &Called| domain.action(*action).explicit.is_empty();
    if calls.iter().any(named) {
        calls.retain(|call| named(call) || shows_nothing(call));
    }
    // A call that can never be applicable is offered only if the utterance names its action.
    let possible = |(action, arguments): &Called| {
        let shown: Option<Vec<EntityId>> = arguments.iter().copied().collect();
        shown.is_none_or(|shown| can_apply(world, *action, &shown))
    };
    if references.actions.is_empty() && calls.iter().any(possible) {
        calls.retain(possible);
    }
    calls.truncate(LIMIT);
    calls
}

fn inserts(world: &World, plan: &Plan, references: &References, calls: &[Called]) -> Vec<(Called, Vec<usize>)> {
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
        let choices = candidates(world, &step, &objects, &rustc_hash::FxHashSet::default());
        let precondition = &domain.action(call.0).precondition;
        let can_be_done = |state: &State| {
            let done = |choice: &crate::verify::Candidate| {
                unmet(world, state, precondition, &mut choice.arguments.clone()).is_empty()
            };
            choices.iter().any(done)
        };
        (0..=length).filter(|at| can_be_done(&states[*at])).collect()
    };
    let place = |call: &Called| -> Vec<usize> {
        if !references.places.is_empty() {
            return references.places.clone();
        }
        if !references.steps.is_empty() && !references.verbs.contains(&"drop") {
            return references.steps.iter().flat_map(|step| [*step, *step + 1]).collect();
        }
        let possible = can_be_at(call);
        match possible.is_empty() {
            true => (0..=length).collect(),
            false => possible,
        }
    };
    let is_there = |(action, arguments): &&Called| {
        let shown = &domain.action(*action).explicit;
        let same = |step: &crate::plan::Step| {
            step.action == *action && shown.iter().all(|p| arguments[*p] == Some(step.arguments[*p]))
        };
        !shown.is_empty() && plan.steps().iter().any(same)
    };
    // A call that is already in the plan is inserted again only if the utterance asks for a repetition.
    let wanted: Vec<&Called> = calls
        .iter()
        .filter(|call| references.again || !is_there(call))
        .collect();
    // Without a named call, those that are applicable at the mentioned positions come first.
    let fits = |call: &&Called| {
        let possible = can_be_at(call);
        let there = possible
            .iter()
            .any(|at| references.places.is_empty() || references.places.contains(at));
        there || references.says_verb(domain, call.0)
    };
    let any_fits = references.actions.is_empty() && wanted.iter().any(fits);
    let wanted = wanted.into_iter().filter(|call| !any_fits || fits(call));
    wanted.map(|call| (call.clone(), place(call))).collect()
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
