//! From messages of topics and services to an observation.

use std::borrow::Cow;
use std::collections::BTreeMap;

use indexmap::IndexMap;
use longstep_core::environment::Words;
use serde_json::{Map, Value};

use super::configuration::{Configuration, ObservationRule, SayRule};
use super::file::Lists;
use super::template::{Filter, Hole, HoleValues, Table, Template, at};
use crate::error::RobotError;
use crate::rosbridge::message::{broken, quotation};
use longstep_core::environment::Observation;

/// The most elements of one message.
const ELEMENTS: usize = 100_000;

/// Returns the observation that messages make, one for each rule of the configuration.
///
/// # Errors
///
/// A message that lacks a field that its rule needs.
pub(super) fn observation(configuration: &Configuration, messages: &[Value]) -> Result<Observation, RobotError> {
    let mut reading = Reading {
        tables: &configuration.tables,
        states: IndexMap::new(),
        facts: Vec::new(),
    };
    for (rule, message) in configuration.observations.iter().zip(messages) {
        reading.message(rule, message).map_err(|reason| {
            let message = quotation(&message.to_string());
            broken(format!(
                "the message of `{}` does not fit ({reason}): {message}",
                rule.origin.name()
            ))
        })?;
    }
    let lists_facts = configuration.observations.iter().any(ObservationRule::lists_facts);
    Ok(Observation {
        states: reading
            .states
            .into_iter()
            .map(|(entity, texts)| (entity, Words::Many(texts)))
            .collect(),
        facts: lists_facts.then_some(reading.facts),
    })
}

impl ObservationRule {
    fn lists_facts(&self) -> bool {
        self.facts.is_some() || self.say.iter().any(|own| own.is_fact)
    }
}

struct Reading<'a> {
    tables: &'a BTreeMap<String, Table>,
    states: IndexMap<String, Vec<String>>,
    facts: Vec<String>,
}

impl Reading<'_> {
    fn message(&mut self, rule: &ObservationRule, message: &Value) -> Result<(), String> {
        let message = match &rule.json {
            None => Cow::Borrowed(message),
            Some(path) => {
                let text = at(message, path).and_then(Value::as_str);
                let text = text.ok_or_else(|| format!("`{path}` is no text"))?;
                let read = serde_json::from_str(text);
                Cow::Owned(read.map_err(|error| format!("`{path}` holds no JSON: {error}"))?)
            }
        };
        if let Some(path) = &rule.facts {
            self.facts.extend(texts_at(&message, path)?);
        }
        for element in elements(rule.each.as_ref(), &message)? {
            self.element(rule, &element, &message)?;
        }
        Ok(())
    }

    fn element(&mut self, rule: &ObservationRule, element: &Value, message: &Value) -> Result<(), String> {
        let scope = Element {
            element,
            message,
            tables: self.tables,
        };
        let said = |is_fact: bool| {
            let fitting = rule
                .say
                .iter()
                .filter(move |own: &&SayRule| own.is_fact == is_fact && own.when.holds(element));
            fitting
                .map(|own| own.text.fill_text(&scope))
                .collect::<Result<Vec<_>, _>>()
        };
        self.facts.extend(said(true)?);
        let Some(template) = &rule.entity else {
            return Ok(());
        };
        let entity = match template.fill_text(&scope) {
            Ok(entity) => entity,
            // The table lists the elements that are entities.
            Err(_) if looks_up(template) => return Ok(()),
            Err(reason) => return Err(reason),
        };
        let mut texts = said(false)?;
        if let Some(path) = &rule.states {
            texts.extend(texts_at(element, path)?);
        }
        let all = self.states.entry(entity).or_default();
        all.extend(texts.into_iter().filter(|text| !text.is_empty()));
        Ok(())
    }
}

fn looks_up(template: &Template) -> bool {
    let is_table = |filter: &Filter| matches!(filter, Filter::Table(_));
    template.holes().iter().any(|hole| hole.filters.iter().any(is_table))
}

/// Returns the texts at a path: a text or a list of texts.
fn texts_at(value: &Value, path: &str) -> Result<Vec<String>, String> {
    let text = |value: &Value| value.as_str().map(str::to_owned);
    let texts = match at(value, path) {
        Some(Value::Array(items)) => items.iter().map(text).collect(),
        Some(Value::String(text)) => Some(vec![text.clone()]),
        _ => None,
    };
    texts.ok_or_else(|| format!("`{path}` is no list of texts"))
}

/// Returns the elements of a message.
fn elements<'v>(lists: Option<&Lists>, message: &'v Value) -> Result<Vec<Cow<'v, Value>>, String> {
    let list = |path: &str| match at(message, path) {
        Some(Value::Array(items)) if items.len() <= ELEMENTS => Ok(items),
        Some(Value::Array(items)) => Err(format!("`{path}` has {} elements, more than {ELEMENTS}", items.len())),
        _ => Err(format!("`{path}` is no list")),
    };
    match lists {
        None => Ok(vec![Cow::Borrowed(message)]),
        Some(Lists::One(path)) => Ok(list(path)?.iter().map(Cow::Borrowed).collect()),
        Some(Lists::Joined(paths)) => {
            let lists: Vec<&Vec<Value>> = paths.iter().map(|path| list(path)).collect::<Result<_, _>>()?;
            let length = lists.first().map_or(0, |list| list.len());
            if lists.iter().any(|list| list.len() != length) {
                return Err(format!("the lists `{}` have different lengths", paths.join("`, `")));
            }
            let joined = |index: usize| {
                let fields = paths.iter().zip(&lists);
                let fields = fields.map(|(path, list)| (path.clone(), list[index].clone()));
                Cow::Owned(Value::Object(fields.collect::<Map<_, _>>()))
            };
            Ok((0..length).map(joined).collect())
        }
    }
}

/// The holes of an element: its fields, then those of its message; `value` for an element that is no object.
struct Element<'a> {
    element: &'a Value,
    message: &'a Value,
    tables: &'a BTreeMap<String, Table>,
}

impl HoleValues for Element<'_> {
    fn value<'h>(&self, hole: &'h Hole) -> Result<(Value, &'h [Filter]), String> {
        let own = match (hole.name.as_str(), self.element) {
            ("value", plain @ (Value::String(_) | Value::Number(_) | Value::Bool(_))) => Some(plain),
            (name, element) => at(element, name),
        };
        let value = own.or_else(|| at(self.message, &hole.name));
        let value = value.ok_or_else(|| format!("there is no `{}`", hole.name))?;
        Ok((value.clone(), &hole.filters))
    }

    fn table(&self, name: &str) -> Option<&Table> {
        self.tables.get(name)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn observed(rules: &str, messages: &[Value]) -> Result<String, String> {
        let text = format!(
            "name = \"arm\"\nurl = \"ws://127.0.0.1\"\nallow = []\n[table.joint]\nfridge = \"<fridge_handle>\"\n[[action]]\n\
             name = \"*\"\nserver = \"/a\"\ntype = \"a/action/A\"\ngoal = {{}}\n{rules}"
        );
        let configuration = Configuration::parse("robot.toml", &text).unwrap();
        let read = observation(&configuration, messages);
        read.map(|own| serde_json::to_string(&own).unwrap())
            .map_err(|error| error.to_string())
    }

    const JOINTS: &str = "[[observation]]\ntopic = \"/joints\"\ntype = \"sensor_msgs/msg/JointState\"\n\
        each = [\"name\", \"position\"]\nentity = \"{name|joint}\"\n\
        say = [{ state = \"open()\", when = { position = { above = 0.3 } } }, { state = \"closed()\", when = { position = { below = 0.02 } } }]\n";

    const OBSERVE: &str = "[[observation]]\nservice = \"/observe\"\ntype = \"longstep_msgs/srv/Observe\"\neach = \"states\"\n\
        entity = \"{entity}\"\nstates = \"statements\"\nfacts = \"facts\"\n";

    const TEXT: &str = "[[observation]]\ntopic = \"/scene\"\ntype = \"std_msgs/msg/String\"\njson = \"data\"\neach = \"objects\"\n\
        entity = \"{id|entity}\"\nsay = [{ state = \"on_something({on|entity})\" }, { fact = \"hand-at({hand})\", when = { id = \"cup\" } }]\n";

    #[test]
    fn messages_become_statements() {
        let joints = json!({"name": ["fridge", "elbow"], "position": [1.2, 0.0]});
        let seen = json!({"states": [{"entity": "<cup>", "statements": ["on_something(<shelf>)", ""]}], "facts": ["hand-at(<cup>)"]});
        let scene = json!({"data": r#"{"objects": [{"id": "cup", "on": "shelf"}], "hand": "<cup>"}"#});
        for (rules, messages, expected) in [
            (
                JOINTS.to_owned(),
                vec![joints.clone()],
                r#"{"states":{"<fridge_handle>":["open()"]}}"#,
            ),
            (
                OBSERVE.to_owned(),
                vec![seen.clone()],
                r#"{"states":{"<cup>":["on_something(<shelf>)"]},"facts":["hand-at(<cup>)"]}"#,
            ),
            (
                format!("{JOINTS}{OBSERVE}"),
                vec![
                    json!({"name": ["fridge"], "position": [0.1]}),
                    json!({"states": [], "facts": []}),
                ],
                r#"{"states":{"<fridge_handle>":[]},"facts":[]}"#,
            ),
            (
                TEXT.to_owned(),
                vec![scene],
                r#"{"states":{"<cup>":["on_something(<shelf>)"]},"facts":["hand-at(<cup>)"]}"#,
            ),
        ] {
            assert_eq!(observed(&rules, &messages).as_deref(), Ok(expected));
        }
    }

    #[test]
    fn messages_that_do_not_fit_are_errors() {
        for (rules, message, expected) in [
            (
                JOINTS,
                json!({"name": ["fridge"], "position": []}),
                "the lists `name`, `position` have different lengths",
            ),
            (JOINTS, json!({"name": 3, "position": []}), "`name` is no list"),
            (
                OBSERVE,
                json!({"states": [{"entity": "<cup>"}], "facts": []}),
                "`statements` is no list of texts",
            ),
            (
                OBSERVE,
                json!({"states": [{"statements": []}], "facts": []}),
                "there is no `entity`",
            ),
            (
                TEXT,
                json!({"data": "no JSON"}),
                "`data` holds no JSON: expected ident at line 1 column 2",
            ),
            (TEXT, json!({}), "`data` is no text"),
        ] {
            let error = observed(rules, &[message]).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
