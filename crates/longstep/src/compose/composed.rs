//! A composition as one plan, verified and mended like any other.

use super::Inlined;
use crate::environment::World;
use crate::model::Domain;
use crate::plan::{Draft, PlanFile, TaskCohesion};
use crate::repair::Outcome;
use crate::report::Answer;
use crate::report::Assessment;
use crate::verify::VerifiedPlan;

/// A composition with the steps of its plans, resolved in the world as it is now.
#[derive(Debug, Clone)]
pub struct Composed<'a> {
    /// The composition as a plan that somebody wrote.
    pub assessment: Assessment<'a>,
    /// For each step: the stored plan that it comes from.
    origins: Vec<Option<String>>,
}

impl<'a> Composed<'a> {
    /// Resolves a composition; `instruction` is what was asked for.
    pub fn new(domain: &'a Domain, world: &'a World, inlined: Inlined, instruction: &str) -> Self {
        let file = PlanFile {
            task_cohesion: TaskCohesion::from_written(inlined.written),
            environment_before: Some(world.environment.clone()),
            environment_after: None,
            endings: Vec::new(),
            instruction_summary: instruction.to_owned(),
            question: String::new(),
        };
        let draft = Draft {
            file,
            leniencies: Vec::new(),
        };
        Self {
            assessment: Assessment::new(domain, world, draft, None),
            origins: inlined.origins,
        }
    }

    /// The answer to the composition as it stands. What is wrong is told with the stored plans that it is about.
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

    /// The composition as it stands, if it is valid.
    pub fn verified(&self) -> Option<VerifiedPlan> {
        self.assessment.verified()
    }

    /// The answer after the least change that makes it valid, if there is one; else what is wrong with it.
    pub fn mended(&self) -> Answer {
        match self.assessment.repair() {
            Outcome::Repaired(_) => self.assessment.repaired(),
            _ => self.verdict(),
        }
    }
}
