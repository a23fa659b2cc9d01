//! The forms of answers: a grammar for an engine that masks tokens, and a JSON schema for a server.

use std::sync::Arc;

use serde_json::{Value, json};

use crate::goal::QUESTION;

/// Token budget of an answer that may be a question: three tokens for each letter, as in scripts that a model has few tokens for.
pub(crate) const QUESTION_TOKENS: u32 = 384;

/// A set of texts: the form of an answer, or of a part of it.
///
/// Every form is regular, so a whole answer becomes one regular expression and the grammar of a request one lexeme. With
/// several lexemes, llguidance commits to the longest one that the text can begin: beside `put(X, top of Y)`, no model
/// could write `put(book, tv stand)`, because `, t` was taken for the beginning of `, top of `.
#[derive(Debug, Clone)]
pub(crate) enum Form {
    /// This text.
    Text(String),
    /// A regular expression without lookaround and anchors.
    Pattern(String),
    /// One of the forms.
    Either(Vec<Form>),
    /// The forms one after another.
    Row(Vec<Form>),
    /// The form again and again, between `least` and `most` times.
    Times { form: Box<Form>, least: usize, most: usize },
    /// A form that occurs at several places. The grammar has it once.
    Shared(Arc<Form>),
}

impl Form {
    /// The form, for use at several places.
    pub(crate) fn shared(self) -> Self {
        Self::Shared(Arc::new(self))
    }

    /// This text.
    pub(crate) fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    /// One of the texts.
    pub(crate) fn texts(texts: impl IntoIterator<Item = String>) -> Self {
        Self::Either(texts.into_iter().map(Self::Text).collect())
    }

    /// The form, or nothing.
    pub(crate) fn optional(self) -> Self {
        self.times(0, 1)
    }

    /// The form again and again.
    pub(crate) fn times(self, least: usize, most: usize) -> Self {
        Self::Times {
            form: Box::new(self),
            least,
            most,
        }
    }

    /// A form between one and `most` times, with a separator.
    pub(crate) fn separated(self, separator: Self, most: usize) -> Self {
        // Engines refuse a range that ends with 0.
        if most <= 1 {
            return self;
        }
        let form = self.shared();
        let more = Self::Row(vec![separator, form.clone()]).times(0, most - 1);
        Self::Row(vec![form, more])
    }

    /// A question to the person in any language, of at most [`QUESTION_TOKENS`]: sentences with their full stops, because a model
    /// that may not end a sentence goes on with excuses.
    pub(crate) fn question() -> Self {
        Self::Row(vec![
            Self::text(QUESTION),
            Self::Pattern("\\p{L}[\\p{L}\\p{M}\\p{N} ,.;:'’()?¿、。？-]{4,120}[?.。？]".to_owned()),
        ])
    }

    /// Returns the grammar in llguidance's Lark dialect: the answer is a terminal, so it is one lexeme.
    pub(crate) fn grammar(&self) -> String {
        let mut terminals = Vec::new();
        let answer = self.written(&mut terminals);
        let mut text = format!("start: ANSWER\nANSWER: {answer}\n");
        for (index, (_, written)) in terminals.iter().enumerate() {
            text.push_str(&format!("PART{index}: {written}\n"));
        }
        text
    }

    /// Returns the form in the notation of terminals. Shared forms become terminals of their own.
    fn written(&self, terminals: &mut Vec<(*const Form, String)>) -> String {
        match self {
            Self::Text(text) => quoted(text),
            Self::Pattern(pattern) => format!("/{pattern}/"),
            Self::Either(forms) => {
                let all: Vec<String> = forms.iter().map(|form| form.written(terminals)).collect();
                match &all[..] {
                    [only] => only.clone(),
                    _ => format!("({})", all.join("\n  | ")),
                }
            }
            Self::Row(forms) => {
                let all: Vec<String> = forms.iter().map(|form| form.written(terminals)).collect();
                format!("({})", all.join(" "))
            }
            Self::Times { form, least, most } => format!("({}){{{least},{most}}}", form.written(terminals)),
            Self::Shared(form) => {
                let key = Arc::as_ptr(form);
                let known = terminals.iter().position(|(other, _)| *other == key);
                let index = known.unwrap_or_else(|| {
                    let written = form.written(terminals);
                    terminals.push((key, written));
                    terminals.len() - 1
                });
                format!("PART{index}")
            }
        }
    }
}

/// A string in double quotes, with the escapes of JSON.
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

/// A schema for a list with at most so many items. Servers' strict modes do not know the bound.
pub(crate) fn at_most(mut list: Value, most: usize) -> Value {
    if let Some(list) = list.as_object_mut() {
        list.insert("maxItems".to_owned(), most.into());
    }
    list
}

/// A schema for texts of a regular expression, which is anchored. Servers' strict modes do not know it.
pub(crate) fn pattern(pattern: &str) -> Value {
    json!({"type": "string", "pattern": pattern})
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separated_form_repeats_up_to_its_limit() {
        for (most, expected) in [
            (1, "start: ANSWER\nANSWER: \"a\"\n"),
            (
                3,
                "start: ANSWER\nANSWER: (PART0 ((\" & \" PART0)){0,2})\nPART0: \"a\"\n",
            ),
        ] {
            assert_eq!(Form::text("a").separated(Form::text(" & "), most).grammar(), expected);
        }
    }
}
