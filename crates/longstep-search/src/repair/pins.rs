//! Pins: constraints of the user on a repair.

use crate::search::GroundAction;
use longstep_model::model::{ActionId, EntityId};

/// Decisions of the user about a draft. Repair respects them, and fails if no repair does.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Pins {
    /// Steps of the draft, from 0, that must not be dropped, replaced or moved.
    pub kept: Vec<usize>,
    /// Steps that must not be inserted.
    pub unwanted: Vec<Unwanted>,
}

/// A step that the user removed and that must not return.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unwanted {
    /// Action of the step.
    pub action: ActionId,
    /// Arguments of the step.
    pub arguments: Vec<EntityId>,
    /// The step of the draft that followed it, from 0; the number of steps for the end.
    pub before: usize,
    /// Scope of the prohibition.
    pub reach: Reach,
}

/// Scope of the prohibition of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// This step, or a step with equal effects, at the old position; the step remains elsewhere in the plan.
    Here,
    /// This step, or a step with equal effects, anywhere; the action remains in the plan with other arguments.
    ThisStep,
    /// As [`Reach::ThisStep`], and the action with any arguments.
    ThisAction,
}

impl Unwanted {
    /// Returns the step.
    pub(super) fn step(&self) -> GroundAction {
        GroundAction {
            action: self.action,
            arguments: self.arguments.clone(),
        }
    }

    /// Returns true if the step is prohibited at every position.
    pub(super) fn forbids(&self, action: ActionId, arguments: &[EntityId]) -> bool {
        self.action == action
            && match self.reach {
                Reach::Here => false,
                Reach::ThisStep => self.arguments == arguments,
                Reach::ThisAction => true,
            }
    }
}
