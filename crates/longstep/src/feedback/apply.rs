//! Application of wishes to a plan, which gives a draft with pins.

use super::StepWish;
use super::difference::unwanted;
use crate::environment::{EntityId, World};
use crate::model::{ActionId, plain_words, singular};
use crate::plan::{DraftStep, Plan, Resolved, Step};
use crate::repair::Pins;

/// A draft after the wishes, not verified yet.
pub(super) struct Applied {
    pub(super) draft: Resolved,
    pub(super) pins: Pins,
}

/// Applies all wishes at once.
pub(super) fn apply(world: &World, plan: &Plan, wishes: &[StepWish]) -> Applied {
    let domain = world.domain();
    let steps = plan.steps();
    let mut applied = Applied {
        draft: Resolved::default(),
        pins: Pins::default(),
    };
    let drafted = &mut applied.draft.steps;
    let kept = &mut applied.pins.kept;
    let mut gone: Vec<(&Step, usize)> = Vec::new();
    let passed = |index: usize| {
        wishes.iter().any(|wish| match wish {
            StepWish::Move { step, before } => {
                (*step + 1..*before).contains(&index) || (*before..*step).contains(&index)
            }
            _ => false,
        })
    };
    for index in 0..=steps.len() {
        for wish in wishes.iter().filter(|wish| wish.before() == Some(index)) {
            kept.push(drafted.len());
            drafted.push(Some(match wish {
                StepWish::Insert {
                    action,
                    arguments,
                    explanation,
                    ..
                } => DraftStep {
                    action: *action,
                    arguments: arguments.clone(),
                    explanation: explanation.clone(),
                },
                other => (&steps[other.step().unwrap_or(index)]).into(),
            }));
        }
        let Some(step) = steps.get(index) else { break };
        match wishes.iter().find(|wish| wish.step() == Some(index)) {
            None => {
                // A step that another one was moved past is pinned; otherwise repair could undo the move.
                if passed(index) {
                    kept.push(drafted.len());
                }
                drafted.push(Some(step.into()));
            }
            Some(StepWish::Replace {
                action,
                arguments,
                explanation,
                ..
            }) => {
                gone.push((step, drafted.len()));
                kept.push(drafted.len());
                drafted.push(Some(DraftStep {
                    action: *action,
                    arguments: arguments.clone(),
                    explanation: explanation.clone(),
                }));
            }
            Some(_) => gone.push((step, drafted.len())),
        }
    }
    applied.pins.unwanted = unwanted(&gone, drafted);
    applied.draft.written = drafted
        .iter()
        .flatten()
        .map(|step| super::written(world, step.action, &step.arguments))
        .collect();
    let mut objects: Vec<EntityId> = steps.iter().filter_map(|step| step.object(domain)).collect();
    for step in drafted.iter().flatten() {
        objects.extend(
            domain
                .action(step.action)
                .object
                .and_then(|object| step.arguments[object]),
        );
    }
    for object in objects {
        if !applied.draft.objects.contains(&object) {
            applied.draft.objects.push(object);
        }
    }
    applied
}

/// Fills open arguments of the wishes from neighbouring steps: "another move_object()" has the object and the direction
/// of its neighbour, unless its explanation names another place.
pub(super) fn completed(world: &World, plan: &Plan, wishes: &[StepWish]) -> Vec<StepWish> {
    let mut wishes = wishes.to_vec();
    for wish in &mut wishes {
        let (at, own) = match wish {
            StepWish::Insert { before, .. } => (*before, None),
            StepWish::Replace { step, .. } => (*step + 1, plan.steps().get(*step)),
            _ => continue,
        };
        if let StepWish::Insert {
            action,
            arguments,
            explanation,
            ..
        }
        | StepWish::Replace {
            action,
            arguments,
            explanation,
            ..
        } = wish
        {
            complete(world, plan.steps(), at, own, *action, arguments, explanation);
        }
    }
    wishes
}

fn complete(
    world: &World,
    steps: &[Step],
    at: usize,
    own: Option<&Step>,
    action: ActionId,
    arguments: &mut [Option<EntityId>],
    explanation: &str,
) {
    let domain = world.domain();
    let (before, after) = steps.split_at(at.min(steps.len()));
    let around = || own.into_iter().chain(after).chain(before.iter().rev());
    let object = domain.action(action).object;
    if let Some(place) = object.filter(|place| arguments[*place].is_none()) {
        let kind = domain.action(action).parameters[place].kind;
        // The object of the previous steps comes first.
        let handled = own.into_iter().chain(before.iter().rev()).chain(after);
        let mut objects = handled.filter_map(|step| step.object(domain));
        arguments[place] = objects.find(|entity| world.is_of_kind(*entity, kind));
    }
    let agrees = |step: &&Step| {
        step.action == action
            && arguments
                .iter()
                .zip(&step.arguments)
                .all(|(known, other)| known.is_none_or(|known| known == *other))
    };
    let Some(like) = around().find(agrees) else { return };
    let words: Vec<String> = plain_words(explanation).iter().map(|word| singular(word)).collect();
    let handled: Vec<EntityId> = steps.iter().filter_map(|step| step.object(domain)).collect();
    let names_another = world
        .entities()
        .any(|(id, entity)| !handled.contains(&id) && entity.words_in(&words) > 0);
    if !names_another {
        for (known, other) in arguments.iter_mut().zip(&like.arguments) {
            known.get_or_insert(*other);
        }
    }
}

/// Opens the hidden arguments that no wish and no explanation names, so that binding can choose them again. Returns
/// none if there are none.
pub(super) fn reopened(world: &World, draft: &Resolved) -> Option<Resolved> {
    let mut draft = draft.clone();
    let mut any = false;
    for step in draft.steps.iter_mut().flatten() {
        let words: Vec<String> = plain_words(&step.explanation)
            .iter()
            .map(|word| singular(word))
            .collect();
        let action = world.domain().action(step.action);
        for parameter in action.implicit().filter(|parameter| action.object != Some(*parameter)) {
            let named = step.arguments[parameter].is_some_and(|entity| world.entity(entity).words_in(&words) > 0);
            if !named {
                any |= step.arguments[parameter].is_some();
                step.arguments[parameter] = None;
            }
        }
    }
    any.then_some(draft)
}
