//! A composition as one plan, which is verified and repaired like any other.

use super::Inlined;
use crate::environment::World;
use crate::plan::{Draft, PlanFile, TaskCohesion};
use crate::repair::RepairOutcome;
use crate::report::{Answer, Assessment};
use crate::verify::VerifiedPlan;

/// A composition with its stored plans inlined, resolved in the current world.
#[derive(Debug, Clone)]
pub struct Composed<'a> {
    /// The assessment of the resulting plan.
    pub assessment: Assessment<'a>,
    /// For each step, the name of the stored plan that it comes from.
    origins: Vec<Option<String>>,
}

impl<'a> Composed<'a> {
    /// Resolves a composition. `instruction` becomes the summary of the plan.
    pub fn new(world: &'a World, inlined: Inlined, instruction: &str) -> Self {
        let file = PlanFile {
            environment_before: Some(world.environment().clone()),
            instruction_summary: instruction.to_owned(),
            ..PlanFile::from(TaskCohesion::from_written(inlined.written))
        };
        let draft = Draft {
            file,
            leniencies: Vec::new(),
        };
        Self {
            assessment: Assessment::new(world, draft, None),
            origins: inlined.origins,
        }
    }

    /// Returns the answer without repair. Each violation message names the stored plans of the steps that it mentions.
    pub fn verdict(&self) -> Answer {
        let mut answer = self.assessment.verdict();
        for violation in &mut answer.violations {
            let about = [violation.step, violation.undone_by].into_iter().flatten();
            let parts: Vec<String> = about
                .filter_map(|step| {
                    let origin = self.origins.get(step)?.as_ref()?;
                    Some(format!("step {} is of `{origin}`", step + 1))
                })
                .collect();
            if !parts.is_empty() {
                violation.message.push_str(&format!(" ({})", parts.join(", ")));
            }
        }
        answer
    }

    /// Returns the plan without repair, if it is valid.
    pub fn verified(&self) -> Option<VerifiedPlan> {
        self.assessment.verified()
    }

    /// Returns the answer after the cheapest repair, or the verdict without repair if there is none.
    pub fn mended(&self) -> Answer {
        match self.assessment.repair() {
            RepairOutcome::Repaired(_) => self.assessment.repaired(),
            _ => self.verdict(),
        }
    }
}
