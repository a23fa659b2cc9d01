//! A composition as one plan, verified and mended like any other.

use super::Inlined;
use crate::answer::Answer;
use crate::attempt::Attempt;
use crate::domain::Domain;
use crate::plan::{Draft, PlanFile, TaskCohesion};
use crate::repair::{Outcome, Pins};
use crate::verify::VerifiedPlan;
use crate::world::World;

/// A composition with the steps of its plans, resolved in the world as it is now.
#[derive(Debug, Clone)]
pub struct Composed {
    /// It as a plan that somebody wrote.
    pub attempt: Attempt,
    /// For each step: the stored plan that it comes from.
    origins: Vec<Option<String>>,
}

impl Composed {
    /// Resolves a composition; `instruction` is what was asked for.
    pub fn new(domain: &Domain, world: &World, inlined: Inlined, instruction: &str) -> Self {
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
            attempt: Attempt::new(domain, world, draft, None),
            origins: inlined.origins,
        }
    }

    /// The answer to the composition as it stands. What is wrong is told with the stored plans that it is about.
    pub fn verdict(&self, domain: &Domain, world: &World) -> Answer {
        let mut answer = self.attempt.verdict(domain, world);
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
    pub fn verified(&self, domain: &Domain, world: &World) -> Option<VerifiedPlan> {
        self.attempt.verified(domain, world)
    }

    /// The answer after the least change that makes it valid, if there is one; else what is wrong with it.
    pub fn mended(&self, domain: &Domain, world: &World) -> Answer {
        match self.attempt.repair(domain, world, &Pins::default()) {
            outcome @ Outcome::Repaired(_) => self.attempt.repaired(domain, world, outcome),
            _ => self.verdict(domain, world),
        }
    }
}
