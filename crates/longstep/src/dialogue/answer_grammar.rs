//! The forms of answers: a grammar for an engine that masks tokens, and a JSON schema for a server.

use serde_json::{Value, json};

use crate::goal::QUESTION;

/// A grammar in llguidance's Lark dialect, made rule by rule.
#[derive(Debug, Default)]
pub(crate) struct Grammar {
    starts: Vec<String>,
    rules: String,
}

impl Grammar {
    /// Adds an alternative for the whole answer.
    pub(crate) fn start(&mut self, alternative: impl Into<String>) {
        self.starts.push(alternative.into());
    }

    /// Returns whether the grammar has no answer yet.
    pub(crate) fn is_empty(&self) -> bool {
        self.starts.is_empty()
    }

    /// Adds a question to the person as an alternative for the whole answer.
    pub(crate) fn question(&mut self) {
        self.start("question");
        self.rule(
            "question",
            [format!("{} /[A-Za-z][A-Za-z0-9 ,'-]{{8,120}}\\?/", quoted(QUESTION))],
        );
    }

    /// Adds a rule.
    pub(crate) fn rule(&mut self, name: &str, alternatives: impl IntoIterator<Item = String>) {
        self.rules.push_str(&format!("{name}: {}\n", either(alternatives)));
    }

    /// Returns the text of the grammar.
    pub(crate) fn text(self) -> String {
        format!("start: {}\n{}", self.starts.join(" | "), self.rules)
    }
}

/// Alternatives, each on a line of its own.
pub(crate) fn either(alternatives: impl IntoIterator<Item = String>) -> String {
    alternatives.into_iter().collect::<Vec<_>>().join("\n  | ")
}

/// Alternatives on one line, in parentheses where there are several.
pub(crate) fn group(alternatives: &[String]) -> String {
    match alternatives {
        [only] => only.clone(),
        _ => format!("({})", alternatives.join(" | ")),
    }
}

/// A string of the grammar. The dialect has the escapes of JSON.
pub(crate) fn quoted(text: &str) -> String {
    Value::String(text.to_owned()).to_string()
}

/// Reads an answer that is a question to the person.
pub(crate) fn question_in(answer: &str) -> Option<&str> {
    answer.trim().strip_prefix(QUESTION.trim()).map(str::trim)
}

/// Values in one enumeration that servers accept, and properties of one schema.
pub(crate) const ENUM_LIMIT: usize = 500;
/// Bytes of all values of an enumeration together that servers accept.
pub(crate) const ENUM_BYTES: usize = 12_000;

/// Returns the texts if servers accept an enumeration of them.
pub(crate) fn listed(texts: Vec<String>) -> Option<Vec<String>> {
    let bytes: usize = texts.iter().map(String::len).sum();
    (!texts.is_empty() && texts.len() <= ENUM_LIMIT && bytes <= ENUM_BYTES).then_some(texts)
}

/// A schema for one of the texts, or for any text where none are given.
pub(crate) fn one_of(texts: Option<&[String]>) -> Value {
    match texts {
        Some(texts) if !texts.is_empty() => json!({"type": "string", "enum": texts}),
        _ => json!({"type": "string"}),
    }
}

/// A schema for any text.
pub(crate) fn any_text() -> Value {
    one_of(None)
}

/// A schema for a list.
pub(crate) fn list(items: Value) -> Value {
    json!({"type": "array", "items": items})
}

/// A schema for an object with exactly these keys, all required, as OpenAI's strict mode demands.
pub(crate) fn closed(entries: &[(&str, Value)]) -> Value {
    let required: Vec<&str> = entries.iter().map(|(key, _)| *key).collect();
    let properties: serde_json::Map<String, Value> = entries
        .iter()
        .map(|(key, value)| ((*key).to_owned(), value.clone()))
        .collect();
    json!({"type": "object", "properties": properties, "required": required, "additionalProperties": false})
}
