//! The robot that `--robot` names.

use anyhow::Result;
use longstep_core::environment::World;
use longstep_robot::virtualhome::{VirtualHome, VirtualHomeOptions, VirtualHomeOptionsError};
use longstep_robot::{Robot, RobotError, Sim, SimOptions, SimOptionsError};

use crate::exit_code::ROBOT;
use crate::failure::Failure;

/// Opens a robot: `sim`, `sim:OPTIONS`, `process:COMMAND` or `virtualhome:URL`.
pub(super) fn open(named: &str, world: &World) -> Result<Box<dyn Robot>> {
    let (kind, rest) = named.split_once(':').unwrap_or((named, ""));
    match kind {
        "sim" => {
            let options: SimOptions = rest.parse().map_err(|error: SimOptionsError| {
                Failure::unreadable(error.to_string()).hint("for example `--robot sim:faults=2,seed=7`")
            })?;
            Ok(Box::new(
                Sim::new(world.clone(), &options).map_err(|error| failure(&error))?,
            ))
        }
        #[cfg(unix)]
        "process" if !rest.trim().is_empty() => {
            let command = longstep_robot::process::Command::parse(rest).map_err(|error| failure(&error))?;
            let domain = world.domain().name.clone();
            let command = command.scene(&domain, world.environment().clone());
            Ok(Box::new(command.open().map_err(|error| failure(&error))?))
        }
        "virtualhome" => {
            let robot = VirtualHome::open(world.clone(), &virtualhome_options(rest)?);
            Ok(Box::new(robot.map_err(|error| failure(&error))?))
        }
        _ => Err(Failure::unreadable(format!("`{named}` is no robot"))
            .hint("write `sim`, `sim:faults=2,seed=7`, `process:COMMAND` or `virtualhome:URL`")
            .into()),
    }
}

/// Reads the options of a VirtualHome simulator.
pub(crate) fn virtualhome_options(text: &str) -> Result<VirtualHomeOptions> {
    let options = text.parse();
    let unreadable = |error: VirtualHomeOptionsError| {
        Failure::unreadable(error.to_string()).hint("for example `virtualhome:http://127.0.0.1:8080,room=kitchen`")
    };
    Ok(options.map_err(unreadable)?)
}

pub(crate) fn failure(error: &RobotError) -> Failure {
    let failure = Failure::new(error.to_string(), ROBOT);
    match error.hint() {
        Some(hint) => failure.hint(hint),
        None => failure,
    }
}
