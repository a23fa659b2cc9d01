//! What plans of a domain can have besides steps in a row: branches and loops where it senses, lanes where it has actors.

use crate::environment::{EntityId, World};
use crate::model::Domain;

/// Whether some action tells what nobody knows yet, so that a plan can branch on it.
pub(crate) fn senses(domain: &Domain) -> bool {
    domain.actions.iter().any(|action| !action.senses.is_empty())
}

/// Whether calls name who does them, so that there can be lanes.
pub(super) fn acts(domain: &Domain) -> bool {
    domain.actions.iter().any(|action| action.actor.is_some())
}

/// Whether plans of the domain are written as trees. Where neither branches nor lanes are possible, they are lists.
pub(super) fn has_trees(domain: &Domain) -> bool {
    senses(domain) || acts(domain)
}

/// The hands, arms or robots of a world, in its order; none where no action says who does it.
pub(crate) fn actors(domain: &Domain, world: &World) -> Vec<EntityId> {
    let kinds = domain.actions.iter().filter_map(|action| {
        let actor = action.actor?;
        Some(action.parameters[actor].kind)
    });
    let mut all: Vec<EntityId> = kinds.flat_map(|kind| world.of_kind(kind)).copied().collect();
    all.sort_unstable();
    all.dedup();
    all
}
