//! What has been accepted.

use super::StepRecord;
use crate::environment::{EntityId, World};
use crate::goal::Goal;
use crate::model::Domain;
use crate::plan::{self, PlanFile, Step, TaskCohesion};
use crate::verify::{Ending, VerifiedPlan};

/// An instruction that was carried through.
#[derive(Debug, Clone)]
pub struct Accepted {
    /// What was asked for.
    pub instruction: String,
    /// The world before.
    pub before: World,
    /// What was done.
    pub plan: VerifiedPlan,
    /// The goal that it was made for, if it was made for one.
    pub goal: Option<Goal>,
}

impl Accepted {
    /// The plan as it is saved, with the environments that it can lead to.
    pub(super) fn file(&self, domain: &Domain) -> PlanFile {
        let environment = |ending: &Ending| self.before.after(domain, ending).environment;
        let (environment_after, endings) = plan::endings(domain, &self.before, self.plan.endings(), environment);
        PlanFile {
            task_cohesion: TaskCohesion::new(domain, &self.before, self.plan.plan()),
            environment_before: Some(self.before.environment.clone()),
            environment_after,
            endings,
            instruction_summary: self.instruction.clone(),
            question: String::new(),
        }
    }

    pub(super) fn goal_texts(&self, domain: &Domain) -> Vec<String> {
        let facts = self.goal.iter().flat_map(|goal| &goal.facts);
        facts.map(|fact| fact.exact(domain, &self.before)).collect()
    }

    /// What the instruction was about: the subjects of its goal, or what was handled.
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
