//! Plans: parsing of model replies and plan files, and resolution against a domain and a world.

pub mod behavior_tree;
pub(crate) mod claims;
mod condition_call;
mod fuzzy_names;
pub mod lanes;
mod outline;
mod paper;
mod read;
mod resolve;
pub mod script;
mod task_tree;
pub mod tree;
mod violation;
mod written;

pub use longstep_model::model::StepId;

/// The JSON Schema of a plan file.
pub const SCHEMA: &str = include_str!("plan.schema.json");

pub use outline::{OutlineLine, outline};
pub use paper::{ChoiceFile, EndingFile, PlanDomain, PlanFile, PurposeFile, TaskCohesion, endings};
pub use read::{Draft, Leniency, LeniencyKind, Unreadable, read};
pub use resolve::{DraftStep, Resolved, resolve};
pub use script::ScriptError;
pub use task_tree::{TreeError, read_tree, write_tree};
pub use tree::{Lane, LaneItem, Node, Test};
pub use violation::{Assumption, StepClaim, Violation};
pub use written::{Written, WrittenNode, WrittenStep};

use longstep_model::call::Call;
use longstep_model::model::{ActionId, Domain, EntityId, World};

/// One action with all its arguments and an explanation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// The action.
    pub action: ActionId,
    /// One entity for each parameter, including the implicit parameters that the call syntax omits.
    pub arguments: Vec<EntityId>,
    /// Explanation of the step for the user.
    pub explanation: String,
}

impl Step {
    /// Creates a step with the explanation that the domain defines for the action.
    pub fn explained(world: &World, action: ActionId, arguments: Vec<EntityId>) -> Self {
        let domain = world.domain();
        let explanation = domain
            .action(action)
            .says
            .fill(|parameter| world.with_article(arguments[parameter]));
        Self {
            action,
            arguments,
            explanation,
        }
    }

    /// Returns the call in plan notation, for example `PutIn(<pie>, <oven>)` or `grasp_object()`.
    pub fn call(&self, world: &World) -> Call {
        let domain = world.domain();
        let action = domain.action(self.action);
        let argument = |parameter: &usize| world.entity(self.arguments[*parameter]).identifier.clone();
        Call {
            name: action.call.clone(),
            arguments: action.explicit.iter().map(argument).collect(),
        }
    }

    /// Returns the hand, arm or robot that executes the step; none if the action has no actor parameter.
    pub fn actor(&self, domain: &Domain) -> Option<EntityId> {
        domain
            .action(self.action)
            .actor
            .map(|parameter| self.arguments[parameter])
    }

    /// Returns the entity that the paper calls `object_name`, if the action has one.
    pub fn object(&self, domain: &Domain) -> Option<EntityId> {
        domain
            .action(self.action)
            .object
            .map(|parameter| self.arguments[parameter])
    }
}

/// A plan: a flat list of steps and a tree of nodes over them. In a sequential plan, each node is one step.
///
/// Steps are numbered in reading order, whatever the shape of the tree, so that a finding can refer to "step 3".
///
/// ```
/// use longstep_verify::plan::{Node, Plan};
/// let plan = Plan::sequence(Vec::new());
/// assert!(plan.steps().is_empty() && plan.body().is_empty() && plan.is_sequence());
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Plan {
    steps: Vec<Step>,
    body: Vec<Node>,
}

impl Plan {
    /// Creates a sequential plan from the steps.
    pub fn sequence(steps: Vec<Step>) -> Self {
        let body = (0..steps.len()).map(|index| Node::Step(StepId::new(index))).collect();
        Self { steps, body }
    }

    /// Creates a plan with this tree. Returns none unless the tree contains every step once, in reading order, and is
    /// no deeper than [`tree::DEEPEST`].
    pub fn tree(steps: Vec<Step>, body: Vec<Node>) -> Option<Self> {
        tree::is_sound(&body, steps.len()).then_some(Self { steps, body })
    }

    /// All steps, in reading order.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Returns the step with this number. Panics if there is none.
    pub fn step(&self, id: StepId) -> &Step {
        &self.steps[id.index()]
    }

    /// The top-level nodes, in execution order.
    pub fn body(&self) -> &[Node] {
        &self.body
    }

    /// Returns the plan without this step; none if a condition contains the step.
    pub fn without(&self, step: StepId) -> Option<Self> {
        let body = tree::without(&self.body, step)?;
        let mut steps = self.steps.clone();
        steps.remove(step.index());
        Some(Self { steps, body })
    }

    /// Returns true for a sequential plan: every node is a step.
    pub fn is_sequence(&self) -> bool {
        self.body.iter().all(|node| matches!(node, Node::Step(_)))
    }
}

impl FromIterator<Step> for Plan {
    fn from_iter<I: IntoIterator<Item = Step>>(steps: I) -> Self {
        Self::sequence(steps.into_iter().collect())
    }
}
