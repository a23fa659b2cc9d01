//! A JSON schema for plan trees.

use serde_json::{Value, json};

use super::answer_grammar::{any_text, closed, list, one_of};

/// Elements that a plan tree may contain.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TreeForms<'a> {
    /// Calls that a step can be; none for any text, if there are too many to list.
    pub(crate) calls: Option<&'a [String]>,
    /// Calls that a condition can test: empty for no branches, none for any text.
    pub(crate) conditions: Option<&'a [String]>,
    /// Actors that can have a lane; empty for no lanes.
    pub(crate) lanes: &'a [String],
    /// True if loops are allowed besides branches.
    pub(crate) loops: bool,
    /// True if each step has an explanation.
    pub(crate) explained: bool,
    /// Maximum nesting of branches and loops. Strict servers reject recursive schemas, so each level has its own
    /// definition.
    pub(crate) depth: usize,
}

/// A schema for the list of nodes, with the definitions under `#/$defs/` that it refers to.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TreeSchema {
    pub(crate) nodes: Value,
    pub(crate) definitions: Value,
}

/// Builds the schema of a plan tree.
pub(crate) fn tree_schema(forms: TreeForms<'_>) -> TreeSchema {
    let branches = forms.conditions.is_none_or(|conditions| !conditions.is_empty());
    let mut definitions = serde_json::Map::new();
    let mut define = |name: &str, schema: Value| {
        definitions.insert(name.to_owned(), schema);
    };
    define("call", one_of(forms.calls));
    define(
        "step",
        if forms.explained {
            closed(&[("call", refer("call")), ("explanation", any_text())])
        } else {
            closed(&[("call", refer("call"))])
        },
    );
    if branches {
        define("asked", closed(&[("call", one_of(forms.conditions))]));
        let conditions = [refer("asked"), closed(&[("not", refer("asked"))])];
        define("condition", json!({"anyOf": conditions}));
    }
    // From the innermost level outwards.
    for level in (0..=forms.depth).rev() {
        let mut nodes = vec![refer("step")];
        if branches && level < forms.depth {
            let inner = list(refer(&format!("node{}", level + 1)));
            let condition = refer("condition");
            nodes.push(closed(&[
                ("if", condition.clone()),
                ("then", inner.clone()),
                ("else", inner.clone()),
            ]));
            if forms.loops {
                nodes.push(closed(&[("while", condition), ("do", inner)]));
            }
        }
        if level == 0 && forms.lanes.len() > 1 {
            let items = json!({"anyOf": [refer("step"), closed(&[("sync", any_text())])]});
            let lane = closed(&[("lane", one_of(Some(forms.lanes))), ("do", list(items))]);
            nodes.push(closed(&[("parallel", list(lane))]));
        }
        define(&format!("node{level}"), json!({"anyOf": nodes}));
    }
    TreeSchema {
        nodes: list(refer("node0")),
        definitions: Value::Object(definitions),
    }
}

fn refer(name: &str) -> Value {
    json!({"$ref": format!("#/$defs/{name}")})
}

/// Converts a tree of a plan file to the form of the schema: all keys present, remarks removed.
pub(crate) fn in_schema(tree: &Value, explained: bool) -> Value {
    let nodes = tree.as_array().map_or(&[][..], Vec::as_slice);
    let nodes = nodes.iter().filter(|node| node.get("remark").is_none());
    nodes.map(|node| node_in_schema(node, explained)).collect()
}

fn node_in_schema(node: &Value, explained: bool) -> Value {
    let part = |key: &str| in_schema(node.get(key).unwrap_or(&Value::Null), explained);
    if let Some(call) = node.get("call") {
        let explanation = node.get("explanation").cloned().unwrap_or_else(|| json!(""));
        return if explained {
            json!({"call": call, "explanation": explanation})
        } else {
            json!({"call": call})
        };
    }
    if let Some(condition) = node.get("if") {
        return json!({"if": condition_in_schema(condition), "then": part("then"), "else": part("else")});
    }
    if let Some(condition) = node.get("while") {
        return json!({"while": condition_in_schema(condition), "do": part("do")});
    }
    let Some(lanes) = node.get("parallel").and_then(Value::as_array) else {
        return node.clone();
    };
    let lane = |lane: &Value| {
        let items = in_schema(lane.get("do").unwrap_or(&Value::Null), explained);
        json!({"lane": lane.get("lane"), "do": items})
    };
    json!({"parallel": lanes.iter().map(lane).collect::<Value>()})
}

fn condition_in_schema(condition: &Value) -> Value {
    match (condition.get("call"), condition.get("not")) {
        (Some(call), _) => json!({"call": call}),
        (_, Some(inner)) => json!({"not": condition_in_schema(inner)}),
        _ => condition.clone(),
    }
}
