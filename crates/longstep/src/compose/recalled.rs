//! Stored plans with all arguments bound.

use super::{Misfit, Stored};
use crate::environment::{self, World};
use crate::json::Path;
use crate::plan::{Draft, Plan, Step, Written};
use crate::report::Assessment;
use longstep_core::model::Domain;

/// A stored plan, bound in the world that it was made for.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Recalled {
    /// The plan with all of its arguments, by identifier.
    pub(super) written: Written,
    /// Short description.
    pub(super) summary: String,
    /// Actors of its steps, by identifier, in order of first occurrence.
    pub(super) actors: Vec<String>,
    /// True if the domain has actors and some step has no single one.
    pub(super) joint: bool,
    /// Arguments of its steps other than actors, by identifier.
    pub(super) handled: Vec<String>,
}

impl Recalled {
    /// Binds a stored plan in the world of its file, or in `world` if its file has none.
    ///
    /// The plan need not be valid: a plan that grasps an object and keeps it breaks a rule alone, but can be part of a
    /// valid plan.
    pub(super) fn of(world: &World, stored: &Stored) -> Result<Self, Misfit> {
        let domain = world.domain();
        let unusable = |why: String| Misfit::Unusable {
            name: stored.name.clone(),
            why,
        };
        let own = match &stored.file.environment_before {
            Some(environment) => environment::read(domain, environment, "environment_before", "", &Path::default())
                .map_err(|findings| unusable(joined(findings.0.iter().map(|finding| finding.message.clone()))))?,
            None => world.clone(),
        };
        let draft = Draft {
            file: stored.file.clone(),
            leniencies: Vec::new(),
        };
        let assessment = Assessment::new(&own, draft, None);
        let simulation = assessment.simulation().map_err(|issues| {
            let messages = issues.iter().map(|issue| issue.message(&own, &[], None));
            unusable(joined(messages))
        })?;
        Ok(Self::of_plan(domain, &own, &simulation.report.plan, &stored.summary))
    }

    fn of_plan(domain: &Domain, own: &World, plan: &Plan, summary: &str) -> Self {
        let mut recalled = Self {
            written: Written::of_plan(own, plan),
            summary: summary.to_owned(),
            ..Self::default()
        };
        let some_act = domain.actions.iter().any(|action| action.actor.is_some());
        for step in plan.steps() {
            match step.actor(domain) {
                Some(actor) => add(&mut recalled.actors, &own.entity(actor).identifier),
                None => recalled.joint |= some_act,
            }
            for entity in things(domain, step) {
                add(&mut recalled.handled, &own.entity(entity).identifier);
            }
        }
        recalled
    }

    /// Returns the remark that precedes its steps.
    pub(super) fn remark(&self, name: &str) -> String {
        if self.summary.is_empty() {
            name.to_owned()
        } else {
            format!("{name}: {}", self.summary)
        }
    }
}

fn things<'a>(domain: &'a Domain, step: &'a Step) -> impl Iterator<Item = crate::environment::EntityId> + 'a {
    let actor = domain.action(step.action).actor;
    let arguments = step.arguments.iter().enumerate();
    arguments
        .filter(move |(place, _)| Some(*place) != actor)
        .map(|(_, entity)| *entity)
}

fn add(list: &mut Vec<String>, identifier: &str) {
    if !list.iter().any(|known| known == identifier) {
        list.push(identifier.to_owned());
    }
}

fn joined(messages: impl Iterator<Item = String>) -> String {
    messages.collect::<Vec<_>>().join("; ")
}
