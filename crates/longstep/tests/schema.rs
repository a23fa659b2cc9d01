//! The published schema of a plan file says what the reader says.
#![allow(clippy::unwrap_used, clippy::panic)]

use longstep_core::plan::{self, PlanFile};
use serde_json::{Value, json};

/// The part of JSON Schema that `plan.schema.json` uses.
fn fits(root: &Value, schema: &Value, value: &Value) -> bool {
    let Value::Object(keywords) = schema else {
        return schema == &json!(true);
    };
    keywords.iter().all(|(keyword, rule)| match keyword.as_str() {
        "$ref" => fits(root, root.pointer(&rule.as_str().unwrap()[1..]).unwrap(), value),
        "oneOf" => {
            rule.as_array()
                .unwrap()
                .iter()
                .filter(|one| fits(root, one, value))
                .count()
                == 1
        }
        "type" => match rule.as_str().unwrap() {
            "object" => value.is_object(),
            "array" => value.is_array(),
            "string" => value.is_string(),
            "integer" => value.is_u64() || value.is_i64(),
            other => panic!("{other}"),
        },
        "required" => rule
            .as_array()
            .unwrap()
            .iter()
            .all(|key| value.get(key.as_str().unwrap()).is_some()),
        "properties" => value.as_object().is_none_or(|object| {
            object
                .iter()
                .all(|(key, inner)| rule.get(key).is_none_or(|schema| fits(root, schema, inner)))
        }),
        "additionalProperties" => value.as_object().is_none_or(|object| {
            let known = |key: &String| keywords.get("properties").is_some_and(|known| known.get(key).is_some());
            object.iter().all(|(key, inner)| known(key) || fits(root, rule, inner))
        }),
        "items" => value
            .as_array()
            .is_none_or(|items| items.iter().all(|item| fits(root, rule, item))),
        "minItems" => value
            .as_array()
            .is_none_or(|items| items.len() as u64 >= rule.as_u64().unwrap()),
        "minimum" => value.as_i64().is_none_or(|number| number >= rule.as_i64().unwrap()),
        "maximum" => value.as_u64().is_none_or(|number| number <= rule.as_u64().unwrap()),
        "title" | "description" | "$schema" | "$id" | "$defs" => true,
        other => panic!("{other}"),
    })
}

/// Every value that differs from this one in a single place: a part left out, put twice, or of another type.
fn variants(value: &Value) -> Vec<Value> {
    let mut all = vec![json!(7), json!("a()"), json!([]), json!({}), json!(null), json!(-1)];
    match value {
        Value::Object(object) => {
            for (key, inner) in object {
                let mut without = object.clone();
                without.shift_remove(key);
                all.push(without.into());
                for inner in variants(inner) {
                    let mut other = object.clone();
                    other.insert(key.clone(), inner);
                    all.push(other.into());
                }
            }
            for key in ["call", "implicit", "then", "else", "do", "sync", "remark", "other"] {
                let mut more = object.clone();
                more.entry(key).or_insert(json!("a()"));
                all.push(more.into());
            }
        }
        Value::Array(items) => {
            for (index, inner) in items.iter().enumerate() {
                let mut without = items.clone();
                without.remove(index);
                all.push(without.into());
                for inner in variants(inner) {
                    let mut other = items.clone();
                    other[index] = inner;
                    all.push(other.into());
                }
            }
        }
        _ => {}
    }
    all
}

#[test]
fn the_schema_accepts_what_the_reader_accepts() {
    let text = include_str!("../../../schemas/plan.schema.json");
    let schema: Value = serde_json::from_str(text).unwrap();
    let call = json!({ "call": "a(<x>)", "implicit": { "to": "<y>" }, "explanation": "why" });
    let tree = json!([
        call,
        { "if": { "not": { "any": [call, { "all": [call, call] }] } }, "then": [call], "else": [{ "remark": "r" }] },
        { "while": call, "do": [{ "repeat": 3, "do": [call] }] },
        { "parallel": [{ "lane": "left", "do": [call, { "sync": "s" }, { "remark": "r" }] }] },
    ]);
    let mut count = [0, 0];
    for tree in variants(&tree).into_iter().chain([tree]) {
        let file = json!({ "task_cohesion": { "task_tree": tree } });
        // A call's own form is told in words alone.
        let odd_call = file.to_string().contains("\"call\":[]");
        let read = serde_json::from_value::<PlanFile>(file.clone());
        let accepted = fits(&schema, &schema, &file);
        count[usize::from(accepted)] += 1;
        assert_eq!(read.is_ok(), accepted && !odd_call, "{read:?}\n{file}");
        if !tree.is_null() {
            assert_eq!(plan::read(&file.to_string()).is_ok(), accepted, "{file}");
        }
    }
    assert!(count[0] > 100 && count[1] > 20, "{count:?}");
    let flat = json!({
        "task_cohesion": { "task_sequence": ["a()"], "step_instructions": ["A"], "object_name": "<x>" },
        "environment_before": { "assets": ["<t>"], "objects": ["<x>"], "object_states": { "<x>": ["on(<t>)"] } },
        "instruction_summary": "", "question": ""
    });
    let of = |domain: Value| json!({ "python_script": "a()", "domain": domain });
    for (file, accepted) in [
        (flat, true),
        (of(json!({ "name": "porter", "hash": "00" })), true),
        (of(json!({ "name": "porter" })), true),
        (of(json!({ "hash": "00" })), false),
        (of(json!({ "name": 7 })), false),
        (of(json!("porter")), false),
        (json!({ "python_script": "a()" }), true),
        (
            json!({ "python_script": "a()", "task_cohesion": { "task_sequence": [] } }),
            false,
        ),
        (
            json!({ "task_cohesion": { "task_tree": [], "task_sequence": [] } }),
            false,
        ),
        (
            json!({ "task_cohesion": { "task_tree": [{ "call": "a()" }, { "call": "b()" }] } }),
            true,
        ),
    ] {
        assert_eq!(fits(&schema, &schema, &file), accepted, "{file}");
        assert_eq!(plan::read(&file.to_string()).is_ok(), accepted, "{file}");
    }
}
