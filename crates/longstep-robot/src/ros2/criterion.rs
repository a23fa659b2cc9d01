//! Criteria: what the fields of a message must be, `{ success = true, width = { below = 0.05 } }`.

use serde_json::{Map, Value};

use super::template::at;

/// A condition on the fields of a message: all of its parts must hold.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Criterion(Vec<(String, Test)>);

/// A condition on one field.
#[derive(Debug, Clone, PartialEq)]
enum Test {
    Is(Value),
    Not(Value),
    OneOf(Vec<Value>),
    Above(f64),
    Below(f64),
}

impl Criterion {
    /// Reads a criterion: values, or tables with `not`, `one_of`, `above` and `below`.
    ///
    /// # Errors
    ///
    /// The name of the field, and the reason.
    pub(super) fn read(fields: &Map<String, Value>) -> Result<Self, (String, String)> {
        let mut tests = Vec::new();
        for (path, value) in fields {
            let Value::Object(parts) = value else {
                tests.push((path.clone(), Test::Is(value.clone())));
                continue;
            };
            let wrong = |reason: String| (path.clone(), reason);
            if parts.is_empty() {
                return Err(wrong("an empty table tests nothing".to_owned()));
            }
            for (name, value) in parts {
                let number = || {
                    value
                        .as_f64()
                        .ok_or_else(|| wrong(format!("`{name}` needs a number, not `{value}`")))
                };
                let test = match (name.as_str(), value) {
                    ("not", _) => Test::Not(value.clone()),
                    ("one_of", Value::Array(values)) => Test::OneOf(values.clone()),
                    ("one_of", _) => return Err(wrong("`one_of` needs a list".to_owned())),
                    ("above", _) => Test::Above(number()?),
                    ("below", _) => Test::Below(number()?),
                    _ => return Err(wrong(format!("unknown test `{name}`; use not, one_of, above or below"))),
                };
                tests.push((path.clone(), test));
            }
        }
        Ok(Self(tests))
    }

    /// Returns true if the message fits. A field that the message lacks fits nothing.
    pub(super) fn holds(&self, message: &Value) -> bool {
        self.0.iter().all(|(path, test)| {
            let Some(value) = at(message, path) else {
                return false;
            };
            match test {
                Test::Is(expected) => is(value, expected),
                Test::Not(other) => !is(value, other),
                Test::OneOf(values) => values.iter().any(|own| is(value, own)),
                Test::Above(bound) => value.as_f64().is_some_and(|number| number > *bound),
                Test::Below(bound) => value.as_f64().is_some_and(|number| number < *bound),
            }
        })
    }
}

/// Compares two values; numbers by their size, so that `1` is `1.0`.
fn is(value: &Value, expected: &Value) -> bool {
    match (value.as_f64(), expected.as_f64()) {
        (Some(value), Some(expected)) => value == expected,
        _ => value == expected,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn criterion_compares_fields_of_a_message() {
        let message = json!({"success": true, "width": 0.04, "count": 1, "name": "cup", "deep": {"x": [5]}});
        for (criterion, expected) in [
            (json!({}), true),
            (json!({"success": true}), true),
            (json!({"success": false}), false),
            (json!({"count": 1.0}), true),
            (json!({"width": {"above": 0.03, "below": 0.05}}), true),
            (json!({"width": {"above": 0.04}}), false),
            (json!({"name": {"not": ""}, "deep.x.0": 5}), true),
            (json!({"name": {"one_of": ["pen", "cup"]}}), true),
            (json!({"missing": {"not": 1}}), false),
            (json!({"name": {"above": 1}}), false),
        ] {
            let read = Criterion::read(criterion.as_object().unwrap()).unwrap();
            assert_eq!(read.holds(&message), expected, "{criterion}");
        }
        for wrong in [
            json!({"a": {}}),
            json!({"a": {"over": 1}}),
            json!({"a": {"above": "x"}}),
            json!({"a": {"one_of": 1}}),
        ] {
            assert!(Criterion::read(wrong.as_object().unwrap()).is_err(), "{wrong}");
        }
    }
}
