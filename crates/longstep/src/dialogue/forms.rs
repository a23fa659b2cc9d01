//! Plan structures that a domain supports besides sequences: branches and loops with sensing actions, lanes with
//! actors.

use crate::environment::{EntityId, World};
use longstep_core::model::Domain;

/// Returns true if the domain has a sensing action, so that plans can branch.
pub(crate) fn senses(domain: &Domain) -> bool {
    domain.actions.iter().any(|action| !action.senses.is_empty())
}

/// Returns true if calls name their actors, so that plans can have lanes.
pub(super) fn acts(domain: &Domain) -> bool {
    domain.actions.iter().any(|action| action.actor.is_some())
}

/// Returns true if plans of the domain are written as trees. Without branches and lanes, they are lists.
pub(super) fn has_trees(domain: &Domain) -> bool {
    senses(domain) || acts(domain)
}

/// Returns the actors (hands, arms or robots) of a world, in its order; empty if no action names an actor.
pub(crate) fn actors(world: &World) -> Vec<EntityId> {
    let kinds = world.domain().actions.iter().filter_map(|action| {
        let actor = action.actor?;
        Some(action.parameters[actor].kind)
    });
    let mut all: Vec<EntityId> = kinds.flat_map(|kind| world.of_kind(kind)).copied().collect();
    all.sort_unstable();
    all.dedup();
    all
}
