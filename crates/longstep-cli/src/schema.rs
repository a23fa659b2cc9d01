//! `longstep schema`: JSON Schemas of what the program reads and writes.

use anyhow::Result;
use longstep_core::diagnostic::nearest;
use longstep_core::{autonomy, plan, schema};
use longstep_robot::{RUN_LOG_SCHEMA, process, ros2};
use longstep_server::http::answer_schema;
use serde_json::{Map, Value};

use crate::failure::Failure;
use crate::output::{self, Style, print_line};
use crate::project;

/// A schema with its name, and the file or the output that it describes.
struct Entry {
    name: &'static str,
    about: &'static str,
    schema: fn() -> Value,
}

/// All schemas; those of files that people write come first.
const ENTRIES: [Entry; 17] = [
    entry("domain", "domain.toml: the words of a domain", schema::domain),
    entry(
        "environment",
        "an environment: the entities and their states",
        schema::environment,
    ),
    entry(
        "examples",
        "prompt/examples.toml: worked examples of goals",
        longstep::schema::examples,
    ),
    entry(
        "plans",
        "prompt/plans.toml: worked examples of whole plans",
        longstep::schema::plans,
    ),
    entry(
        "feedback",
        "prompt/feedback.toml: worked examples of feedback",
        longstep::schema::feedback,
    ),
    entry(
        "skills",
        "skills.toml: the skill parameters of a domain",
        schema::skills,
    ),
    entry(
        "answers",
        "answers.toml: answers of `domain new`",
        longstep_author::answers_schema,
    ),
    entry("suite", "suite.toml: a suite of `eval`", longstep_eval::suite::schema),
    entry("cases", "the cases of a suite", longstep_eval::suite::cases_schema),
    entry("ros2", "robot.toml: a robot in ROS 2", ros2::schema),
    entry("autonomy", "levels and limits, for `--autonomy`", autonomy::schema),
    entry("project", "longstep.toml: the options of a project", project::schema),
    entry("plan", "a plan file", || written(plan::SCHEMA)),
    entry(
        "answer",
        "what `plan`, `verify`, `repair` and `solve` print with `--json`",
        answer_schema,
    ),
    entry("error", "an error where the result is JSON", || {
        written(include_str!("error.schema.json"))
    }),
    entry("robot", "a message between Longstep and the program of a robot", || {
        written(process::SCHEMA)
    }),
    entry("run", "a line of the log of a run", || written(RUN_LOG_SCHEMA)),
];

const fn entry(name: &'static str, about: &'static str, schema: fn() -> Value) -> Entry {
    Entry { name, about, schema }
}

/// Reads a schema that is part of the program.
fn written(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_default()
}

/// Prints a schema, or the list of them.
pub(crate) fn run(name: Option<&str>) -> Result<u8> {
    match name {
        Some(name) => output::json(&named(name)?)?,
        None => {
            for Entry { name, about, .. } in ENTRIES {
                print_line!("{:12}  {about}", name.bold());
            }
        }
    }
    Ok(0)
}

/// Returns the schema with a name.
fn named(name: &str) -> Result<Value, Failure> {
    let names = || ENTRIES.iter().map(|entry| entry.name);
    let Some(entry) = ENTRIES.iter().find(|entry| entry.name == name) else {
        let hint = match nearest(name, names()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("the schemas are {}", names().collect::<Vec<_>>().join(", ")),
        };
        return Err(Failure::unreadable(format!("there is no schema `{name}`")).hint(hint));
    };
    Ok(with_id((entry.schema)(), name))
}

/// Gives a schema its address, and puts first what says which schema it is.
fn with_id(schema: Value, name: &str) -> Value {
    let Value::Object(mut rest) = schema else { return schema };
    let id = format!("https://github.com/longstep/longstep/schemas/{name}.schema.json");
    rest.insert("$id".to_owned(), id.into());
    let mut keys = Map::new();
    for key in ["$schema", "$id", "title", "description"] {
        keys.extend(rest.shift_remove(key).map(|value| (key.to_owned(), value)));
    }
    keys.append(&mut rest);
    Value::Object(keys)
}

/// Returns the file of a schema beside the files of a new domain, for editors.
pub(crate) fn beside(name: &str) -> Result<(String, String)> {
    let text = serde_json::to_string_pretty(&named(name)?)? + "\n";
    Ok((format!("schemas/{name}.schema.json"), text))
}
