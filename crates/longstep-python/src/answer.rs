//! Answers: the JSON object of `plan`, `verify`, `repair` and `solve`, with its usual parts as attributes.

use std::collections::HashMap;

use longstep::report::{Answer as Report, EditAnswer, Status, StepAnswer, ViolationAnswer};
use pyo3::prelude::*;

use crate::failure::Failure;
use crate::json;
use crate::picture;
use crate::plan::Plan;

/// The answer to a request. Immutable.
#[pyclass(frozen, module = "longstep")]
pub(crate) struct Answer {
    report: Report,
    plan: Option<Py<Plan>>,
}

#[pymethods]
impl Answer {
    /// The outcome: `verified`, `invalid`, `unsolvable`, `gave_up` or `question`.
    #[getter(status)]
    fn status_name(&self) -> &'static str {
        match self.report.status {
            Status::Verified => "verified",
            Status::Invalid => "invalid",
            Status::Unsolvable => "unsolvable",
            Status::GaveUp => "gave_up",
            Status::Question => "question",
        }
    }

    /// True if there is a verified plan.
    #[getter]
    fn is_verified(&self) -> bool {
        self.report.status == Status::Verified
    }

    /// The verified plan; none if there is none.
    #[getter]
    fn plan(&self, py: Python<'_>) -> Option<Py<Plan>> {
        self.plan.as_ref().map(|plan| plan.clone_ref(py))
    }

    /// Returns the verified plan.
    fn verified(slf: &Bound<'_, Self>) -> PyResult<Py<Plan>> {
        let plan = slf.get().plan(slf.py());
        plan.ok_or_else(|| Failure::without_plan(slf).into())
    }

    /// The steps with all arguments, also those of an invalid plan.
    #[getter]
    fn steps(&self) -> Vec<Step> {
        self.report.steps.iter().cloned().map(Step::from).collect()
    }

    /// The goal, with identifiers of the environment.
    #[getter]
    fn goal(&self) -> Vec<String> {
        self.report.goal.clone()
    }

    /// The violations of the plan.
    #[getter]
    fn violations(&self) -> Vec<Violation> {
        self.report.violations.iter().map(Violation::from).collect()
    }

    /// The edits of a repair, in plan order.
    #[getter]
    fn edits(&self) -> Vec<Edit> {
        self.report.edits.iter().map(Edit::from).collect()
    }

    /// The question to the person; empty without one.
    #[getter]
    fn question(&self) -> &str {
        &self.report.plan.question
    }

    /// The parts of the instruction that the plan ignores.
    #[getter]
    fn not_represented(&self) -> Vec<String> {
        let gaps = self.report.not_represented.iter();
        gaps.map(|gap| gap.text.clone()).collect()
    }

    /// The assumptions behind the outcome.
    #[getter]
    fn assumptions(&self) -> Vec<String> {
        self.report.assumptions.clone()
    }

    /// Remarks that do not affect the outcome.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.report.notes.clone()
    }

    /// Returns the answer as JSON: the text that the program prints with `--json`.
    fn json(&self) -> PyResult<String> {
        Ok(json::pretty(&self.report)?)
    }

    /// Returns the answer as a dict.
    fn dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::object(py, &self.report)
    }

    fn _repr_svg_(&self, py: Python<'_>) -> Option<String> {
        let plan = self.plan.as_ref()?;
        Some(plan.get().svg_of_width(py, picture::WIDTH))
    }

    fn __str__(&self) -> String {
        self.sentence()
    }

    fn __repr__(&self) -> String {
        format!(
            "<longstep.Answer {}: {} steps>",
            self.status_name(),
            self.report.steps.len()
        )
    }
}

impl Answer {
    pub(crate) fn new(py: Python<'_>, report: Report, plan: Option<Plan>) -> PyResult<Self> {
        let plan = plan.map(|plan| Py::new(py, plan)).transpose()?;
        Ok(Self { report, plan })
    }

    pub(crate) fn status(&self) -> Status {
        self.report.status
    }

    /// Returns the outcome in one sentence: the question, the violations, or the status.
    pub(crate) fn sentence(&self) -> String {
        match self.report.status {
            Status::Question => self.report.plan.question.clone(),
            _ => self.report.sentence(),
        }
    }

    /// Returns the next step for the user, if there is one.
    pub(crate) fn hint(&self) -> Option<String> {
        match self.report.status {
            Status::Invalid => Some("`longstep.repair` may mend the plan".to_owned()),
            Status::GaveUp => Some("pass a larger `effort`".to_owned()),
            Status::Unsolvable => self.report.notes.first().cloned(),
            Status::Verified | Status::Question => None,
        }
    }
}

/// A step of a plan.
#[pyclass(frozen, get_all, module = "longstep")]
pub(crate) struct Step {
    /// Index in the plan, from 0.
    index: usize,
    /// Name of the call.
    action: String,
    /// Arguments that the call shows.
    arguments: Vec<String>,
    /// Arguments that the call hides, by the name of the parameter.
    implicit: HashMap<String, String>,
    /// The hand, arm or robot; none if the domain has only one or the step takes several.
    arm: Option<String>,
    /// Description of the step.
    explanation: String,
}

impl From<StepAnswer> for Step {
    fn from(step: StepAnswer) -> Self {
        Self {
            index: step.index,
            action: step.action,
            arguments: step.arguments,
            implicit: step.implicit.into_iter().collect(),
            arm: step.arm,
            explanation: step.explanation,
        }
    }
}

#[pymethods]
impl Step {
    fn __str__(&self) -> String {
        format!("{}({})", self.action, self.arguments.join(", "))
    }

    fn __repr__(&self) -> String {
        format!("<longstep.Step {}: {}>", self.index, self.__str__())
    }
}

/// A violation of a plan.
#[pyclass(frozen, get_all, module = "longstep")]
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
#[pyclass(frozen, get_all, module = "longstep")]
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
