//! Robots that can carry out a run: they observe, and report what the run compares.

use longstep_core::environment::World;
use longstep_core::execution::Execution;
use longstep_core::model::PredicateId;

use crate::drive::reports;
use crate::error::RobotError;
use crate::robot::Robot;

/// The reason why a robot cannot carry out a run. `Display` is one line; [`Unfit::hint`] is the next step for the user.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Unfit {
    /// It does not observe.
    #[error("this robot does not observe, so its plan cannot be monitored")]
    DoesNotObserve,
    /// It says that it reports something that it cannot report.
    #[error(transparent)]
    Reports(#[from] RobotError),
    /// It reports other facts than the robot with which a run began.
    #[error("this robot reports other facts than the robot with which the run began")]
    OtherReports,
}

impl Unfit {
    /// Returns the next step for the user, if there is one.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::DoesNotObserve => {
                Some("let the robot's program declare the capability `observe` and answer `observe`")
            }
            Self::Reports(_) => None,
            Self::OtherReports => Some("resume with the same robot"),
        }
    }
}

/// Checks that a robot observes.
///
/// # Errors
///
/// It does not.
pub fn check_observes(robot: &dyn Robot) -> Result<(), Unfit> {
    if robot.describe().observes {
        Ok(())
    } else {
        Err(Unfit::DoesNotObserve)
    }
}

/// Returns the predicates that an observing robot reports besides the states of entities, for the settings of an execution.
///
/// ```
/// use longstep_core::{domain, environment};
/// use longstep_robot::{Sim, SimOptions, observed_reports};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let world = environment::parse(&household, "env.json", r#"{"assets": ["<desk>"]}"#).unwrap();
/// let sim = Sim::new(world.clone(), &SimOptions::default()).unwrap();
/// assert!(!observed_reports(&sim, &world)?.is_empty());
/// # Ok::<(), longstep_robot::Unfit>(())
/// ```
///
/// # Errors
///
/// The robot does not observe, or says that it reports something that it cannot report.
pub fn observed_reports(robot: &dyn Robot, world: &World) -> Result<Vec<PredicateId>, Unfit> {
    check_observes(robot)?;
    Ok(reports(robot, world)?)
}

/// Checks that a robot reports what an execution that is resumed compares.
///
/// # Errors
///
/// As for [`observed_reports`]; and other reports than those of the execution.
pub fn check_resumed(execution: &Execution, robot: &dyn Robot) -> Result<(), Unfit> {
    if observed_reports(robot, execution.world())? == execution.settings().reports {
        Ok(())
    } else {
        Err(Unfit::OtherReports)
    }
}
