//! The paper's JSON for a plan.

use serde::{Deserialize, Serialize};

use super::Step;
use crate::domain::Domain;
use crate::goal::GoalFact;
use crate::verify::Ending;
use crate::world::{Environment, Fact, World};

/// A plan file: what the paper's model answers, and what `longstep plan --save` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanFile {
    /// The steps.
    pub task_cohesion: TaskCohesion,
    /// The world before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment_before: Option<Environment>,
    /// The world after: a claim until it has been simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment_after: Option<Environment>,
    /// The worlds after, where sensing decides which it is: then there is no single one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub endings: Vec<EndingFile>,
    /// What was asked for, in short.
    #[serde(default)]
    pub instruction_summary: String,
    /// What the planner asks back; empty when it understood.
    #[serde(default)]
    pub question: String,
}

/// A way in which a branching plan can end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EndingFile {
    /// What sensing told on the way, for example `expired(<spam>)`.
    pub when: Vec<String>,
    /// The world after.
    pub environment_after: Environment,
}

/// The environments that a plan leads to: the one after it, or each with what sensing tells on the way there.
pub(crate) fn endings(
    domain: &Domain,
    world: &World,
    endings: &[Ending],
    environment: impl Fn(&Ending) -> Environment,
) -> (Option<Environment>, Vec<EndingFile>) {
    if let [only] = endings {
        return (Some(environment(only)), Vec::new());
    }
    let when = |fact: &Fact| GoalFact::Plain(*fact).exact(domain, world);
    let file = |ending: &Ending| EndingFile {
        when: ending.when.iter().map(when).collect(),
        environment_after: environment(ending),
    };
    (None, endings.iter().map(file).collect())
}

/// The steps of a plan file.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TaskCohesion {
    /// Calls such as `grasp_object()`.
    #[serde(default)]
    pub task_sequence: Vec<String>,
    /// What each step does, in the same order.
    #[serde(default)]
    pub step_instructions: Vec<String>,
    /// The one thing that is manipulated, where calls do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object_name: Option<String>,
    /// The things that are manipulated, where there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub object_names: Vec<String>,
}

impl TaskCohesion {
    /// Writes steps the paper's way.
    pub fn new(domain: &Domain, world: &World, steps: &[Step]) -> Self {
        let mut objects: Vec<String> = Vec::new();
        for object in steps.iter().filter_map(|step| step.object(domain)) {
            let identifier = &world.entity(object).identifier;
            if !objects.contains(identifier) {
                objects.push(identifier.clone());
            }
        }
        let (object_name, object_names) = match objects.len() {
            0 => (None, Vec::new()),
            1 => (objects.pop(), Vec::new()),
            _ => (None, objects),
        };
        Self {
            task_sequence: steps.iter().map(|step| step.call(domain, world).to_string()).collect(),
            step_instructions: steps.iter().map(|step| step.explanation.clone()).collect(),
            object_name,
            object_names,
        }
    }

    /// The names under `object_name` and `object_names`.
    pub fn objects(&self) -> impl Iterator<Item = &str> {
        self.object_name.iter().chain(&self.object_names).map(String::as_str)
    }
}
