//! The form of a direct answer: as worked examples show it, and as the schema of a request demands it.

use indexmap::IndexMap;
use longstep_core::model::state_word;
use serde::Serialize;
use serde_json::{Value, json};

use super::forms::{actors, has_trees, senses};
use super::query::contained_json;
use super::tree_schema::{TreeForms, TreeSchema, closed, in_schema, tree_schema};
use crate::call::Call;
use crate::environment::{EntityId, Environment, World};
use crate::model::{Action, Domain, Term, TypeId};
use crate::plan::{PlanFile, TaskCohesion, write_tree};

/// A whole answer, every key there.
#[derive(Debug, Serialize)]
pub(super) struct AnswerText {
    task_cohesion: Cohesion,
    environment_before: StateLists,
    environment_after: StateLists,
    instruction_summary: String,
    question: String,
}

/// The steps, every key there: a list, or a tree in a domain whose plans can branch or have lanes.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Cohesion {
    List {
        task_sequence: Vec<String>,
        step_instructions: Vec<String>,
        object_name: Option<String>,
        object_names: Vec<String>,
    },
    Tree {
        task_tree: Value,
        object_name: Option<String>,
        object_names: Vec<String>,
    },
}

impl Cohesion {
    fn of(domain: &Domain, steps: &TaskCohesion) -> Self {
        // A step that is no call stays in its list: what somebody wrote is shown as it is.
        match steps.written() {
            Ok(written) if has_trees(domain) => {
                let mut objects: Vec<String> = steps.objects().map(str::to_owned).collect();
                let only = (objects.len() == 1).then(|| objects.pop()).flatten();
                Self::Tree {
                    task_tree: in_schema(&write_tree(&written), true),
                    object_name: only,
                    object_names: objects,
                }
            }
            _ => Self::List {
                task_sequence: steps.task_sequence.clone(),
                step_instructions: steps.step_instructions.clone(),
                object_name: steps.object_name.clone(),
                object_names: steps.object_names.clone(),
            },
        }
    }
}

/// An environment without what never changes, with a list of states for each thing.
#[derive(Debug, Serialize)]
pub(super) struct StateLists {
    assets: Vec<String>,
    asset_states: IndexMap<String, Vec<String>>,
    objects: Vec<String>,
    object_states: IndexMap<String, Vec<String>>,
}

impl StateLists {
    pub(super) fn of(environment: &Environment) -> Self {
        let both = [&environment.asset_states, &environment.object_states];
        let states = |identifiers: &[String]| {
            let entry = |identifier: &String| {
                let said = both.iter().filter_map(|states| states.get(identifier));
                (
                    identifier.clone(),
                    said.flat_map(|words| words.as_slice().to_vec()).collect(),
                )
            };
            identifiers.iter().map(entry).collect()
        };
        Self {
            asset_states: states(&environment.assets),
            object_states: states(&environment.objects),
            assets: environment.assets.clone(),
            objects: environment.objects.clone(),
        }
    }
}

impl AnswerText {
    pub(super) fn new(
        domain: &Domain,
        steps: &TaskCohesion,
        world: &World,
        after: StateLists,
        summary: &str,
        question: &str,
    ) -> Self {
        Self {
            task_cohesion: Cohesion::of(domain, steps),
            environment_before: StateLists::of(&world.environment),
            environment_after: after,
            instruction_summary: summary.to_owned(),
            question: question.to_owned(),
        }
    }
}

/// A plan as a model would have answered with it: in the form of the worked examples, and contained like them, since a
/// summary is what somebody typed.
pub(crate) fn answered(domain: &Domain, file: &PlanFile) -> String {
    let lists = |environment: &Option<Environment>| {
        let environment = environment.as_ref();
        environment.map_or_else(|| StateLists::of(&Environment::default()), StateLists::of)
    };
    contained_json(&AnswerText {
        task_cohesion: Cohesion::of(domain, &file.task_cohesion),
        environment_before: lists(&file.environment_before),
        environment_after: lists(&file.environment_after),
        instruction_summary: file.instruction_summary.clone(),
        question: file.question.clone(),
    })
}

/// Values in one enumeration at most, and properties of one schema.
const VALUES: usize = 500;
/// And how long all of them may be, in bytes.
const BYTES: usize = 12_000;

/// A JSON schema for an answer in this world: only the domain's calls, and an entry for each thing.
///
/// Every key is required and no other is allowed, as OpenAI's strict mode wants it. Calls are listed where they are few
/// enough, with their arguments of the right types. When there are too many things for a schema (some 150), entries may
/// have any names, which strict servers do not take: narrow the world first.
///
/// Where the domain senses or has actors, the steps are a tree: branches and loops are written out to a depth of two,
/// since strict servers take no schema that refers to itself.
///
/// ```
/// use longstep::{domain, json, dialogue, environment};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let environment = environment::Environment::from_json(r#"{"assets": ["<table>"], "objects": ["<cup>"]}"#).unwrap();
/// let world = environment::read(&household, &environment, "env.json", "", &json::Path::default()).unwrap();
/// let schema = dialogue::direct_schema(&household, &world);
/// let calls = &schema["properties"]["task_cohesion"]["properties"]["task_sequence"]["items"]["enum"];
/// assert_eq!(calls[0], "move_object()");
/// ```
pub fn direct_schema(domain: &Domain, world: &World) -> Value {
    let Environment { assets, objects, .. } = &world.environment;
    let listed = assets.len() + objects.len();
    let bytes: usize = assets.iter().chain(objects).map(String::len).sum();
    // Each thing has an entry before and after, and may be the object.
    let small = 3 * listed <= VALUES && 3 * bytes <= BYTES;
    let texts = json!({"type": "array", "items": {"type": "string"}});
    let call = match calls(domain, world, |_| true) {
        Some(calls) => json!({"type": "string", "enum": calls}),
        None => json!({"type": "string"}),
    };
    let identifier = |nullable: bool| {
        let kind = if nullable {
            json!(["string", "null"])
        } else {
            json!("string")
        };
        let mut all: Vec<Value> = assets.iter().chain(objects).map(|name| json!(name)).collect();
        if !small || all.is_empty() {
            return json!({"type": kind});
        }
        if nullable {
            all.push(Value::Null);
        }
        json!({"type": kind, "enum": all})
    };
    let states = |identifiers: &[String]| {
        if !small {
            return json!({"type": "object", "additionalProperties": texts});
        }
        let entries: Vec<(&str, Value)> = identifiers.iter().map(|name| (name.as_str(), texts.clone())).collect();
        closed(&entries)
    };
    let environment = closed(&[
        ("assets", texts.clone()),
        ("asset_states", states(assets)),
        ("objects", texts.clone()),
        ("object_states", states(objects)),
    ]);
    let tree = has_trees(domain).then(|| tree(domain, world));
    let steps = match &tree {
        Some(tree) => vec![("task_tree", tree.nodes.clone())],
        None => vec![
            ("task_sequence", json!({"type": "array", "items": call})),
            ("step_instructions", texts.clone()),
        ],
    };
    let handled = [
        ("object_name", identifier(true)),
        ("object_names", json!({"type": "array", "items": {"type": "string"}})),
    ];
    let mut schema = closed(&[
        ("task_cohesion", closed(&[&steps[..], &handled[..]].concat())),
        ("environment_before", environment.clone()),
        ("environment_after", environment),
        ("instruction_summary", json!({"type": "string"})),
        ("question", json!({"type": "string"})),
    ]);
    if let Some(tree) = tree {
        schema["$defs"] = tree.definitions;
    }
    schema
}

/// How deep branches and loops may stand in each other in an answer.
const DEPTH: usize = 2;

/// The steps of a domain that senses or has actors.
fn tree(domain: &Domain, world: &World) -> TreeSchema {
    let calls = calls(domain, world, |_| true);
    let senses = senses(domain);
    let asked = match senses {
        true => self::calls(domain, world, |action| !action.senses.is_empty())
            .and_then(|sensing| listed([sensing, told_states(domain, world)].concat())),
        false => Some(Vec::new()),
    };
    let lanes: Vec<String> = actors(domain, world)
        .into_iter()
        .map(|actor| world.entity(actor).identifier.clone())
        .collect();
    tree_schema(TreeForms {
        calls: calls.as_deref(),
        asked: asked.as_deref(),
        lanes: &lanes,
        loops: senses,
        explained: true,
        depth: DEPTH,
    })
}

/// The states that sensing can tell, as conditions ask them, of things of the right types.
fn told_states(domain: &Domain, world: &World) -> Vec<String> {
    let mut all = Vec::new();
    for outcome in domain.actions.iter().flat_map(|action| &action.senses) {
        let Some(word) = state_word(domain, outcome.predicate) else {
            continue;
        };
        // The thing in whose entry the state stands comes first.
        let slots = 0..=word.parameters.len();
        let kinds = slots.filter_map(|slot| {
            let place = word.atom.terms.iter().position(|term| *term == Term::Variable(slot))?;
            Some(domain.predicate(word.atom.predicate).parameters[place].kind)
        });
        let Some(choices) = choices(world, kinds) else { continue };
        all.extend(choices.into_iter().map(|arguments| written(&word.word, arguments)));
    }
    all
}

/// Every call that a plan can have here, arguments of the right types; none if there are too many.
fn calls(domain: &Domain, world: &World, wanted: impl Fn(&Action) -> bool) -> Option<Vec<String>> {
    let mut all = Vec::new();
    for action in domain.actions.iter().filter(|action| wanted(action)) {
        let shown = action.explicit.iter();
        let choices = choices(world, shown.map(|parameter| action.parameters[*parameter].kind))?;
        all.extend(choices.into_iter().map(|arguments| written(&action.call, arguments)));
    }
    listed(all)
}

fn written(name: &str, arguments: Vec<String>) -> String {
    let name = name.to_owned();
    Call { name, arguments }.to_string()
}

/// Identifiers of these types, in every combination; none if there are too many.
fn choices(world: &World, kinds: impl Iterator<Item = TypeId>) -> Option<Vec<Vec<String>>> {
    let mut choices: Vec<Vec<String>> = vec![Vec::new()];
    for kind in kinds {
        let fitting = world.of_kind(kind);
        if choices.len() * fitting.len() > VALUES {
            return None;
        }
        let with = |given: &Vec<String>| {
            let longer = |entity: &EntityId| [&given[..], &[world.entity(*entity).identifier.clone()]].concat();
            fitting.iter().map(longer).collect::<Vec<_>>()
        };
        choices = choices.iter().flat_map(with).collect();
    }
    Some(choices)
}

/// The texts, if a server can be expected to take a list of them.
fn listed(mut all: Vec<String>) -> Option<Vec<String>> {
    // Two actions may be written alike.
    all.dedup();
    let bytes: usize = all.iter().map(String::len).sum();
    (!all.is_empty() && all.len() <= VALUES && bytes <= BYTES).then_some(all)
}
