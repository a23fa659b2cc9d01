//! What a repair leaves alone.

use crate::model::{ActionId, EntityId};
use crate::search::GroundAction;

/// What a person settled about a draft: repair works around it, and gives up rather than undo it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Pins {
    /// Steps of the draft, from 0, that may not be left out, done with another verb, or done later.
    pub kept: Vec<usize>,
    /// What may not be put in.
    pub unwanted: Vec<Unwanted>,
}

/// A step that somebody took out, and that is not to come back.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unwanted {
    /// What it did.
    pub action: ActionId,
    /// To what.
    pub arguments: Vec<EntityId>,
    /// Before which step of the draft it stood; the number of steps for the end.
    pub before: usize,
    /// How much of its kind is not wanted either.
    pub reach: Reach,
}

/// How far the wish reaches that a step should not be there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// Between these neighbours, nor anything else with the same effects. Elsewhere the plan has the same step still.
    Here,
    /// Anywhere, nor anything else with the same effects. The plan has the same action with other things still.
    ThisStep,
    /// The same, and the action whatever it is done to.
    ThisAction,
}

impl Unwanted {
    /// The step.
    pub(super) fn step(&self) -> GroundAction {
        GroundAction {
            action: self.action,
            arguments: self.arguments.clone(),
        }
    }

    /// Whether a step may not stand anywhere because of this.
    pub(super) fn forbids(&self, action: ActionId, arguments: &[EntityId]) -> bool {
        self.action == action
            && match self.reach {
                Reach::Here => false,
                Reach::ThisStep => self.arguments == arguments,
                Reach::ThisAction => true,
            }
    }
}
