//! JSON form of a written plan: the `task_tree` of `task_cohesion`. The schema is `schemas/plan.schema.json`.

use serde_json::{Map, Value, json};

use super::tree::{DEEPEST, Lane, fold};
use super::written::{Written, WrittenNode, WrittenStep, is_name};
use super::{LaneItem, Node, StepId, Test};
use longstep_model::call::Call;
use longstep_model::json::Path;

/// An error in a `task_tree`, with its path.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{path}` {message}")]
#[non_exhaustive]
pub struct TreeError {
    /// Path of the invalid value.
    pub path: Path,
    /// The expected form of the value, or its unexpected part.
    pub message: String,
}

type Read<T> = Result<T, TreeError>;

/// Converts the nodes of a plan to JSON; omits empty parts.
///
/// ```
/// use longstep_verify::plan::{read_tree, script, write_tree};
/// let written = script::read("if not check_date():\n    throw_away()  # into the bin\n").unwrap();
/// let tree = write_tree(&written);
/// assert_eq!(
///     tree.to_string(),
///     r#"[{"if":{"not":{"call":"check_date()"}},"then":[{"call":"throw_away()","explanation":"into the bin"}]}]"#
/// );
/// assert_eq!(read_tree(&tree, Vec::new(), &longstep_model::json::Path::default()), Ok(written));
/// ```
pub fn write_tree(plan: &Written) -> Value {
    fold(&plan.body, &|node, [first, second]| match node {
        Node::Step(step) => step_json(plan, *step),
        Node::Remark(words) => json!({ "remark": words }),
        Node::If { condition, .. } if second.is_empty() => json!({ "if": test_json(condition), "then": first }),
        Node::If { condition, .. } => json!({ "if": test_json(condition), "then": first, "else": second }),
        Node::While { condition, .. } => json!({ "while": test_json(condition), "do": first }),
        Node::Repeat { times, .. } => json!({ "repeat": times, "do": first }),
        Node::Parallel { lanes } => {
            let item = |item: &LaneItem| match item {
                LaneItem::Step(step) => step_json(plan, *step),
                LaneItem::Sync(name) => json!({ "sync": name }),
                LaneItem::Remark(words) => json!({ "remark": words }),
            };
            let lane = |lane: &Lane<String>| {
                let items: Value = lane.items.iter().map(item).collect();
                json!({ "lane": lane.actor, "do": items })
            };
            json!({ "parallel": lanes.iter().map(lane).collect::<Value>() })
        }
    })
    .into()
}

fn step_json(plan: &Written, step: StepId) -> Value {
    plan.steps.get(step.index()).map_or(Value::Null, call_json)
}

fn call_json(step: &WrittenStep) -> Value {
    let mut node = json!({ "call": step.call.to_string() });
    if !step.implicit.is_empty() {
        let named = step.implicit.iter().map(|(name, value)| (name.clone(), json!(value)));
        node["implicit"] = named.collect::<Map<_, _>>().into();
    }
    if !step.explanation.is_empty() {
        node["explanation"] = json!(step.explanation);
    }
    node
}

fn test_json(test: &Test<WrittenStep>) -> Value {
    let parts = |parts: &[Test<WrittenStep>]| parts.iter().map(test_json).collect::<Value>();
    match test {
        Test::Holds(call) => call_json(call),
        // Conditions of a written plan contain calls only.
        Test::Sense(_) => Value::Null,
        Test::Not(inner) => json!({ "not": test_json(inner) }),
        Test::All(all) => json!({ "all": parts(all) }),
        Test::Any(any) => json!({ "any": parts(any) }),
    }
}

/// Parses the nodes of a plan that handles these objects. Missing keys, unknown keys and wrong types are errors. `path`
/// is the location of the array, for error messages.
///
/// # Errors
///
/// The first error found.
pub fn read_tree(tree: &Value, objects: Vec<String>, path: &Path) -> Result<Written, TreeError> {
    let mut reader = Reader {
        steps: Vec::new(),
        depth: 0,
    };
    let body = reader.nodes(tree, path)?;
    let written = Written {
        steps: reader.steps,
        body,
        objects,
    };
    if written.is_sound() {
        Ok(written)
    } else {
        wrong(
            path,
            format!("has branches and conditions more than {DEEPEST} deep in each other"),
        )
    }
}

fn wrong<T>(path: &Path, message: impl Into<String>) -> Read<T> {
    Err(TreeError {
        path: path.clone(),
        message: message.into(),
    })
}

struct Reader {
    steps: Vec<WrittenStep>,
    depth: usize,
}

/// Checks that a value is an object with all keys of `must` and no others than these and `may`.
fn keys<'v>(value: &'v Value, path: &Path, must: &[&str], may: &[&str]) -> Read<&'v Map<String, Value>> {
    let Value::Object(object) = value else {
        return wrong(path, "should be an object");
    };
    if let Some(missing) = must.iter().find(|key| !object.contains_key(**key)) {
        return wrong(path, format!("has no `{missing}`"));
    }
    let known = |key: &&String| must.contains(&key.as_str()) || may.contains(&key.as_str());
    match object.keys().find(|key| !known(key)) {
        Some(key) => wrong(&path.push(key), format!("is not known beside `{}`", must[0])),
        None => Ok(object),
    }
}

fn text(value: &Value, path: &Path) -> Read<String> {
    match value {
        Value::String(text) => Ok(text.clone()),
        _ => wrong(path, "should be a text"),
    }
}

fn array<'v>(value: &'v Value, path: &Path) -> Read<&'v [Value]> {
    match value {
        Value::Array(items) => Ok(items),
        _ => wrong(path, "should be an array"),
    }
}

/// Parses a call with its implicit arguments and explanation.
fn step(value: &Value, path: &Path) -> Read<WrittenStep> {
    let object = keys(value, path, &["call"], &["implicit", "explanation"])?;
    let at = path.push("call");
    let written = text(&object["call"], &at)?;
    let Ok(call) = Call::parse(&written) else {
        return wrong(&at, "should be a call such as `grasp(<cup>)`");
    };
    let mut step = WrittenStep::of_call(call);
    if let Some(fault) = step.fault() {
        return wrong(&at, fault);
    }
    if let Some(named) = object.get("implicit") {
        let at = path.push("implicit");
        let Value::Object(named) = named else {
            return wrong(&at, "should be an object");
        };
        for (name, value) in named {
            let at = at.push(name);
            if !is_name(name) {
                return wrong(&at, "is no name of a parameter");
            }
            step.implicit.push((name.clone(), text(value, &at)?));
        }
    }
    if let Some(words) = object.get("explanation") {
        step.explanation = text(words, &path.push("explanation"))?;
    }
    Ok(step)
}

impl Reader {
    fn nodes(&mut self, value: &Value, path: &Path) -> Read<Vec<WrittenNode>> {
        // Allows one level more than a sound tree has, so that the error can name the depth limit.
        if self.depth > DEEPEST {
            return wrong(path, format!("stands more than {DEEPEST} deep"));
        }
        self.depth += 1;
        let items = array(value, path)?.iter().enumerate();
        let nodes = items.map(|(index, item)| self.node(item, &path.index(index))).collect();
        self.depth -= 1;
        nodes
    }

    fn under(&mut self, object: &Map<String, Value>, key: &str, path: &Path) -> Read<Vec<WrittenNode>> {
        object
            .get(key)
            .map_or_else(|| Ok(Vec::new()), |value| self.nodes(value, &path.push(key)))
    }

    fn node(&mut self, value: &Value, path: &Path) -> Read<WrittenNode> {
        let has = |key| value.get(key).is_some();
        Ok(if has("call") {
            Node::Step(self.step(value, path)?)
        } else if has("remark") {
            Node::Remark(remark(value, path)?)
        } else if has("if") {
            let object = keys(value, path, &["if", "then"], &["else"])?;
            Node::If {
                condition: test(&object["if"], &path.push("if"), 0)?,
                then: self.under(object, "then", path)?,
                otherwise: self.under(object, "else", path)?,
            }
        } else if has("while") {
            let object = keys(value, path, &["while", "do"], &[])?;
            Node::While {
                condition: test(&object["while"], &path.push("while"), 0)?,
                body: self.under(object, "do", path)?,
            }
        } else if has("repeat") {
            let object = keys(value, path, &["repeat", "do"], &[])?;
            let times = object["repeat"].as_u64().and_then(|times| u32::try_from(times).ok());
            let Some(times) = times else {
                return wrong(&path.push("repeat"), "should be a number of times");
            };
            let body = self.under(object, "do", path)?;
            Node::Repeat { times, body }
        } else if has("parallel") {
            let object = keys(value, path, &["parallel"], &[])?;
            let lanes = self.lanes(&object["parallel"], &path.push("parallel"))?;
            Node::Parallel { lanes }
        } else {
            return wrong(
                path,
                "should have one of `call`, `if`, `while`, `repeat`, `parallel` and `remark`",
            );
        })
    }

    fn step(&mut self, value: &Value, path: &Path) -> Read<StepId> {
        let step = step(value, path)?;
        self.steps.push(step);
        Ok(StepId::new(self.steps.len() - 1))
    }

    fn lanes(&mut self, value: &Value, path: &Path) -> Read<Vec<Lane<String>>> {
        let mut lanes: Vec<Lane<String>> = Vec::new();
        for (index, lane) in array(value, path)?.iter().enumerate() {
            let path = path.index(index);
            let object = keys(lane, &path, &["lane", "do"], &[])?;
            let actor = text(&object["lane"], &path.push("lane"))?;
            if lanes.iter().any(|lane| lane.actor == actor) {
                return wrong(&path.push("lane"), "has a lane already");
            }
            let at = path.push("do");
            let items = array(&object["do"], &at)?.iter().enumerate();
            let items: Read<Vec<LaneItem>> = items.map(|(index, item)| self.item(item, &at.index(index))).collect();
            lanes.push(Lane { actor, items: items? });
        }
        if lanes.is_empty() {
            wrong(path, "should have a lane")
        } else {
            Ok(lanes)
        }
    }

    fn item(&mut self, value: &Value, path: &Path) -> Read<LaneItem> {
        if value.get("call").is_some() {
            return self.step(value, path).map(LaneItem::Step);
        }
        if value.get("remark").is_some() {
            return remark(value, path).map(LaneItem::Remark);
        }
        if value.get("sync").is_none() {
            return wrong(path, "should have one of `call`, `sync` and `remark`");
        }
        let object = keys(value, path, &["sync"], &[])?;
        text(&object["sync"], &path.push("sync")).map(LaneItem::Sync)
    }
}

fn remark(value: &Value, path: &Path) -> Read<String> {
    let object = keys(value, path, &["remark"], &[])?;
    text(&object["remark"], &path.push("remark"))
}

fn test(value: &Value, path: &Path, depth: usize) -> Read<Test<WrittenStep>> {
    if depth > DEEPEST {
        return wrong(path, format!("stands more than {DEEPEST} deep"));
    }
    let has = |key| value.get(key).is_some();
    let parts = |key: &str| {
        let object = keys(value, path, &[key], &[])?;
        let path = path.push(key);
        let parts = array(&object[key], &path)?;
        if parts.len() < 2 {
            return wrong(&path, "should have two parts or more");
        }
        let parts = parts.iter().enumerate();
        parts
            .map(|(index, part)| test(part, &path.index(index), depth + 1))
            .collect()
    };
    if has("call") {
        step(value, path).map(Test::Holds)
    } else if has("not") {
        let object = keys(value, path, &["not"], &[])?;
        let inner = test(&object["not"], &path.push("not"), depth + 1)?;
        Ok(Test::Not(Box::new(inner)))
    } else if has("all") {
        parts("all").map(Test::All)
    } else if has("any") {
        parts("any").map(Test::Any)
    } else {
        wrong(path, "should have one of `call`, `not`, `all` and `any`")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn refused(tree: Value, message: &str) {
        let error = read_tree(&tree, Vec::new(), &Path::key("task_tree")).unwrap_err();
        assert_eq!(error.to_string(), message);
    }

    #[test]
    fn task_tree_errors_name_the_path_of_the_wrong_value() {
        let call = json!({ "call": "a()" });
        refused(json!({}), "`task_tree` should be an array");
        refused(
            json!([1]),
            "`task_tree[0]` should have one of `call`, `if`, `while`, `repeat`, `parallel` and `remark`",
        );
        refused(json!([{ "call": 1 }]), "`task_tree[0].call` should be a text");
        refused(
            json!([{ "call": "a(" }]),
            "`task_tree[0].call` should be a call such as `grasp(<cup>)`",
        );
        refused(
            json!([{ "call": "if()" }]),
            "`task_tree[0].call` has a name that no script can write",
        );
        refused(
            json!([{ "call": "1()" }]),
            "`task_tree[0].call` has a name that no script can write",
        );
        refused(
            json!([{ "call": "a()", "arm": "left" }]),
            "`task_tree[0].arm` is not known beside `call`",
        );
        refused(
            json!([{ "call": "a()", "implicit": { "to": 1 } }]),
            "`task_tree[0].implicit.to` should be a text",
        );
        refused(
            json!([{ "call": "a()", "implicit": { "2": "" } }]),
            "`task_tree[0].implicit.2` is no name of a parameter",
        );
        refused(json!([{ "if": call, "do": [] }]), "`task_tree[0]` has no `then`");
        refused(
            json!([{ "if": call, "then": [call, 3] }]),
            "`task_tree[0].then[1]` should have one of `call`, `if`, `while`, `repeat`, `parallel` and `remark`",
        );
        refused(
            json!([{ "if": { "all": [call] }, "then": [] }]),
            "`task_tree[0].if.all` should have two parts or more",
        );
        refused(
            json!([{ "if": {}, "then": [] }]),
            "`task_tree[0].if` should have one of `call`, `not`, `all` and `any`",
        );
        refused(
            json!([{ "repeat": -1, "do": [] }]),
            "`task_tree[0].repeat` should be a number of times",
        );
        refused(
            json!([{ "parallel": [] }]),
            "`task_tree[0].parallel` should have a lane",
        );
        refused(
            json!([{ "parallel": [{ "lane": "l", "do": [] }, { "lane": "l", "do": [] }] }]),
            "`task_tree[0].parallel[1].lane` has a lane already",
        );
        refused(
            json!([{ "parallel": [{ "lane": "l", "do": [{ "if": call, "then": [] }] }] }]),
            "`task_tree[0].parallel[0].do[0]` should have one of `call`, `sync` and `remark`",
        );
        let mut deep = json!([]);
        for _ in 0..60 {
            deep = json!([{ "repeat": 2, "do": deep }]);
        }
        assert!(read_tree(&deep, Vec::new(), &Path::default()).is_err());
    }
}
