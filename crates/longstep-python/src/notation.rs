//! A plan in the notations of other programs, with the bytes of `longstep export`.

use std::collections::BTreeMap;

use longstep_core::pddl::{self, SolvedTask, WriteError};
use longstep_core::plan::behavior_tree::{self, Guards};
use longstep_core::plan::{Written, script};
use longstep_core::verify::{Purpose, VerifiedPlan};
use longstep_core::visible;
use longstep_picture::SvgOptions;
use longstep_picture::plan::{Annotations, Diagram, dot, mermaid};
use longstep_picture::scene;

use crate::failure::Failure;

/// A plan with its purpose, for other notations.
pub(crate) struct Notation<'a> {
    pub(crate) plan: &'a VerifiedPlan,
    pub(crate) purpose: &'a Purpose,
    pub(crate) annotations: &'a Annotations,
}

impl Notation<'_> {
    /// Returns the steps in PDDL.
    pub(crate) fn pddl(&self) -> Result<String, Failure> {
        if !self.plan.plan().is_sequence() {
            return Err(no_task(&WriteError::Branches));
        }
        Ok(text(&pddl::write_plan(self.plan.world(), self.plan.steps())))
    }

    /// Returns the texts of a domain, a problem and the plan, by the names of their files.
    pub(crate) fn pddl_task(&self, name: &str) -> Result<BTreeMap<&'static str, String>, Failure> {
        let task = SolvedTask::write(self.plan, self.purpose, name).map_err(|error| no_task(&error))?;
        Ok(task.files().map(|(name, text)| (name, text.to_owned())).into())
    }

    /// Returns the XML of BehaviorTree.CPP 4.
    pub(crate) fn behavior_tree(&self, guards: bool) -> Result<String, Failure> {
        let guards = if guards { Guards::Preconditions } else { Guards::None };
        let written = behavior_tree::write(self.plan.world(), self.plan.plan(), guards).map_err(|error| {
            Failure::unreadable(format!("no behavior tree can have this plan: {error}")).hint(error.hint().to_owned())
        })?;
        Ok(text(&written))
    }

    /// Returns the paper's Python notation.
    pub(crate) fn script(&self) -> String {
        text(&script::write(&Written::of_plan(self.plan.world(), self.plan.plan())))
    }

    /// Returns a flowchart for Mermaid.
    pub(crate) fn mermaid(&self) -> String {
        text(&mermaid(&self.diagram()))
    }

    /// Returns a flowchart for Graphviz.
    pub(crate) fn dot(&self) -> String {
        text(&dot(&self.diagram()))
    }

    /// Draws the world before the plan beside those after it.
    pub(crate) fn scene(&self, width: f64, title: &str) -> String {
        text(&scene::before_and_after(
            self.plan,
            &SvgOptions::new(width).with_title(title),
        ))
    }

    fn diagram(&self) -> Diagram {
        Diagram::of(self.plan, self.annotations)
    }
}

/// Returns a text with the escapes of foreign text, as the program prints it.
fn text(text: &str) -> String {
    visible::block(text).into_owned()
}

/// Returns the failure for a plan or a task without a form in PDDL.
fn no_task(error: &WriteError) -> Failure {
    let hint = match error {
        WriteError::Branches => "use `Plan.behavior_tree()`, `script()` or `json()`",
        _ => "`Plan.pddl()` has the steps alone",
    };
    Failure::unreadable(error.to_string()).hint(hint.to_owned())
}
