//! The skills file of a lesson: the values with their uncertainty and source, as `longstep run --skills` reads them.

use serde_json::{Map, Value, json};

use crate::lesson::{Lesson, TaughtStep};
use crate::request::Request;

/// Returns the skills file of a lesson.
///
/// A call that occurs once in the plan has an entry for its arguments. A call that occurs several times has an entry for
/// each of its steps, for the hand need not start at the same place again.
pub fn skills_file(requests: &[Request], lesson: &Lesson) -> Value {
    let mut file: Map<String, Value> = Map::new();
    for step in &lesson.steps {
        let Some(request) = requests.get(step.step - 1).filter(|_| !step.values.is_empty()) else {
            continue;
        };
        let is_same = |other: &&Request| other.action == request.action && other.arguments == request.arguments;
        let occurs = requests.iter().filter(is_same).count();
        let entries = file.entry(request.action.clone()).or_insert_with(|| json!([]));
        if let Value::Array(entries) = entries {
            entries.push(entry(request, step, occurs > 1));
        }
    }
    Value::Object(file)
}

fn entry(request: &Request, step: &TaughtStep, with_step: bool) -> Value {
    let mut entry = Map::new();
    entry.insert("arguments".to_owned(), json!(request.arguments));
    if with_step {
        entry.insert("step".to_owned(), json!(step.step));
    }
    let values = step.values.iter().map(|own| (own.parameter.clone(), own.value.clone()));
    entry.insert("values".to_owned(), Value::Object(values.collect()));
    let taught = step.values.iter().map(|own| {
        let mut origin = Map::new();
        if let Some(uncertainty) = own.uncertainty {
            origin.insert("uncertainty".to_owned(), json!(uncertainty));
        }
        if let Some(unit) = own.unit {
            origin.insert("unit".to_owned(), json!(unit));
        }
        origin.insert("source".to_owned(), json!(own.source));
        (own.parameter.clone(), Value::Object(origin))
    });
    entry.insert("taught".to_owned(), Value::Object(taught.collect()));
    Value::Object(entry)
}
