//! The levels and limits of a robot, applied to a plan before it begins, to its changes and to each order.

use super::written::written_step;
use super::{Aim, BeginError, Execution, RefusedPart, Settings, StepOrder, Stop};
use longstep_model::model::World;
use longstep_search::search::GroundAction;
use longstep_verify::plan::StepId;
use longstep_verify::verify::VerifiedPlan;

/// Checks a plan and its goal before it begins.
///
/// # Errors
///
/// Every step and every value of the goal that is refused, and forbidden places that the world does not have.
pub(super) fn check(world: &World, plan: &VerifiedPlan, aim: &Aim, settings: &Settings) -> Result<(), BeginError> {
    let (autonomy, skills) = (&settings.autonomy, &settings.skills);
    let unknown = autonomy.unknown_places(world);
    if !unknown.is_empty() {
        return Err(BeginError::UnknownPlaces(
            unknown.into_iter().map(str::to_owned).collect(),
        ));
    }
    let goal = match aim {
        Aim::Goal(goal) => autonomy.refused_values(world.domain(), goal),
        Aim::Endings => Vec::new(),
    };
    let goal = goal.into_iter().map(|refusal| RefusedPart { step: None, refusal });
    let steps = plan.steps().iter().enumerate().filter_map(|(index, step)| {
        let id = StepId::new(index);
        let values = skills.values(world, Some(id), step.action, &step.arguments);
        let refusal = autonomy.refusal(world, step.action, &step.arguments, &values)?;
        let call = written_step(world, step.action, &step.arguments);
        let step = Some((id, call));
        Some(RefusedPart { step, refusal })
    });
    let refused: Vec<RefusedPart> = goal.chain(steps).collect();
    if refused.is_empty() {
        Ok(())
    } else {
        Err(BeginError::Refused(refused))
    }
}

impl Execution {
    /// Returns the reason why a step of a changed plan cannot be ordered: nobody taught it, or its values are outside of the
    /// limits. `taught` is the step for which the skills file has values.
    pub(super) fn unfit(&self, taught: Option<StepId>, step: &GroundAction) -> Option<String> {
        let (skills, world) = (&self.settings.skills, &self.world);
        let untaught = skills.untaught(world, taught, step.action, &step.arguments).next();
        if let Some(parameter) = untaught {
            return Some(format!("nobody taught its `{}`", parameter.name));
        }
        let values = skills.values(world, taught, step.action, &step.arguments);
        let autonomy = &self.settings.autonomy;
        let refusal = autonomy.refusal(world, step.action, &step.arguments, &values)?;
        Some(refusal.to_string())
    }

    /// Returns the stop for an order that the limits refuse: the last check, in case a plan came into force without them.
    pub(super) fn refused_by_limits(&self, order: &StepOrder) -> Option<Stop> {
        let autonomy = &self.settings.autonomy;
        let refusal = autonomy.refusal(&self.world, order.action, &order.arguments, &order.skills)?;
        Some(Stop::OutOfLimits {
            step: order.written(&self.world),
            refusal,
        })
    }
}
