//! The parts that a composition may use: stored plans, sensing calls, and lanes.
//!
//! Which of them a person wants is for the model to say. Only where there are more than a request should list do the entities
//! that the instruction names select some.

use super::sensing::{Check, called, checks};
use super::{Recalled, Stored};
use crate::dialogue::actors;
use crate::environment::World;
use crate::instruction::Mentions;

/// Parts available to a composition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Menu {
    pub(super) plans: Vec<Offered>,
    pub(super) checks: Vec<Check>,
    /// Actors with a plan that fits a lane, in the order of the world. Empty if there are fewer than two.
    pub(super) lanes: Vec<String>,
}

/// A stored plan as listed in the prompt.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Offered {
    pub(super) name: String,
    pub(super) summary: String,
    /// Name of the only actor of the plan, if it fits a lane.
    pub(super) lane: Option<String>,
}

/// Number of stored plans from which only those about named entities are listed, if there are any.
const MANY_PLANS: usize = 16;

/// Maximum number of listed sensing calls. Each of them is a branch of the grammar inside the branches of all others.
const MOST_CHECKS: usize = 8;

impl Menu {
    pub(super) fn of(world: &World, stored: &[Stored], instruction: &str) -> Self {
        let domain = world.domain();
        let named = Mentions::of(world, instruction).entities;
        let recalled = stored.iter().map(|plan| (plan, Recalled::of(world, plan).ok()));
        let mut recalled: Vec<(&Stored, Option<Recalled>)> = recalled.collect();
        let is_meant = |(_, recalled): &(&Stored, Option<Recalled>)| {
            let items = recalled.iter().flat_map(|recalled| &recalled.handled);
            let mut items = items.filter_map(|identifier| world.find(identifier));
            items.any(|item| {
                let kind = world.entity(item).kind;
                domain.types.is_a(kind, domain.environment.object) && named.contains(&item)
            })
        };
        if recalled.len() > MANY_PLANS && recalled.iter().any(is_meant) {
            recalled.retain(is_meant);
        }
        let actors = actors(world);
        let lane = |recalled: &Recalled| match &recalled.actors[..] {
            [only] if !recalled.joint && recalled.written.is_sequence() => actors
                .iter()
                .map(|actor| world.entity(*actor))
                .find(|actor| actor.identifier == *only)
                .map(called),
            _ => None,
        };
        let plans: Vec<Offered> = recalled
            .iter()
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
        // Those about named entities, or else about what the plans handle: "if it has gone bad".
        let handled: Vec<_> = recalled.iter().filter_map(|(_, recalled)| recalled.as_ref()).collect();
        let handled = handled.iter().flat_map(|recalled| &recalled.handled);
        let handled: Vec<_> = handled.filter_map(|identifier| world.find(identifier)).collect();
        let about = |known: &[_]| {
            checks(world, |fact| {
                domain.arguments(fact).all(|entity| known.contains(&entity))
            })
        };
        let mut checks = about(&named);
        if checks.is_empty() {
            checks = about(&handled);
        }
        checks.truncate(MOST_CHECKS);
        Self { plans, checks, lanes }
    }
}
