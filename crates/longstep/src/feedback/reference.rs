//! Calls and entities that an utterance about a plan names. Code reads nothing else in it.

use crate::environment::{EntityId, World};
use crate::instruction::Mentions;
use crate::model::ActionId;
use longstep_core::model::Domain;

/// The references in an utterance about a plan.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct References {
    /// Actions whose calls the utterance contains: such an utterance is about the steps.
    pub(super) actions: Vec<ActionId>,
    /// Mentioned entities.
    pub(super) entities: Vec<EntityId>,
}

impl References {
    /// Finds the references in an utterance.
    pub(super) fn of(world: &World, words: &str) -> Self {
        Self {
            actions: named_actions(world.domain(), words),
            entities: Mentions::of(world, words).entities,
        }
    }
}

/// Returns the actions whose calls cannot be ordinary words of the utterance: `move_object`, `open()`, `PutIn`.
fn named_actions(domain: &Domain, words: &str) -> Vec<ActionId> {
    let symbol = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    let lower = words.to_lowercase();
    let is_named = |call: &str| {
        let odd = call.contains('_') || call.chars().skip(1).any(char::is_uppercase);
        let call = call.to_lowercase();
        lower.match_indices(&call).any(|(at, _)| {
            let before = lower[..at].chars().next_back();
            let after = lower[at + call.len()..].chars().next();
            // Some languages write no spaces: a sign of another script ends a call.
            let ends = |c: Option<char>| !c.is_some_and(|c| symbol(c) && c.is_ascii());
            ends(before) && ends(after) && (odd || after == Some('('))
        })
    };
    let actions = domain.action_ids();
    actions
        .filter(|(_, action)| is_named(&action.call))
        .map(|(id, _)| id)
        .collect()
}
