//! Steps of plans.

use std::collections::BTreeMap;

use longstep::report::StepAnswer;
use pyo3::prelude::*;

/// A step of a plan.
#[derive(PartialEq, Eq, Hash)]
#[pyclass(frozen, eq, hash, get_all, module = "longstep")]
pub(crate) struct Step {
    /// Index in the plan, from 0.
    index: usize,
    /// Name of the call.
    action: String,
    /// Arguments that the call shows.
    arguments: Vec<String>,
    /// Arguments that the call hides, by the name of the parameter.
    implicit: BTreeMap<String, String>,
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
