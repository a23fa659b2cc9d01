//! Accepted plans.

use super::StepRecord;
use crate::environment::{EntityId, World};
use crate::goal::Goal;
use crate::model::Domain;
use crate::plan::{self, PlanFile, PurposeFile, Step, TaskCohesion};
use crate::verify::{Ending, VerifiedPlan};

/// An instruction with its accepted plan.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Accepted {
    /// The instruction.
    pub instruction: String,
    /// The world before the plan.
    pub before: World,
    /// The plan.
    pub plan: VerifiedPlan,
    /// Its goal, if it has one.
    pub goal: Option<Goal>,
    /// The words of the instruction that the plan does not say.
    pub not_in_plan: Vec<String>,
}

impl Accepted {
    /// Returns the plan in its saved form, with all possible final environments.
    pub(super) fn file(&self) -> PlanFile {
        let environment = |ending: &Ending| self.before.after(ending).environment().clone();
        let (environment_after, endings) = plan::endings(&self.before, self.plan.endings(), environment);
        PlanFile {
            task_cohesion: TaskCohesion::new(&self.before, self.plan.plan()),
            environment_before: Some(self.before.environment().clone()),
            environment_after,
            endings,
            instruction_summary: self.instruction.clone(),
            question: String::new(),
            not_in_plan: self.not_in_plan.clone(),
            purpose: PurposeFile::new(&self.before, &self.goal_texts()),
            domain: None,
        }
    }

    pub(super) fn goal_texts(&self) -> Vec<String> {
        self.goal.iter().flat_map(|goal| goal.exact(&self.before)).collect()
    }

    /// Returns the entities that a pronoun can refer to: the subjects of the goal, or else the handled objects.
    pub(super) fn subjects(&self, domain: &Domain) -> Vec<EntityId> {
        let mut subjects: Vec<EntityId> = match &self.goal {
            Some(goal) => goal.facts.iter().filter_map(|fact| fact.subject(domain)).collect(),
            None => self
                .plan
                .steps()
                .iter()
                .filter_map(|step| step.object(domain))
                .collect(),
        };
        subjects.sort_unstable();
        subjects.dedup();
        subjects
    }

    pub(super) fn steps(&self, domain: &Domain) -> Vec<StepRecord> {
        let record = |step: &Step| StepRecord {
            action: domain.action(step.action).name.clone(),
            arguments: step
                .arguments
                .iter()
                .map(|id| self.before.entity(*id).identifier.clone())
                .collect(),
            explanation: step.explanation.clone(),
        };
        self.plan.steps().iter().map(record).collect()
    }
}
