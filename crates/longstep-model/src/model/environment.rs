//! The paper's JSON for one state of the world.

use indexmap::IndexMap;
use serde::de::IgnoredAny;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

use crate::call::{Call, unquoted};
use crate::diagnostic::Position;
use crate::json::Path;
use crate::literal::{self, FaultReason};

/// An environment as its file writes it: the entities and the states of each.
///
/// Reading and writing preserve the order of everything, and single states stay distinct from lists of one.
///
/// ```
/// use longstep_model::environment::Environment;
/// let text = r#"{"assets":["<table>"],"asset_states":{},"objects":["<cup>"],"object_states":{"<cup>":"on_something(<table>)"}}"#;
/// let environment = Environment::from_json(text).unwrap();
/// assert_eq!(serde_json::to_string(&environment).unwrap(), text);
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// Observation without a subject: facts without arguments, and numbers of functions without arguments.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub facts: Option<Vec<String>>,
    /// Everyday names of entities, by identifier: up to 60 letters, digits, blanks, hyphens, apostrophes, dots and underscores.
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
    /// The schema with which an editor completes the file. It says nothing about the world, and is not written.
    #[serde(default, rename = "$schema", skip_serializing)]
    #[cfg_attr(feature = "schema", schemars(with = "Option<String>"))]
    pub schema: IgnoredAny,
}

/// One word or a list of words.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Words {
    /// A single word, not in a list.
    One(String),
    /// A list.
    Many(Vec<String>),
}

/// An environment inside `{"environment": ...}`.
#[derive(Deserialize)]
struct Wrapped {
    environment: Environment,
}

/// A text that is no environment.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}{}", place(.position))]
#[non_exhaustive]
pub struct EnvironmentError {
    /// The mistake.
    pub message: String,
    /// Its position, if it is known.
    pub position: Option<Position>,
}

fn place(position: &Option<Position>) -> String {
    position.map_or_else(String::new, |Position { line, column }| {
        format!(" at line {line} column {column}")
    })
}

impl EnvironmentError {
    fn of_json(error: &serde_json::Error) -> Self {
        let (line, column) = (error.line(), error.column());
        let full = error.to_string();
        let message = full.strip_suffix(&format!(" at line {line} column {column}"));
        let number = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
        Self {
            message: message.unwrap_or(&full).to_owned(),
            position: (line > 0).then(|| Position {
                line: number(line),
                column: number(column),
            }),
        }
    }
}

impl Words {
    /// Creates the states of a text: one, or several with commas between them, as in `on_something(<desk>), open()`.
    pub fn of_text(text: String) -> Self {
        let parts = calls_with_commas(&text);
        if parts.len() > 1
            && parts
                .iter()
                .all(|part| part.ends_with(')') && Call::parse(part).is_ok())
        {
            Self::Many(parts)
        } else {
            Self::One(text)
        }
    }

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

/// Splits a text at the commas outside of parentheses.
fn calls_with_commas(text: &str) -> Vec<String> {
    let (mut parts, mut depth, mut start) = (Vec::new(), 0_usize, 0);
    for (at, letter) in unquoted(text) {
        match letter {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.push(text[start..at].trim().to_owned());
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(text[start..].trim().to_owned());
    parts
}

impl<'de> Deserialize<'de> for Words {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        match value {
            Value::String(word) => Some(Self::of_text(word)),
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
    /// Parses an environment, bare or wrapped in `{"environment": ...}`, as JSON or as a Python literal with comments.
    ///
    /// # Errors
    ///
    /// The first mistake, with its position.
    ///
    /// ```
    /// use longstep_model::environment::Environment;
    /// let python = Environment::from_json("{'assets': ['<desk>',], 'names': None}  # office").unwrap();
    /// assert_eq!(python, Environment::from_json(r#"{"assets": ["<desk>"]}"#).unwrap());
    /// ```
    pub fn from_json(text: &str) -> Result<Self, EnvironmentError> {
        Ok(Self::parse(text)?.0)
    }

    /// Parses an environment as [`Environment::from_json`] does; the second value is true if it is wrapped.
    ///
    /// # Errors
    ///
    /// The first mistake, with its position.
    pub fn parse(text: &str) -> Result<(Self, bool), EnvironmentError> {
        match serde_json::from_str::<Value>(text) {
            Ok(value) => {
                // Parsing the text again, rather than the value, keeps line and column in the errors.
                let is_wrapped = value.get("environment").is_some();
                let read = if is_wrapped {
                    serde_json::from_str::<Wrapped>(text).map(|wrapped| wrapped.environment)
                } else {
                    serde_json::from_str(text)
                };
                Ok((read.map_err(|error| EnvironmentError::of_json(&error))?, is_wrapped))
            }
            Err(error) => Self::parse_literal(text, &EnvironmentError::of_json(&error)),
        }
    }

    /// Parses a text that is not JSON: a Python literal, with comments. `json` is the first place where it is not JSON.
    fn parse_literal(text: &str, json: &EnvironmentError) -> Result<(Self, bool), EnvironmentError> {
        let literal = literal::whole(text).map_err(|fault| {
            let position = Position::of(text, fault.at);
            // The reader that came further says more about the mistake.
            match fault.reason {
                FaultReason::Malformed(message) if json.position.is_none_or(|json| json < position) => {
                    EnvironmentError {
                        message,
                        position: Some(position),
                    }
                }
                _ => json.clone(),
            }
        })?;
        let twice = |path: Path| EnvironmentError {
            message: format!("`{path}` stands there twice"),
            position: None,
        };
        let value = literal::json(&literal.node, &Path::default()).map_err(twice)?;
        let is_wrapped = value.get("environment").is_some();
        let read = if is_wrapped {
            serde_json::from_value::<Wrapped>(value).map(|wrapped| wrapped.environment)
        } else {
            serde_json::from_value(value)
        };
        Ok((read.map_err(|error| EnvironmentError::of_json(&error))?, is_wrapped))
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
    fn wrapped_environment_equals_bare_environment() {
        let bare = Environment::from_json(r#"{"assets": ["<a>"], "names": {"<a>": "shelf"}}"#).unwrap();
        let wrapped =
            Environment::from_json(r#"{"environment": {"assets": ["<a>"], "names": {"<a>": "shelf"}}}"#).unwrap();
        assert_eq!(bare, wrapped);
    }

    #[test]
    fn python_literals_are_read_with_their_comments() {
        let text = "# the lab\nenvironment = {'environment': {\n  'assets': ('<bench>', '<rack>',),\n  \
            'asset_states': {'<rack>': 'on_something(<bench>), closed()'},  # locked?\n  'robot': None}}\n# end\n";
        let environment = Environment::from_json(text).unwrap();
        assert_eq!(environment.assets, ["<bench>", "<rack>"]);
        let states = environment.asset_states["<rack>"].as_slice();
        assert_eq!(states, ["on_something(<bench>)", "closed()"]);
        check_error(
            "{'assets': [<rack>]}",
            "expected a value, found `<` at line 1 column 13",
        );
        check_error("{'assets': [], 'assets': []}", "`assets` stands there twice");
        check_error("{'assets': []} {}", "expected the end of the text at line 1 column 16");
        check_error("{'assets': [1]}", "invalid type: integer `1`, expected a string");
    }

    #[test]
    fn a_text_with_commas_between_calls_is_a_list() {
        for (text, count) in [
            ("open()", 1),
            ("on(<a>), open()", 2),
            ("near(<a>, <b>)", 1),
            ("a,, b", 1),
            ("Hi, you", 1),
        ] {
            assert_eq!(Words::of_text(text.to_owned()).as_slice().len(), count, "{text}");
        }
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
            "unknown field `asset`, expected one of `assets`, `asset_states`, `objects`, `object_states`, `asset_properties`, `object_properties`, `facts`, `names`, `types`, `speaker`, `robot`, `$schema` at line 1 column 8",
        );
    }
}
