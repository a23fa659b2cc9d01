//! The paper's JSON for one state of the world.

use indexmap::IndexMap;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

/// An environment as its file writes it: the entities and the states of each.
///
/// Reading and writing preserve the order of everything, and single states stay distinct from lists of one.
///
/// ```
/// use longstep_core::environment::Environment;
/// let text = r#"{"assets":["<table>"],"asset_states":{},"objects":["<cup>"],"object_states":{"<cup>":"on_something(<table>)"}}"#;
/// let environment = Environment::from_json(text).unwrap();
/// assert_eq!(serde_json::to_string(&environment).unwrap(), text);
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Environment {
    /// Entities that cannot be manipulated: shelves, tables.
    #[serde(default)]
    pub assets: Vec<String>,
    /// The states of the assets.
    #[serde(default)]
    pub asset_states: IndexMap<String, Words>,
    /// Entities that can be manipulated: cans, handles.
    #[serde(default)]
    pub objects: Vec<String>,
    /// The states of the objects.
    #[serde(default)]
    pub object_states: IndexMap<String, Words>,
    /// The static properties of the assets.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asset_properties: Option<IndexMap<String, Words>>,
    /// The static properties of the objects.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object_properties: Option<IndexMap<String, Words>>,
    /// Statements without a subject: facts without arguments, and numbers of functions without arguments.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub facts: Option<Vec<String>>,
    /// Everyday names of entities, by identifier.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub names: Option<IndexMap<String, String>>,
    /// Types of entities, by identifier, where they are more precise than the type of the list.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub types: Option<IndexMap<String, String>>,
    /// The entity that gives the instructions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speaker: Option<String>,
    /// The entity that carries out the plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
}

/// One word or a list of words.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Words {
    /// A single word, not in a list.
    One(String),
    /// A list.
    Many(Vec<String>),
}

impl Words {
    /// Returns the words of either form.
    pub fn as_mut_slice(&mut self) -> &mut [String] {
        match self {
            Self::One(word) => std::slice::from_mut(word),
            Self::Many(words) => words,
        }
    }

    /// Returns the words of either form.
    pub fn as_slice(&self) -> &[String] {
        match self {
            Self::One(word) => std::slice::from_ref(word),
            Self::Many(words) => words,
        }
    }
}

impl<'de> Deserialize<'de> for Words {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        match value {
            Value::String(word) => Some(Self::One(word)),
            Value::Array(items) => items
                .into_iter()
                .map(|item| match item {
                    Value::String(word) => Some(word),
                    _ => None,
                })
                .collect::<Option<Vec<String>>>()
                .map(Self::Many),
            _ => None,
        }
        .ok_or_else(|| serde::de::Error::custom("expected a string or a list of strings"))
    }
}

impl Environment {
    /// Parses an environment, bare or wrapped in `{"environment": ...}`.
    ///
    /// # Errors
    ///
    /// The error of serde_json, with line and column.
    pub fn from_json(text: &str) -> Result<Self, serde_json::Error> {
        Ok(Self::parse(text)?.0)
    }

    /// Parses an environment as [`Environment::from_json`] does; the second value is true if it is wrapped.
    ///
    /// # Errors
    ///
    /// The error of serde_json, with line and column.
    pub fn parse(text: &str) -> Result<(Self, bool), serde_json::Error> {
        #[derive(Deserialize)]
        struct Wrapped {
            environment: Environment,
        }
        // The keys decide between both forms, so that errors refer to the form that was meant. Parsing the text again,
        // rather than the value, keeps line and column in the errors.
        let value: Value = serde_json::from_str(text)?;
        if value.get("environment").is_some() {
            Ok((serde_json::from_str::<Wrapped>(text)?.environment, true))
        } else {
            Ok((serde_json::from_str(text)?, false))
        }
    }

    /// Returns true if some states are written as lists.
    pub(crate) fn prefers_lists(&self) -> bool {
        let mut all = self.asset_states.values().chain(self.object_states.values());
        all.any(|words| matches!(words, Words::Many(_)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_error(text: &str, expected: &str) {
        assert_eq!(Environment::from_json(text).unwrap_err().to_string(), expected);
    }

    #[test]
    fn wrapped_and_bare_are_the_same() {
        let bare = Environment::from_json(r#"{"assets": ["<a>"], "names": {"<a>": "shelf"}}"#).unwrap();
        let wrapped =
            Environment::from_json(r#"{"environment": {"assets": ["<a>"], "names": {"<a>": "shelf"}}}"#).unwrap();
        assert_eq!(bare, wrapped);
    }

    #[test]
    fn mistakes_are_told_with_their_place() {
        check_error("", "EOF while parsing a value at line 1 column 0");
        check_error(
            "{\"assets\": [],\n \"object_states\": {\"<a>\": 3}}",
            "expected a string or a list of strings at line 2 column 28",
        );
        check_error(
            r#"{"asset": []}"#,
            "unknown field `asset`, expected one of `assets`, `asset_states`, `objects`, `object_states`, `asset_properties`, `object_properties`, `facts`, `names`, `types`, `speaker`, `robot` at line 1 column 8",
        );
    }
}
