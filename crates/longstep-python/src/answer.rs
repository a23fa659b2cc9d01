//! Answers: the JSON object of `plan`, `verify`, `repair` and `solve`, with its usual parts as attributes.

use longstep::report::{Answer as Report, Status};
use pyo3::prelude::*;

use crate::failure::{Failure, FailureKind};
use crate::finding::{Edit, Violation};
use crate::json;
use crate::picture;
use crate::plan::Plan;
use crate::step::Step;

/// The answer to a request. Immutable.
#[pyclass(frozen, module = "longstep")]
pub(crate) struct Answer {
    report: Report,
    plan: Option<Py<Plan>>,
    offer: Option<Py<Plan>>,
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

    /// The verified plan that a session offers with the question; none without one.
    ///
    /// It is not what was asked for: it leaves out a part of the instruction, or the model asks about it. It is for the person
    /// who answers the question, and `Session.accept(consent=True)` accepts it.
    #[getter]
    fn offer(&self, py: Python<'_>) -> Option<Py<Plan>> {
        self.offer.as_ref().map(|plan| plan.clone_ref(py))
    }

    /// Returns the verified plan.
    fn verified(slf: &Bound<'_, Self>) -> PyResult<Py<Plan>> {
        let plan = slf.get().plan(slf.py());
        plan.ok_or_else(|| slf.get().without_plan(slf).into())
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
        match self.report.status {
            Status::Verified => format!("<longstep.Answer verified: {} steps>", self.report.steps.len()),
            _ => format!("<longstep.Answer {}: {}>", self.status_name(), self.sentence()),
        }
    }
}

impl Answer {
    pub(crate) fn new(py: Python<'_>, report: Report, plan: Option<Plan>) -> PyResult<Self> {
        let plan = plan.map(|plan| Py::new(py, plan)).transpose()?;
        Ok(Self {
            report,
            plan,
            offer: None,
        })
    }

    /// Adds the plan that is offered with the question.
    pub(crate) fn offering(self, py: Python<'_>, plan: Option<Plan>) -> PyResult<Self> {
        let offer = plan.map(|plan| Py::new(py, plan)).transpose()?;
        Ok(Self { offer, ..self })
    }

    /// Returns the failure of a caller that needs the verified plan.
    fn without_plan(&self, own: &Bound<'_, Self>) -> Failure {
        let kind = match self.report.status {
            Status::Unsolvable => FailureKind::Unsolvable,
            Status::GaveUp => FailureKind::GaveUp,
            Status::Question => FailureKind::Question,
            Status::Verified | Status::Invalid => FailureKind::NotValid,
        };
        Failure::new(kind, self.sentence())
            .hint(self.hint())
            .answer(own.clone().into_any().unbind())
    }

    /// Returns the outcome in one sentence: the question, the violations, or the status.
    fn sentence(&self) -> String {
        match self.report.status {
            Status::Question => self.report.plan.question.clone(),
            _ => self.report.sentence(),
        }
    }

    /// Returns the next step for the user, if there is one.
    fn hint(&self) -> Option<String> {
        match self.report.status {
            Status::Invalid => Some("`longstep.repair` may mend the plan".to_owned()),
            Status::GaveUp => Some("pass a larger `effort`".to_owned()),
            Status::Unsolvable => self.report.notes.first().cloned(),
            Status::Question if self.offer.is_some() => Some(
                "show `answer.offer` with the question; then `Session.accept(consent=True)` or `cancel()`".to_owned(),
            ),
            Status::Verified | Status::Question => None,
        }
    }
}
