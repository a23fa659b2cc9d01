//! The form of direct answers, in few-shot examples and in the request's schema.

use indexmap::IndexMap;
use serde::Serialize;
use serde_json::{Value, json};

use super::answer_grammar::{ENUM_BYTES, ENUM_LIMIT, any_text, closed, list, listed, one_of};
use super::forms::{actors, has_trees, senses};
use super::query::contained_json;
use super::tree_schema::{TreeForms, TreeSchema, in_schema, tree_schema};
use crate::call::Call;
use crate::environment::{EntityId, Environment, World};
use crate::model::{Action, TypeId};
use crate::plan::{PlanFile, TaskCohesion, write_tree};
use longstep_core::model::{Domain, state_word};

/// A whole answer with all keys.
#[derive(Debug, Serialize)]
pub(super) struct AnswerText {
    task_cohesion: Cohesion,
    environment_before: StateLists,
    environment_after: StateLists,
    instruction_summary: String,
    question: String,
}

/// The steps with all keys: a list, or a tree if the domain supports branches or lanes.
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
        // A step that is no call keeps the list form, so the plan appears as written.
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

/// An environment without properties, and with a list of states for each entity.
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
                let lists = both.iter().filter_map(|states| states.get(identifier));
                (
                    identifier.clone(),
                    lists.flat_map(|words| words.as_slice().to_vec()).collect(),
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
            environment_before: StateLists::of(world.environment()),
            environment_after: after,
            instruction_summary: summary.to_owned(),
            question: question.to_owned(),
        }
    }
}

/// Serializes a plan in the form of the few-shot examples. It is escaped, since its summary is user input.
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

/// Returns a JSON schema for a direct answer in this world: only calls of the domain, and an entry for each entity.
///
/// All keys are required and no others are allowed, as OpenAI's strict mode demands. Calls with well-typed arguments
/// are enumerated if they are few enough. With more than about 150 entities, the schema permits any entry name, which
/// strict servers reject: narrow the world first.
///
/// If the domain has sensing actions or actors, the steps are a tree. Branches and loops are expanded to depth two,
/// since strict servers reject recursive schemas.
///
/// ```
/// use longstep::{domain, dialogue};
/// use longstep_core::{json, environment};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let environment = environment::Environment::from_json(r#"{"assets": ["<table>"], "objects": ["<cup>"]}"#).unwrap();
/// let world = environment::read(&household, &environment, "env.json", "", &json::Path::default()).unwrap();
/// let schema = dialogue::direct_schema(&world);
/// let calls = &schema["properties"]["task_cohesion"]["properties"]["task_sequence"]["items"]["enum"];
/// assert_eq!(calls[0], "move_object()");
/// ```
pub fn direct_schema(world: &World) -> Value {
    let Environment { assets, objects, .. } = world.environment();
    let things = assets.len() + objects.len();
    let bytes: usize = assets.iter().chain(objects).map(String::len).sum();
    // Each entity has an entry before and after, and may be the object.
    let small = 3 * things <= ENUM_LIMIT && 3 * bytes <= ENUM_BYTES;
    let texts = list(any_text());
    let kind = json!(["string", "null"]);
    let object = if small && things > 0 {
        let names = assets.iter().chain(objects).map(|name| json!(name));
        json!({"type": kind, "enum": names.chain([Value::Null]).collect::<Value>()})
    } else {
        json!({"type": kind})
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
    let tree = has_trees(world.domain()).then(|| tree(world));
    let steps = match &tree {
        Some(tree) => vec![("task_tree", tree.nodes.clone())],
        None => vec![
            ("task_sequence", list(one_of(calls(world, |_| true).as_deref()))),
            ("step_instructions", texts.clone()),
        ],
    };
    let handled = [("object_name", object), ("object_names", texts.clone())];
    let mut schema = closed(&[
        ("task_cohesion", closed(&[&steps[..], &handled[..]].concat())),
        ("environment_before", environment.clone()),
        ("environment_after", environment),
        ("instruction_summary", any_text()),
        ("question", any_text()),
    ]);
    if let Some(tree) = tree {
        schema["$defs"] = tree.definitions;
    }
    schema
}

/// Maximum nesting of branches and loops in an answer.
const DEPTH: usize = 2;

/// Builds the tree schema for a domain with sensing actions or actors.
fn tree(world: &World) -> TreeSchema {
    let calls = calls(world, |_| true);
    let senses = senses(world.domain());
    let conditions = if senses {
        self::calls(world, |action| !action.senses.is_empty())
            .and_then(|sensing| listed_calls([sensing, sensed_states(world)].concat()))
    } else {
        Some(Vec::new())
    };
    let lanes: Vec<String> = actors(world)
        .into_iter()
        .map(|actor| world.entity(actor).identifier.clone())
        .collect();
    tree_schema(TreeForms {
        calls: calls.as_deref(),
        conditions: conditions.as_deref(),
        lanes: &lanes,
        loops: senses,
        explained: true,
        depth: DEPTH,
    })
}

/// Returns the sensed states in condition notation, with well-typed arguments.
fn sensed_states(world: &World) -> Vec<String> {
    let domain = world.domain();
    let mut all = Vec::new();
    for outcome in domain.actions.iter().flat_map(|action| &action.senses) {
        let Some(word) = state_word(domain, outcome.predicate) else {
            continue;
        };
        // The entity of the environment entry comes first.
        let parameters = &domain.predicate(word.atom.predicate).parameters;
        let kinds = word.places().flatten().map(|place| parameters[place].kind);
        let Some(choices) = choices(world, kinds) else { continue };
        all.extend(choices.into_iter().map(|arguments| written(&word.word, arguments)));
    }
    all
}

/// Returns every call with well-typed arguments, or none if there are too many.
fn calls(world: &World, wanted: impl Fn(&Action) -> bool) -> Option<Vec<String>> {
    let mut all = Vec::new();
    for action in world.domain().actions.iter().filter(|action| wanted(action)) {
        let shown = action.explicit.iter();
        let choices = choices(world, shown.map(|parameter| action.parameters[*parameter].kind))?;
        all.extend(choices.into_iter().map(|arguments| written(&action.call, arguments)));
    }
    listed_calls(all)
}

fn written(name: &str, arguments: Vec<String>) -> String {
    let name = name.to_owned();
    Call { name, arguments }.to_string()
}

/// Returns every combination of identifiers of these types, or none if there are too many.
fn choices(world: &World, kinds: impl Iterator<Item = TypeId>) -> Option<Vec<Vec<String>>> {
    let mut choices: Vec<Vec<String>> = vec![Vec::new()];
    for kind in kinds {
        let fitting = world.of_kind(kind);
        if choices.len() * fitting.len() > ENUM_LIMIT {
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

/// Returns the calls if servers can be expected to accept them as an enumeration.
fn listed_calls(mut all: Vec<String>) -> Option<Vec<String>> {
    // Two actions may have one notation.
    all.dedup();
    listed(all)
}
