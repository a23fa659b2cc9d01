//! Verified plans.

use std::collections::BTreeMap;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use longstep::Goal;
use longstep::domain::Domain as LoadedDomain;
use longstep::report::Answer as Report;
use longstep_core::execution::{Aim, plan_hash};
use longstep_core::plan::{PlanFile, outline};
use longstep_core::repair::Edit;
use longstep_core::search;
use longstep_core::verify::{Purpose, VerifiedPlan};
use longstep_picture::plan::Annotations;
use pyo3::prelude::*;

use crate::failure::Failure;
use crate::interpreter::detach;
use crate::json;
use crate::notation::Notation;
use crate::picture;
use crate::step::Step;
use crate::world::World;

/// A plan that was simulated from its first step to its last without a violation. Immutable; it cannot be constructed, but
/// comes from an answer or a session. Plans with the same `hash` are equal.
#[pyclass(frozen, eq, hash, module = "longstep", sequence)]
pub(crate) struct Plan {
    pub(crate) plan: VerifiedPlan,
    domain: Arc<LoadedDomain>,
    file: PlanFile,
    /// The goal, with identifiers of the environment.
    goal: Vec<String>,
    purpose: Purpose,
    annotations: Annotations,
    edits: Vec<Edit>,
}

/// Plans with the same hash are equal.
impl PartialEq for Plan {
    fn eq(&self, other: &Self) -> bool {
        self.hash() == other.hash()
    }
}

impl Hash for Plan {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        Plan::hash(self).hash(hasher);
    }
}

#[pymethods]
impl Plan {
    /// The steps with all arguments, in reading order.
    #[getter]
    fn steps(&self) -> Vec<Step> {
        let report = Report::of_report(self.plan.world(), self.plan.report(), None, "");
        report.steps.into_iter().map(Step::from).collect()
    }

    /// The lines of the plan with its branches, loops and lanes, indented.
    #[getter]
    fn outline(&self) -> Vec<String> {
        let lines = outline(self.plan.world(), self.plan.plan()).into_iter();
        let line = |depth: usize, text: &str| format!("{}{text}", "  ".repeat(depth));
        lines
            .map(|own| match own.step {
                Some(_) => line(own.depth, &format!("{}  {}", own.text, own.explanation)),
                None => line(own.depth, &own.text),
            })
            .collect()
    }

    /// The goal, with identifiers of the environment; empty for a plan without one.
    #[getter]
    fn goal(&self) -> Vec<String> {
        self.goal.clone()
    }

    /// The words of the instruction that the plan ignores.
    #[getter]
    pub(crate) fn left_out(&self) -> Vec<String> {
        self.file.not_in_plan.clone()
    }

    /// The hash of the steps with all arguments, of the world before them with its rules, and of the goal: the one that an
    /// approval on a server names.
    #[getter]
    pub(crate) fn hash(&self) -> String {
        plan_hash(&self.plan, &self.goal)
    }

    /// The world before the plan.
    #[getter]
    fn world(&self) -> World {
        self.world_of(self.plan.world().clone())
    }

    /// The worlds after the plan: one for each way in which sensing lets it end.
    #[getter]
    fn endings(&self) -> Vec<World> {
        let endings = self.plan.endings().iter();
        endings
            .map(|ending| self.world_of(self.plan.world().after(ending)))
            .collect()
    }

    /// Returns the plan as JSON, as `longstep plan --save` writes it; `longstep run` reads it.
    pub(crate) fn json(&self) -> PyResult<String> {
        let file = self.file.clone().of_domain(&self.domain);
        let text = serde_json::to_string_pretty(&file).map_err(|error| Failure::failed(error.to_string()))?;
        Ok(text)
    }

    /// Returns the plan as a dict.
    fn dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::parse(py, &self.json()?)
    }

    /// Returns the steps in PDDL, one `(action argument ...)` a line.
    ///
    /// Raises `Unreadable` for a plan with branches, loops or lanes.
    fn pddl(&self) -> PyResult<String> {
        Ok(self.notation().pddl()?)
    }

    /// Returns the texts of `domain.pddl`, `problem.pddl` and `plan.pddl`, by these names: the input of a validator such as VAL.
    ///
    /// `name` is the name of the problem. Raises `Unreadable` for a plan or a goal that PDDL cannot say.
    #[pyo3(signature = (*, name="task"))]
    fn pddl_task(&self, py: Python<'_>, name: &str) -> PyResult<BTreeMap<&'static str, String>> {
        Ok(detach(py, || self.notation().pddl_task(name))?)
    }

    /// Returns the plan as a behavior tree of BehaviorTree.CPP 4; with `guards`, each step checks its precondition first.
    ///
    /// Raises `Unreadable` for a plan that no behavior tree can have.
    #[pyo3(signature = (*, guards=false))]
    fn behavior_tree(&self, py: Python<'_>, guards: bool) -> PyResult<String> {
        Ok(detach(py, || self.notation().behavior_tree(guards))?)
    }

    /// Returns the plan in the paper's Python notation, with `if` and `while`.
    fn script(&self) -> String {
        self.notation().script()
    }

    /// Returns a flowchart for Mermaid.
    fn mermaid(&self, py: Python<'_>) -> String {
        detach(py, || self.notation().mermaid())
    }

    /// Returns a flowchart for Graphviz.
    fn dot(&self, py: Python<'_>) -> String {
        detach(py, || self.notation().dot())
    }

    /// Returns a picture of the world before the plan beside each one that the plan can end in; the width is in pixels.
    #[pyo3(signature = (*, width=720.0))]
    fn scene(&self, py: Python<'_>, width: f64) -> String {
        detach(py, || self.notation().scene(width, &self.file.instruction_summary))
    }

    /// Returns a picture of the steps with their reasons; the width is in pixels.
    #[pyo3(signature = (*, width=720.0))]
    fn svg(&self, py: Python<'_>, width: f64) -> String {
        self.svg_of_width(py, width)
    }

    fn _repr_svg_(&self, py: Python<'_>) -> String {
        self.svg(py, picture::WIDTH)
    }

    fn __len__(&self) -> usize {
        self.plan.steps().len()
    }

    fn __str__(&self) -> String {
        self.outline().join("\n")
    }

    fn __repr__(&self) -> String {
        format!(
            "<longstep.Plan {}: {} steps>",
            self.domain.name,
            self.plan.steps().len()
        )
    }
}

/// Returns words of an instruction in quotation marks.
pub(crate) fn quoted(words: &[String]) -> String {
    let words: Vec<String> = words.iter().map(|words| format!("\"{words}\"")).collect();
    words.join(", ")
}

impl Plan {
    pub(crate) fn new(domain: &Arc<LoadedDomain>, plan: VerifiedPlan, file: PlanFile) -> Self {
        Self {
            plan,
            domain: Arc::clone(domain),
            file,
            goal: Vec::new(),
            purpose: Purpose::default(),
            annotations: Annotations::default(),
            edits: Vec::new(),
        }
    }

    /// Sets the goal for which the plan was made.
    pub(crate) fn for_goal(self, goal: Option<&Goal>) -> Self {
        let Some(goal) = goal else { return self };
        let world = self.plan.world().clone();
        Self {
            goal: goal.exact(&world),
            purpose: goal.purpose(&world),
            annotations: self.annotations.with_goal(&world, goal),
            ..self
        }
    }

    /// Sets the words of the instruction that the plan ignores.
    pub(crate) fn leaving_out(self, words: &[String]) -> Self {
        let file = PlanFile {
            not_in_plan: words.to_vec(),
            ..self.file
        };
        Self { file, ..self }
    }

    /// Sets conditions that hold at the end: the goal of a PDDL problem.
    pub(crate) fn wanting(self, wanted: &[search::Wanted]) -> Self {
        let purpose = Purpose {
            wanted: wanted.to_vec(),
            ..Purpose::default()
        };
        Self {
            annotations: self.annotations.with_purpose(purpose.clone()),
            purpose,
            ..self
        }
    }

    /// Sets the edits of the repair that the plan comes from.
    pub(crate) fn with_edits(self, edits: &[Edit]) -> Self {
        Self {
            edits: edits.to_vec(),
            ..self
        }
    }

    /// Returns what an execution pursues when the world changes.
    pub(crate) fn aim(&self) -> Aim {
        Aim::from((!self.goal.is_empty()).then(|| self.goal.join(" & ")))
    }

    pub(crate) fn world_of(&self, world: longstep_core::environment::World) -> World {
        World {
            world,
            domain: Arc::clone(&self.domain),
        }
    }

    pub(crate) fn domain(&self) -> &Arc<LoadedDomain> {
        &self.domain
    }

    /// Returns the name with which the domain of the plan is loaded again.
    pub(crate) fn origin(&self) -> &str {
        &self.domain.origin
    }

    pub(crate) fn svg_of_width(&self, py: Python<'_>, width: f64) -> String {
        detach(py, || {
            let annotations = self.annotations.clone().with_edits(&self.edits);
            picture::plan(&self.plan, &annotations, width, &self.file.instruction_summary)
        })
    }

    fn notation(&self) -> Notation<'_> {
        Notation {
            plan: &self.plan,
            purpose: &self.purpose,
            annotations: &self.annotations,
        }
    }
}
