//! Plans: a model's reply, the paper's JSON, and the same resolved against a domain and a world.

mod paper;
mod read;
mod resolve;

pub use paper::{PlanFile, TaskCohesion};
pub use read::{Draft, Leniency, LeniencyKind, Unreadable, read};
pub use resolve::{DraftStep, resolve};

use crate::call::Call;
use crate::domain::{ActionId, Domain};
use crate::world::{EntityId, World};

/// One action with all its arguments, and what it is for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// The action.
    pub action: ActionId,
    /// One entity for each parameter, those included that the call syntax hides.
    pub arguments: Vec<EntityId>,
    /// What the step does, for a person.
    pub explanation: String,
}

impl Step {
    /// The step with the explanation that the domain gives it.
    pub fn explained(domain: &Domain, world: &World, action: ActionId, arguments: Vec<EntityId>) -> Self {
        let explanation = domain
            .action(action)
            .says
            .fill(|parameter| world.entity(arguments[parameter]).with_article());
        Self {
            action,
            arguments,
            explanation,
        }
    }

    /// The step as a plan writes it, for example `PutIn(<pie>, <oven>)` or `grasp_object()`.
    pub fn call(&self, domain: &Domain, world: &World) -> Call {
        let action = domain.action(self.action);
        let argument = |parameter: &usize| world.entity(self.arguments[*parameter]).identifier.clone();
        Call {
            name: action.call.clone(),
            arguments: action.explicit.iter().map(argument).collect(),
        }
    }

    /// The entity that the paper's `object_name` speaks of, if the action has one.
    pub fn object(&self, domain: &Domain) -> Option<EntityId> {
        domain
            .action(self.action)
            .object
            .map(|parameter| self.arguments[parameter])
    }
}

/// Steps, one after the other.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Plan {
    /// The steps.
    pub steps: Vec<Step>,
}
