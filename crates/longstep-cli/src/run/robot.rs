//! The robot that `--robot` names.

use anyhow::Result;
use longstep_core::environment::World;
use longstep_robot::{Robot, RobotError, Sim, SimOptions, SimOptionsError, StopRequest};

use crate::exit_code::{ROBOT, STOPPED};
use crate::failure::Failure;

/// Opens a robot: `sim`, `sim:OPTIONS` or `process:COMMAND`. The request stops it from then on, and ends the opening of a
/// robot that takes its time.
pub(crate) fn open(named: &str, world: &World, request: &StopRequest) -> Result<Box<dyn Robot>> {
    let (kind, rest) = named.split_once(':').unwrap_or((named, ""));
    let robot: Box<dyn Robot> = match kind {
        "sim" => {
            let options: SimOptions = rest.parse().map_err(|error: SimOptionsError| {
                Failure::unreadable(error.to_string()).hint("for example `--robot sim:faults=2,seed=7`")
            })?;
            Box::new(Sim::new(world.clone(), &options).map_err(|error| failure(&error))?)
        }
        #[cfg(unix)]
        "process" if !rest.trim().is_empty() => {
            let command = longstep_robot::process::Command::parse(rest).map_err(|error| failure(&error))?;
            let domain = world.domain().name.clone();
            let command = command.scene(&domain, world.environment().clone());
            Box::new(command.open_until(request).map_err(|error| failure(&error))?)
        }
        _ => {
            return Err(Failure::unreadable(format!("`{named}` is no robot"))
                .hint("write `sim`, `sim:faults=2,seed=7` or `process:COMMAND`")
                .into());
        }
    };
    request.attach(robot.stop_switch());
    if request.is_requested() {
        return Err(failure(&RobotError::Stopped).into());
    }
    Ok(robot)
}

/// The error of a robot that cannot be opened or cannot observe.
pub(crate) fn failure(error: &RobotError) -> Failure {
    if *error == RobotError::Stopped {
        return Failure::new("stopped by a signal; nothing has moved", STOPPED);
    }
    let failure = Failure::new(error.to_string(), ROBOT);
    match error.hint() {
        Some(hint) => failure.hint(hint),
        None => failure,
    }
}
