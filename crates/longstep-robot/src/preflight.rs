//! A plan looked through before anything moves.

use longstep_core::execution::StepOrder as Wanted;
use longstep_core::plan::StepId;
use longstep_core::skill::Skills;
use longstep_core::verify::VerifiedPlan;

use crate::drive::order_of;
use crate::error::RobotError;
use crate::robot::Robot;

/// Checks that a robot understands every step of a plan: it has the action, and the step can be written as its message.
/// Nothing is sent.
///
/// # Errors
///
/// The error of the first step that it does not understand.
pub fn preflight(robot: &dyn Robot, plan: &VerifiedPlan, skills: &Skills) -> Result<(), RobotError> {
    let world = plan.world();
    for index in 0..plan.steps().len() {
        let wanted = Wanted::of_step(plan, StepId::new(index), skills);
        robot.message(&order_of(world, &wanted))?;
    }
    Ok(())
}
