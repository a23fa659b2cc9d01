//! JSON Schemas of the files that this crate reads.
//!
//! They come from the types that read the files, with the comments of their fields, so that an editor completes and
//! explains them. What a schema cannot say, such as that a predicate is declared, is found when the file is loaded.
//!
//! ```
//! let schema = longstep_model::schema::domain();
//! assert!(schema["properties"]["action"].is_object());
//! ```

use schemars::generate::SchemaSettings;
use schemars::transform::transform_subschemas;
use schemars::{JsonSchema, Schema};
use serde_json::{Value, json};

use crate::domain::words::{DomainFile, SkillsFile};
use crate::environment::Environment;

/// Returns the schema of a file that type `T` reads, in the draft that editors know.
pub fn of<T: JsonSchema>(title: &str) -> Value {
    let mut schema = SchemaSettings::draft07().into_generator().into_root_schema_for::<T>();
    without_null(&mut schema);
    schema.insert("title".to_owned(), json!(title));
    schema.to_value()
}

/// Removes the null of optional fields: a file leaves them out.
fn without_null(schema: &mut Schema) {
    if let Some(Value::Array(types)) = schema.get_mut("type") {
        types.retain(|name| name != "null");
        if let [one] = types.as_slice() {
            let one = one.clone();
            schema.insert("type".to_owned(), one);
        }
    }
    if let Some(Value::Array(choices)) = schema.get_mut("anyOf") {
        choices.retain(|choice| choice["type"] != "null");
        if let [one] = choices.as_slice() {
            let one = one.clone();
            schema.remove("anyOf");
            schema.insert("allOf".to_owned(), json!([one]));
        }
    }
    if schema.get("default").is_some_and(Value::is_null) {
        schema.remove("default");
    }
    transform_subschemas(&mut without_null, schema);
}

/// Returns the schema of `domain.toml`.
pub fn domain() -> Value {
    of::<DomainFile>("The words of a Longstep domain: domain.toml")
}

/// Returns the schema of `skills.toml`.
pub fn skills() -> Value {
    of::<SkillsFile>("The skill parameters of a Longstep domain: skills.toml")
}

/// Returns the schema of an environment.
pub fn environment() -> Value {
    of::<EnvironmentFile>("A Longstep environment: the entities and their states")
}

/// An environment, also inside `{"environment": ...}`.
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code)]
enum EnvironmentFile {
    Bare(Environment),
    Wrapped { environment: Environment },
}
