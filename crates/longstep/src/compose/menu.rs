//! What a model may put together: the stored plans, what can be asked, and who can work side by side.

use super::asked::{Check, called, checks};
use super::{Recalled, Stored};
use crate::domain::{Domain, plain_words, singular};
use crate::prompt::actors;
use crate::world::{EntityId, World};

/// What a composition can be made of here.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Menu {
    pub(super) plans: Vec<Offered>,
    pub(super) checks: Vec<Check>,
    /// Who has a plan that fits into a lane, in the order of the world; empty if fewer than two have.
    pub(super) lanes: Vec<String>,
}

/// A stored plan as a model is offered it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Offered {
    pub(super) name: String,
    pub(super) summary: String,
    /// Whose lane it fits into.
    pub(super) lane: Option<String>,
}

impl Menu {
    pub(super) fn of(domain: &Domain, world: &World, stored: &[Stored], instruction: &str) -> Self {
        let recalled: Vec<Option<Recalled>> = stored
            .iter()
            .map(|plan| Recalled::of(domain, world, plan).ok())
            .collect();
        let actors = actors(domain, world);
        let lane = |recalled: &Recalled| match &recalled.actors[..] {
            [only] if !recalled.joint && recalled.written.is_sequence() => actors
                .iter()
                .map(|actor| world.entity(*actor))
                .find(|actor| actor.identifier == *only)
                .map(called),
            _ => None,
        };
        let plans: Vec<Offered> = stored
            .iter()
            .zip(&recalled)
            .map(|(plan, recalled)| Offered {
                name: plan.name.clone(),
                summary: plan.summary.clone(),
                lane: recalled.as_ref().and_then(lane),
            })
            .collect();
        let mut lanes: Vec<String> = actors.iter().map(|actor| called(world.entity(*actor))).collect();
        lanes.retain(|lane| plans.iter().any(|plan| plan.lane.as_ref() == Some(lane)));
        if lanes.len() < 2 {
            lanes.clear();
        }
        // A room has hundreds of things to look at: those that a plan handles or the person names are worth it.
        let words: Vec<String> = plain_words(instruction).iter().map(|word| singular(word)).collect();
        let handled: Vec<&String> = recalled.iter().flatten().flat_map(|plan| &plan.handled).collect();
        let worth = |id: EntityId| {
            let entity = world.entity(id);
            entity.words_in(&words) > 0 || handled.contains(&&entity.identifier)
        };
        Self {
            plans,
            checks: checks(domain, world, worth),
            lanes,
        }
    }
}
