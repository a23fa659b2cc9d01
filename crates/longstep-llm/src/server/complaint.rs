//! The error of a server: the message for people, and the parameters that it names.
//!
//! A body may also repeat the request, and with it words of a person. So only the fields in which servers name what they
//! reject are read, and of a message only what stands there as the name of a parameter.

use serde_json::Value;

/// An error body.
#[derive(Debug, Default)]
pub(super) struct Complaint {
    /// The message for people, with that of the server behind it; the whole body if it has none.
    pub(super) message: String,
    /// All messages, in lower case.
    words: String,
    /// The names of parameters, in lower case; of `response_format.type` also each part.
    names: Vec<String>,
    /// The status that the body gives, where the HTTP status is a success.
    pub(super) status: Option<u16>,
}

/// Nesting of error bodies that is read.
const DEPTH: usize = 6;

/// Longest name of a parameter.
const NAME: usize = 64;

/// Fields with messages.
const MESSAGES: [&str; 8] = [
    "message",
    "msg",
    "detail",
    "description",
    "error_description",
    "status_msg",
    "raw",
    "error",
];

/// Fields with the name of a parameter, or with a code that stands for one.
const NAMES: [&str; 5] = ["param", "code", "loc", "field", "type"];

/// Fields with further errors.
const INNER: [&str; 12] = [
    "error",
    "errors",
    "detail",
    "details",
    "message",
    "metadata",
    "raw",
    "fieldViolations",
    "base_resp",
    "innererror",
    "data",
    "cause",
];

/// Words after or before a name that make a plain word the name of a parameter.
const AFTER: [&str; 9] = [
    ":",
    "=",
    " is ",
    " does ",
    " must ",
    " should ",
    " cannot ",
    " parameter",
    " value",
];
const BEFORE: [&str; 11] = [
    "parameter ",
    "parameter: ",
    "argument ",
    "arguments ",
    "field ",
    "invalid ",
    "unsupported ",
    "unknown ",
    "support ",
    "supports ",
    "supporting ",
];

impl Complaint {
    /// Reads an error body.
    pub(super) fn of(body: &str) -> Self {
        let mut complaint = Self::default();
        let mut said = Vec::new();
        match serde_json::from_str::<Value>(body) {
            Ok(value) => complaint.read(&value, DEPTH, &mut said),
            Err(_) => complaint.hear(body, DEPTH, &mut said),
        }
        complaint.message = if said.is_empty() {
            body.to_owned()
        } else {
            said.join(": ")
        };
        complaint
    }

    /// Returns true if one of the parameters is named. The names are in lower case.
    pub(super) fn names(&self, parameters: &[&str]) -> bool {
        let is_named = |parameter: &&str| self.names.iter().any(|name| name == parameter) || self.speaks_of(parameter);
        parameters.iter().any(is_named)
    }

    /// Returns true if a message contains one of the phrases. They are in lower case.
    pub(super) fn says(&self, phrases: &[&str]) -> bool {
        phrases.iter().any(|phrase| self.words.contains(phrase))
    }

    fn read(&mut self, value: &Value, depth: usize, said: &mut Vec<String>) {
        if depth == 0 {
            return;
        }
        match value {
            Value::Array(values) => values.iter().for_each(|value| self.read(value, depth - 1, said)),
            Value::String(text) => self.hear(text, depth, said),
            Value::Object(fields) => {
                for name in NAMES {
                    fields.get(name).into_iter().for_each(|value| self.add_names(value));
                }
                let texts = MESSAGES.iter().filter_map(|name| fields.get(*name)?.as_str());
                texts.for_each(|text| self.hear(text, depth, said));
                let inner = INNER.iter().filter_map(|name| fields.get(*name));
                let inner = inner.filter(|value| value.is_object() || value.is_array());
                inner.for_each(|value| self.read(value, depth - 1, said));
            }
            Value::Null | Value::Bool(_) | Value::Number(_) => {}
        }
    }

    /// Adds a message, which may be or contain an error of the server behind.
    fn hear(&mut self, text: &str, depth: usize, said: &mut Vec<String>) {
        let text = text.trim();
        if text.is_empty() {
            return;
        }
        let inner = text.find('{').and_then(|begin| {
            let value: Value = serde_json::from_str(&text[begin..]).ok()?;
            Some((begin, value))
        });
        let own = inner
            .as_ref()
            .map_or(text, |(begin, _)| text[..*begin].trim_end_matches([' ', ':']));
        if !own.is_empty() {
            if !said.iter().any(|known| known == own) {
                said.push(own.to_owned());
            }
            let own = own.to_lowercase();
            self.names.extend(names_in(&own));
            self.words.push_str(&own);
            self.words.push('\n');
        }
        if let Some((_, value)) = inner {
            self.read(&value, depth - 1, said);
        }
    }

    fn add_names(&mut self, value: &Value) {
        match value {
            Value::String(text) => {
                let text = text.to_lowercase();
                if matches!(text.as_str(), "overloaded_error" | "overloaded") {
                    self.status = Some(529);
                } else if text == "rate_limit_error" {
                    self.status = Some(429);
                }
                self.status = self
                    .status
                    .or(text.parse().ok().filter(|code| (400..600).contains(code)));
                self.names.extend(parts(&text));
            }
            Value::Number(code) => {
                let code = code.as_u64().and_then(|code| u16::try_from(code).ok());
                self.status = self.status.or(code.filter(|code| (400..600).contains(code)));
            }
            Value::Array(values) => values.iter().for_each(|value| self.add_names(value)),
            Value::Null | Value::Bool(_) | Value::Object(_) => {}
        }
    }

    /// Returns true if a message uses a plain word as the name of a parameter: "invalid temperature: only 1 is allowed".
    fn speaks_of(&self, parameter: &str) -> bool {
        self.words.match_indices(parameter).any(|(at, _)| {
            let (before, after) = (&self.words[..at], &self.words[at + parameter.len()..]);
            let is_part = |sign: char| sign.is_alphanumeric() || sign == '_';
            let is_whole = !before.ends_with(is_part) && !after.starts_with(is_part);
            is_whole
                && (AFTER.iter().any(|words| after.starts_with(words))
                    || BEFORE.iter().any(|words| before.ends_with(words)))
        })
    }
}

/// Returns the names in a message: what is in quotes and has the form of a name, and words with an underscore.
fn names_in(text: &str) -> Vec<String> {
    let mut names = Vec::new();
    for quote in ['\'', '"', '`'] {
        let pieces = text.split(quote).skip(1).filter(|piece| piece.len() <= NAME);
        pieces.for_each(|piece| names.extend(parts(piece)));
    }
    let words = text.split(|sign: char| !(sign.is_alphanumeric() || sign == '_'));
    names.extend(
        words
            .filter(|word| word.contains('_') && word.len() <= NAME)
            .map(str::to_owned),
    );
    names
}

/// Returns a name and the parts of its path: `response_format.type`, `messages[0].role`, `stream=true`.
fn parts(name: &str) -> Vec<String> {
    let is_name = |sign: char| sign.is_alphanumeric() || "_.[]=-".contains(sign);
    if name.is_empty() || name.len() > NAME || !name.chars().all(is_name) {
        return Vec::new();
    }
    let parts = name.split(['.', '[', ']', '=']).filter(|part| !part.is_empty());
    parts.chain([name]).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn complaint_names_parameters_only_in_known_places() {
        for (body, named) in [
            (
                r#"{"error": {"message": "No.", "param": "response_format"}}"#,
                &["response_format"][..],
            ),
            (
                r#"{"error": {"message": "No.", "param": "reasoning.effort"}}"#,
                &["reasoning", "effort"],
            ),
            (
                r#"{"detail": [{"loc": ["body", "seed"], "msg": "Extra inputs", "input": 7}]}"#,
                &["seed"],
            ),
            (
                r#"{"error": {"message": "Unknown name \"seed\": Cannot find field."}}"#,
                &["seed"],
            ),
            (
                r#"{"error": {"message": "`temperature` is deprecated for this model."}}"#,
                &["temperature"],
            ),
            (
                r#"{"error": {"message": "invalid temperature: only 1 is allowed"}}"#,
                &["temperature"],
            ),
            (r#"{"error": {"message": "top_p is not supported"}}"#, &["top_p"]),
            (
                r#"{"message": "\"stream=true\" with structured outputs is not supported"}"#,
                &["stream"],
            ),
            (
                r#"{"error": {"message": "x", "metadata": {"raw": "{\"error\": {\"param\": \"seed\"}}"}}}"#,
                &["seed"],
            ),
            (
                r#"{"error": {"message": "Error from provider: {\"error\": {\"message\": \"'seed'\"}}"}}"#,
                &["seed"],
            ),
            (
                "Failed to deserialize: response_format: missing field `value` at line 1",
                &["response_format"],
            ),
        ] {
            let complaint = Complaint::of(body);
            for name in named {
                assert!(complaint.names(&[name]), "{body}: {complaint:?}");
            }
        }
        // Words of the request that the body repeats, and words that only contain a name.
        for body in [
            r#"{"error": {"message": "Provider upstream failed to proceed"}}"#,
            r#"{"error": {"message": "Filtered: set the temperature to 20, water the seed, follow the stream"}}"#,
            r#"{"error": {"message": "Bad request"}, "request": {"temperature": 0, "seed": 1, "stream": true}}"#,
            r#"{"detail": [{"loc": ["body", "messages"], "msg": "no", "input": "temperature, seed, stream, top_p"}]}"#,
        ] {
            let complaint = Complaint::of(body);
            assert!(
                !complaint.names(&["temperature", "seed", "stream", "top_p"]),
                "{body}: {complaint:?}"
            );
        }
    }

    #[test]
    fn a_message_is_found_in_the_forms_of_servers() {
        for (body, message, status) in [
            (
                r#"{"error": {"message": "No credit", "code": 402}}"#,
                "No credit",
                Some(402),
            ),
            (r#"{"error": "model not found"}"#, "model not found", None),
            (r#"[{"error": {"message": "Bad key"}}]"#, "Bad key", None),
            (
                r#"{"detail": {"msg": "Server is busy", "type": "service_unavailable"}}"#,
                "Server is busy",
                None,
            ),
            (
                r#"{"base_resp": {"status_code": 1008, "status_msg": "insufficient balance"}}"#,
                "insufficient balance",
                None,
            ),
            (
                r#"{"type": "error", "error": {"type": "overloaded_error", "message": "Overloaded"}}"#,
                "Overloaded",
                Some(529),
            ),
            (
                r#"{"error": {"message": "Provider returned error", "code": 429, "metadata": {"raw": "m is limited upstream"}}}"#,
                "Provider returned error: m is limited upstream",
                Some(429),
            ),
            ("Bad Gateway", "Bad Gateway", None),
            (r#"{"status": 7}"#, r#"{"status": 7}"#, None),
        ] {
            let complaint = Complaint::of(body);
            assert_eq!(
                (complaint.message.as_str(), complaint.status),
                (message, status),
                "{body}"
            );
        }
    }
}
