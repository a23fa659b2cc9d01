//! The paper's JSON format for plans.

use std::borrow::Cow;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

use super::{Node, Plan, StepId, Written, WrittenStep, read_tree, write_tree};
use longstep_model::call::{Call, NotACall};
use longstep_model::json::Path;
use longstep_model::model::{DomainData, Ending, Environment, Fact, Words, World, written_fact};

/// A plan file: the reply format of the paper's model, and the output of `longstep plan --save`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanFile {
    /// The steps.
    pub task_cohesion: TaskCohesion,
    /// The initial world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment_before: Option<Environment>,
    /// The final world. A claim until the plan is simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment_after: Option<Environment>,
    /// The possible final worlds with their conditions, if the final world depends on sensing. Then `environment_after`
    /// is none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub endings: Vec<EndingFile>,
    /// Short summary of the instruction.
    #[serde(default)]
    pub instruction_summary: String,
    /// Clarification question from the planner; empty if the instruction was clear.
    #[serde(default)]
    pub question: String,
    /// The words of the instruction that the plan does not say: a deadline, a manner, what was left out with consent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_in_plan: Vec<String>,
    /// The purpose for which the plan was made; none if it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub purpose: Option<PurposeFile>,
    /// The domain for which the plan was made; none if it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub domain: Option<PlanDomain>,
}

/// The domain for which a plan was made.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanDomain {
    /// Its name.
    pub name: String,
    /// The hash of its files, [`DomainData::hash`]; none if it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hash: Option<String>,
}

impl PlanDomain {
    /// Returns the mark of a domain.
    ///
    /// ```
    /// use longstep_model::domain;
    /// use longstep_verify::plan::PlanDomain;
    /// let household = domain::shipped("household").unwrap().unwrap();
    /// let mark = PlanDomain::of(&household);
    /// assert_eq!((mark.name.as_str(), mark.hash.map(|hash| hash.len())), ("household", Some(16)));
    /// ```
    pub fn of(domain: &DomainData) -> Self {
        Self {
            name: domain.name.clone(),
            hash: Some(domain.hash.clone()),
        }
    }
}

/// The purpose for which a plan was made, in the goal language, with identifiers of the environment.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PurposeFile {
    /// The goal, with its order, its constraints and its numbers: `put(<cup>, <shelf>) & never opened(<fridge>)`; none for a
    /// plan without a goal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal: Option<String>,
    /// The rules that were in force beside the goal: `untouched(<vase>)`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rules: Vec<String>,
    /// The goals that left a choice, with the choice of the plan.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<ChoiceFile>,
    /// The assumptions on which the plan rests, as sentences.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub assumptions: Vec<String>,
}

/// A goal that left a choice, and the choice of the plan.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChoiceFile {
    /// The goal: `put(any cup, <table>)`.
    pub goal: String,
    /// The goals that the plan achieves for it: `put(<cup_2>, <table>)`.
    pub chosen: Vec<String>,
}

impl PurposeFile {
    /// Returns the purpose of a plan for a goal, given by its parts, in a world with rules in force; none for a plan
    /// without a goal and without rules.
    ///
    /// ```
    /// use longstep_model::{domain, environment};
    /// use longstep_search::goal;
    /// use longstep_verify::plan::PurposeFile;
    /// let household = domain::shipped("household").unwrap().unwrap();
    /// let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#;
    /// let world = environment::parse(&household, "env.json", text).unwrap();
    /// let goal = goal::parse(&world, "put(cup, shelf)").unwrap();
    /// let purpose = PurposeFile::new(&world, &goal.exact(&world)).unwrap();
    /// assert_eq!(purpose.goal.as_deref(), Some("put(<cup>, <shelf>)"));
    /// assert_eq!(PurposeFile::new(&world, &[]), None);
    /// ```
    pub fn new(world: &World, goal: &[String]) -> Option<Self> {
        let rules = world.prohibitions().iter().filter(|own| own.standing);
        let purpose = Self {
            goal: (!goal.is_empty()).then(|| goal.join(" & ")),
            rules: rules.map(|own| own.written.clone()).collect(),
            ..Self::default()
        };
        (purpose != Self::default()).then_some(purpose)
    }
}

impl From<TaskCohesion> for PlanFile {
    /// Creates a plan file with these steps and no other content.
    fn from(task_cohesion: TaskCohesion) -> Self {
        Self {
            task_cohesion,
            environment_before: None,
            environment_after: None,
            endings: Vec::new(),
            instruction_summary: String::new(),
            question: String::new(),
            not_in_plan: Vec::new(),
            purpose: None,
            domain: None,
        }
    }
}

impl PlanFile {
    /// Returns the plan with the mark of the domain for which it was made.
    #[must_use]
    pub fn of_domain(self, domain: &DomainData) -> Self {
        Self {
            domain: Some(PlanDomain::of(domain)),
            ..self
        }
    }

    /// Returns the world with all values that the plan and its claim mention; borrowed if it has them.
    pub fn world_of<'w>(&self, world: &'w World) -> Cow<'w, World> {
        let mut own = Cow::Borrowed(world);
        if world.domain().values.is_empty() {
            return own;
        }
        let tree = self.task_cohesion.task_tree.iter().flat_map(|tree| &tree.steps);
        let steps = tree.flat_map(|step| {
            let implicit = step.implicit.iter().map(|(_, argument)| argument.clone());
            step.call.arguments.iter().cloned().chain(implicit)
        });
        let claims = self.environment_after.iter();
        let claims = claims.flat_map(|environment| [&environment.asset_states, &environment.object_states]);
        let claims = claims.flat_map(|states| states.values()).flat_map(Words::as_slice);
        let calls = self.task_cohesion.task_sequence.iter().chain(claims);
        let of_calls = calls
            .filter_map(|text| Call::parse(text).ok())
            .flat_map(|call| call.arguments);
        for argument in steps.chain(of_calls) {
            if let Some(Ok(value)) = world.domain().value(&argument) {
                own.to_mut().add_value(&value, &argument);
            }
        }
        own
    }
}

/// A possible ending of a branching plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EndingFile {
    /// The sensing outcomes that lead to this ending, for example `expired(<spam>)`.
    pub when: Vec<String>,
    /// The final world.
    pub environment_after: Environment,
}

/// Returns the final environments of a plan: a single one, or one for each ending with the sensing outcomes that lead
/// to it.
pub fn endings(
    world: &World,
    endings: &[Ending],
    environment: impl Fn(&Ending) -> Environment,
) -> (Option<Environment>, Vec<EndingFile>) {
    if let [only] = endings {
        return (Some(environment(only)), Vec::new());
    }
    let when = |fact: &Fact| written_fact(world.domain(), *fact, &|entity| world.entity(entity).identifier.clone());
    let file = |ending: &Ending| EndingFile {
        when: ending.when.iter().map(when).collect(),
        environment_after: environment(ending),
    };
    (None, endings.iter().map(file).collect())
}

/// The steps of a plan file: a list of calls, or a tree if the plan has branches, loops or parallel lanes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TaskCohesion {
    /// Calls such as `grasp_object()`; empty if there is a tree.
    pub task_sequence: Vec<String>,
    /// Explanation of each step, in the same order; empty if there is a tree.
    pub step_instructions: Vec<String>,
    /// The only manipulated object, for actions whose call syntax omits it.
    pub object_name: Option<String>,
    /// The manipulated objects, if there are several.
    pub object_names: Vec<String>,
    /// The plan as a tree; the objects listed in it count as [`TaskCohesion::object_names`].
    pub task_tree: Option<Written>,
}

/// JSON form of a list of steps.
#[derive(Serialize, Deserialize)]
struct FlatJson {
    #[serde(default)]
    task_sequence: Vec<String>,
    #[serde(default)]
    step_instructions: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    object_name: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    object_names: Vec<String>,
}

/// JSON form of a tree of steps.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TreeJson {
    task_tree: Value,
    #[serde(default, skip_serializing)]
    object_name: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    object_names: Vec<String>,
}

impl Serialize for TaskCohesion {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.task_tree {
            None => FlatJson {
                task_sequence: self.task_sequence.clone(),
                step_instructions: self.step_instructions.clone(),
                object_name: self.object_name.clone(),
                object_names: self.object_names.clone(),
            }
            .serialize(serializer),
            Some(tree) => TreeJson {
                task_tree: write_tree(tree),
                object_name: None,
                object_names: self.objects().map(str::to_owned).collect(),
            }
            .serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for TaskCohesion {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        if value.get("task_tree").is_none() {
            let flat: FlatJson = serde_json::from_value(value).map_err(D::Error::custom)?;
            return Ok(Self {
                task_sequence: flat.task_sequence,
                step_instructions: flat.step_instructions,
                object_name: flat.object_name,
                object_names: flat.object_names,
                task_tree: None,
            });
        }
        let tree: TreeJson = serde_json::from_value(value).map_err(D::Error::custom)?;
        let objects = tree.object_name.into_iter().chain(tree.object_names).collect();
        let path = Path::key("task_cohesion").push("task_tree");
        read_tree(&tree.task_tree, objects, &path)
            .map(Self::tree)
            .map_err(D::Error::custom)
    }
}

impl TaskCohesion {
    /// Converts a plan: a sequential plan to the paper's list, any other to a tree.
    pub fn new(world: &World, plan: &Plan) -> Self {
        if !plan.is_sequence() {
            return Self::tree(Written::of_plan(world, plan));
        }
        let steps = plan.steps();
        let mut objects: Vec<String> = Vec::new();
        for object in steps.iter().filter_map(|step| step.object(world.domain())) {
            let identifier = &world.entity(object).identifier;
            if !objects.contains(identifier) {
                objects.push(identifier.clone());
            }
        }
        Self {
            task_sequence: steps.iter().map(|step| step.call(world).to_string()).collect(),
            step_instructions: steps.iter().map(|step| step.explanation.clone()).collect(),
            ..Self::handling(objects)
        }
    }

    /// Converts a written plan. A sequential plan becomes a list and loses its remarks. A plan with named implicit
    /// parameters becomes a tree, since a list cannot express them.
    pub fn from_written(mut written: Written) -> Self {
        if !written.is_sequence() || written.steps.iter().any(|step| !step.implicit.is_empty()) {
            return Self::tree(written);
        }
        let explained = written.steps.iter().any(|step| !step.explanation.is_empty());
        let objects = std::mem::take(&mut written.objects);
        Self {
            task_sequence: written.steps.iter().map(|step| step.call.to_string()).collect(),
            step_instructions: if explained {
                written.steps.into_iter().map(|step| step.explanation).collect()
            } else {
                Vec::new()
            },
            ..Self::handling(objects)
        }
    }

    /// Converts the steps to a [`Written`] plan, the form that the other notations share.
    ///
    /// # Errors
    ///
    /// [`NotACall`] if a step of the list cannot be parsed as a call.
    pub fn written(&self) -> Result<Written, NotACall> {
        if let Some(tree) = &self.task_tree {
            return Ok(tree.clone());
        }
        let explained = self.step_instructions.len() == self.task_sequence.len();
        let step = |(index, text): (usize, &String)| {
            Ok(WrittenStep {
                call: Call::parse(text)?,
                implicit: Vec::new(),
                explanation: if explained {
                    self.step_instructions[index].clone()
                } else {
                    String::new()
                },
            })
        };
        let steps: Vec<WrittenStep> = self
            .task_sequence
            .iter()
            .enumerate()
            .map(step)
            .collect::<Result<_, _>>()?;
        let body = (0..steps.len()).map(|index| Node::Step(StepId::new(index))).collect();
        let objects = self.objects().map(str::to_owned).collect();
        Ok(Written { steps, body, objects })
    }

    /// Returns true if there are no steps.
    pub fn is_empty(&self) -> bool {
        self.task_sequence.is_empty() && self.task_tree.is_none()
    }

    fn tree(written: Written) -> Self {
        Self {
            task_tree: Some(written),
            ..Self::default()
        }
    }

    fn handling(mut objects: Vec<String>) -> Self {
        let (object_name, object_names) = match objects.len() {
            0 => (None, Vec::new()),
            1 => (objects.pop(), Vec::new()),
            _ => (None, objects),
        };
        Self {
            object_name,
            object_names,
            ..Self::default()
        }
    }

    /// The names in `object_name`, `object_names` and the tree.
    pub fn objects(&self) -> impl Iterator<Item = &str> {
        let of_tree = self.task_tree.iter().flat_map(|tree| &tree.objects);
        self.object_name
            .iter()
            .chain(&self.object_names)
            .chain(of_tree)
            .map(String::as_str)
    }
}
