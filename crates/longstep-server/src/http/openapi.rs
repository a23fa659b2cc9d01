//! The description of the interface, from the table of its paths.

use axum::response::{IntoResponse, Response};
use serde_json::{Map, Value, json};

use super::reply::Reply;
use super::routes::{Route, routes};

/// The schemas of bodies and answers.
const SCHEMAS: &str = include_str!("schemas.json");

/// Returns the description as `OpenAPI` 3.1.
pub(crate) async fn description() -> Response {
    Reply(document()).into_response()
}

/// Returns the description as `OpenAPI` 3.1, for clients that are generated from it.
pub fn document() -> Value {
    let mut paths = Map::new();
    for route in routes() {
        let operations = paths.entry(route.path).or_insert_with(|| json!({}));
        operations[route.method] = operation(&route);
    }
    paths.insert("/api/events".to_owned(), json!({"get": events()}));
    paths.insert("/api/runs/{id}/mcap".to_owned(), json!({"get": recording()}));
    // The file is part of the program, and a test reads it.
    let schemas: Value = serde_json::from_str(SCHEMAS).unwrap_or_default();
    json!({
        "openapi": "3.1.0",
        "info": {
            "title": "Longstep",
            "version": env!("CARGO_PKG_VERSION"),
            "description": "Instructions to verified plans, approvals that are bound to one plan, and runs of robots.",
        },
        "security": [{"token": []}],
        "paths": paths,
        "components": {
            "schemas": schemas,
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}},
        },
    })
}

/// Returns the JSON Schema of the object that `plan`, `verify`, `repair` and `solve` print with `--json`.
///
/// ```
/// assert!(longstep_server::http::answer_schema()["properties"]["violations"].is_object());
/// ```
pub fn answer_schema() -> Value {
    let text = SCHEMAS.replace("#/components/schemas/", "#/$defs/");
    let mut all: Map<String, Value> = serde_json::from_str(&text).unwrap_or_default();
    let mut schema = all.shift_remove("Answer").unwrap_or_default();
    let mut wanted = references(&schema);
    let mut used = Map::new();
    while let Some(name) = wanted.pop() {
        if let Some(definition) = all.shift_remove(&name) {
            wanted.extend(references(&definition));
            used.insert(name, definition);
        }
    }
    used.sort_keys();
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("An answer of Longstep: the plan, its steps and what was found");
    schema["$defs"] = used.into();
    schema
}

/// Returns the names of the definitions to which a schema refers.
fn references(schema: &Value) -> Vec<String> {
    match schema {
        Value::Object(keys) => keys
            .iter()
            .flat_map(|(key, inner)| match (key.as_str(), inner.as_str()) {
                ("$ref", Some(path)) => vec![path.trim_start_matches("#/$defs/").to_owned()],
                _ => references(inner),
            })
            .collect(),
        Value::Array(items) => items.iter().flat_map(references).collect(),
        _ => Vec::new(),
    }
}

fn reference(name: &str) -> Value {
    json!({"$ref": format!("#/components/schemas/{name}")})
}

fn content(name: &str) -> Value {
    json!({"application/json": {"schema": reference(name)}})
}

fn operation(route: &Route) -> Value {
    let (status, answer) = route.answer;
    let mut responses = json!({
        "default": {"description": "The request is not fulfilled", "content": content("Error")},
    });
    responses[status.to_string()] = json!({"description": route.summary, "content": content(answer)});
    let is_say = ["instruct", "answer", "feedback"].contains(&route.name);
    if is_say {
        responses["202"] =
            json!({"description": "The model works; the session says when it is done", "content": content(answer)});
    }
    let mut operation = json!({
        "operationId": route.name,
        "summary": route.summary,
        "tags": [route.group()],
        "parameters": parameters(route.path, is_say),
        "responses": responses,
    });
    if let Some(body) = route.body {
        operation["requestBody"] = json!({"required": true, "content": content(body)});
    }
    operation
}

fn parameters(path: &str, is_say: bool) -> Value {
    let mut parameters = Vec::new();
    if path.contains("{id}") {
        parameters.push(json!({"name": "id", "in": "path", "required": true, "schema": {"type": "string"}}));
    }
    if is_say {
        parameters.push(json!({
            "name": "Prefer", "in": "header", "required": false,
            "description": "`respond-async`: do not wait for the model",
            "schema": {"type": "string"},
        }));
    }
    json!(parameters)
}

fn events() -> Value {
    let query = |name: &str, description: &str| json!({"name": name, "in": "query", "required": false, "description": description, "schema": {"type": "string"}});
    json!({
        "operationId": "events",
        "tags": ["server"],
        "summary": "The live stream as server-sent events: `happened` with a change, `reset` when states are to be read anew",
        "parameters": [
            query("session", "Only events of this session"),
            query("run", "Only events of this run"),
            query("after", "Events after this id; the header `Last-Event-ID` counts more"),
        ],
        "responses": {
            "200": {"description": "The stream", "content": {"text/event-stream": {"schema": {"type": "string"}}}},
            "default": {"description": "The request is not fulfilled", "content": content("Error")},
        },
    })
}

fn recording() -> Value {
    json!({
        "operationId": "get_recording",
        "summary": "A run as an MCAP file, as far as it went, for Foxglove and Lichtblick",
        "parameters": parameters("{id}", false),
        "responses": {
            "200": {"description": "The file", "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}}},
            "default": {"description": "The request is not fulfilled", "content": content("Error")},
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_schema_that_is_named_is_there_and_used() {
        let text = document().to_string();
        let document = document();
        let schemas = document["components"]["schemas"].as_object().unwrap();
        let named: std::collections::BTreeSet<&str> = text
            .split("#/components/schemas/")
            .skip(1)
            .filter_map(|rest| rest.split('"').next())
            .collect();
        let there: std::collections::BTreeSet<&str> = schemas.keys().map(String::as_str).collect();
        assert_eq!(named, there);
    }
}
