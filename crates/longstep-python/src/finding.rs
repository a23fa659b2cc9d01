//! Violations of plans, and edits of repairs.

use longstep::report::{EditAnswer, ViolationAnswer};
use pyo3::prelude::*;

/// A violation of a plan.
#[derive(PartialEq, Eq, Hash)]
#[pyclass(frozen, eq, hash, get_all, module = "longstep")]
pub(crate) struct Violation {
    /// Kind, for example `precondition`.
    kind: String,
    /// Index of the step, from 0; none for the plan as a whole.
    step: Option<usize>,
    /// Call of that step.
    action: Option<String>,
    /// Missing facts, as sentences.
    missing: Vec<String>,
    /// Index of the step that removed them, from 0.
    undone_by: Option<usize>,
    /// Sensing outcomes of the branches with this violation; empty if it occurs on every branch.
    when: Vec<String>,
    /// The violation as one sentence.
    message: String,
}

impl From<&ViolationAnswer> for Violation {
    fn from(violation: &ViolationAnswer) -> Self {
        Self {
            kind: violation.kind.to_owned(),
            step: violation.step,
            action: violation.action.clone(),
            missing: violation.missing.clone(),
            undone_by: violation.undone_by,
            when: violation.when.clone(),
            message: violation.message.clone(),
        }
    }
}

#[pymethods]
impl Violation {
    fn __str__(&self) -> &str {
        &self.message
    }

    fn __repr__(&self) -> String {
        format!("<longstep.Violation {}: {}>", self.kind, self.message)
    }
}

/// An edit of a repair.
#[derive(PartialEq, Eq, Hash)]
#[pyclass(frozen, eq, hash, get_all, module = "longstep")]
pub(crate) struct Edit {
    /// `insert`, `drop`, `replace` or `move`.
    kind: String,
    /// Index in the repaired plan, from 0: of the new step, or of the position of a dropped one.
    at: usize,
    /// The call before the edit; none for an insertion.
    before: Option<String>,
    /// The call after the edit; none for a dropped step.
    after: Option<String>,
    /// The reason, in one sentence.
    why: String,
}

impl From<&EditAnswer> for Edit {
    fn from(edit: &EditAnswer) -> Self {
        Self {
            kind: edit.kind.to_owned(),
            at: edit.at,
            before: edit.before.clone(),
            after: edit.after.clone(),
            why: edit.why.clone(),
        }
    }
}

#[pymethods]
impl Edit {
    fn __str__(&self) -> String {
        let call = |call: &Option<String>| call.clone().unwrap_or_default();
        match (&self.before, &self.after) {
            (None, after) => format!("insert {} ({})", call(after), self.why),
            (before, None) => format!("drop {} ({})", call(before), self.why),
            (Some(before), Some(after)) => format!("{} {before}: {after} ({})", self.kind, self.why),
        }
    }

    fn __repr__(&self) -> String {
        format!("<longstep.Edit {}>", self.__str__())
    }
}
