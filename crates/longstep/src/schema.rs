//! JSON Schemas of the prompts of a domain.
//!
//! ```
//! assert!(longstep::schema::plans()["properties"]["example"].is_object());
//! ```

use serde_json::Value;

use crate::dialogue::plans_schema;
use crate::load::{examples_schema, feedback_schema};

/// Returns the schema of `prompt/plans.toml`.
pub fn plans() -> Value {
    plans_schema()
}

/// Returns the schema of `prompt/feedback.toml`.
pub fn feedback() -> Value {
    feedback_schema()
}

/// Returns the schema of `prompt/examples.toml`.
pub fn examples() -> Value {
    examples_schema()
}
