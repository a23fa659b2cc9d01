//! Plans: a model's reply, the paper's JSON, and the same resolved against a domain and a world.

mod ask;
pub(crate) mod claims;
mod fuzzy_names;
mod outline;
mod paper;
mod read;
mod resolve;
pub mod script;
mod task_tree;
pub mod tree;
mod violation;
mod written;

pub use crate::model::StepId;
pub use outline::{OutlineLine, outline};
pub use paper::endings;
pub use paper::{EndingFile, PlanFile, TaskCohesion};
pub use read::{Draft, Leniency, LeniencyKind, Unreadable, read};
pub use resolve::{DraftStep, Resolved, resolve};
pub use script::ScriptError;
pub use task_tree::{TreeError, read_tree, write_tree};
pub use tree::{Lane, LaneItem, Node, Test};
pub use violation::{Assumption, StepClaim, Violation};
pub use written::{Written, WrittenNode, WrittenStep};

use crate::call::Call;
use crate::model::{ActionId, Domain, EntityId, World};

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

    /// The hand, arm or robot that does it, if it is one of several.
    pub fn actor(&self, domain: &Domain) -> Option<EntityId> {
        domain
            .action(self.action)
            .actor
            .map(|parameter| self.arguments[parameter])
    }

    /// The entity that the paper's `object_name` speaks of, if the action has one.
    pub fn object(&self, domain: &Domain) -> Option<EntityId> {
        domain
            .action(self.action)
            .object
            .map(|parameter| self.arguments[parameter])
    }
}

/// A plan is a tree of nodes over its steps; a plain list is a tree whose nodes are the steps in turn.
///
/// Steps are numbered in reading order, whatever the tree looks like, so that a finding can say "step 3".
///
/// ```
/// use longstep_core::plan::{Node, Plan};
/// let plan = Plan::sequence(Vec::new());
/// assert!(plan.steps().is_empty() && plan.body().is_empty() && plan.is_sequence());
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Plan {
    steps: Vec<Step>,
    body: Vec<Node>,
}

impl Plan {
    /// The plan that does the steps one after the other.
    pub fn sequence(steps: Vec<Step>) -> Self {
        let body = (0..steps.len()).map(|index| Node::Step(StepId::new(index))).collect();
        Self { steps, body }
    }

    /// The plan with this tree; none unless every step stands in it once, in reading order, and it is no deeper than
    /// [`tree::DEEPEST`].
    pub fn tree(steps: Vec<Step>, body: Vec<Node>) -> Option<Self> {
        tree::is_sound(&body, steps.len()).then_some(Self { steps, body })
    }

    /// Every step, in reading order.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// The step with this number.
    pub fn step(&self, id: StepId) -> &Step {
        &self.steps[id.index()]
    }

    /// The outermost nodes, in the order in which they are carried out.
    pub fn body(&self) -> &[Node] {
        &self.body
    }

    /// The plan without a step; none if a condition needs it.
    pub fn without(&self, step: StepId) -> Option<Self> {
        let body = tree::without(&self.body, step)?;
        let mut steps = self.steps.clone();
        steps.remove(step.index());
        Some(Self { steps, body })
    }

    /// Whether it is a plain list of steps.
    pub fn is_sequence(&self) -> bool {
        self.body.iter().all(|node| matches!(node, Node::Step(_)))
    }
}

impl FromIterator<Step> for Plan {
    fn from_iter<I: IntoIterator<Item = Step>>(steps: I) -> Self {
        Self::sequence(steps.into_iter().collect())
    }
}
