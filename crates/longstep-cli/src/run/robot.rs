//! The robot that `--robot` names, with the failures and exit codes of its errors.

use anyhow::Result;
use longstep_core::environment::World;
use longstep_robot::{
    OpenError, OpenOptions, Opened, ReferenceError, RobotError, RobotReference, RunStart, StopRequest,
};

use crate::exit_code::{ROBOT, ROBOT_BUSY, ROBOT_GONE, ROBOT_LATE, ROBOT_MISSING, ROBOT_REFUSED, ROBOT_TYPE, STOPPED};
use crate::failure::Failure;
use crate::output::{counted, remark};

/// Opens a robot; see [`longstep_robot::open`].
pub(crate) fn open(named: &str, world: &World, live: bool, request: &StopRequest, start: RunStart) -> Result<Opened> {
    let reference: RobotReference = named.parse().map_err(misnamed)?;
    let options = OpenOptions::default().with_live(live);
    let opened = longstep_robot::open(&reference, world, &options, request, start).map_err(unopened)?;
    if opened.cancelled > 0 {
        remark!(
            "Cancelled what the interrupted run had left under way: {}",
            counted(opened.cancelled, "goal")
        );
    }
    Ok(opened)
}

/// The failure for a text that names no robot.
pub(crate) fn misnamed(error: ReferenceError) -> Failure {
    let hint = match &error {
        ReferenceError::Sim(_) => "for example `--robot sim:faults=2,seed=7`",
        other => other.hint(),
    };
    Failure::unreadable(error.to_string()).hint(hint)
}

/// The error for a robot that cannot be opened.
fn unopened(error: OpenError) -> anyhow::Error {
    match error {
        OpenError::Reference(error) => misnamed(error).into(),
        OpenError::Robot(error) => failure(&error).into(),
        // These have hints and exit codes of their own.
        OpenError::Configuration(findings) => findings.into(),
        OpenError::File(error) => error.into(),
        OpenError::NoHomeFolder(error) => error.into(),
        other => Failure::unreadable(other.to_string()).into(),
    }
}

/// The failure for an error of a robot.
pub(crate) fn failure(error: &RobotError) -> Failure {
    if *error == RobotError::Stopped {
        return Failure::new("stopped by a signal; nothing has moved", STOPPED);
    }
    let failure = Failure::new(error.to_string(), exit_code(error));
    match error.hint() {
        Some(hint) => failure.hint(hint),
        None => failure,
    }
}

/// The exit code for an error of a robot.
pub(crate) fn exit_code(error: &RobotError) -> u8 {
    match error {
        RobotError::Unreachable { .. } | RobotError::Gone { .. } => ROBOT_GONE,
        RobotError::TimedOut { .. } => ROBOT_LATE,
        RobotError::Rejected { .. } => ROBOT_REFUSED,
        RobotError::InUse { .. } | RobotError::Abandoned { .. } | RobotError::UnderWay { .. } => ROBOT_BUSY,
        RobotError::Missing { .. } => ROBOT_MISSING,
        RobotError::WrongType { .. } => ROBOT_TYPE,
        _ => ROBOT,
    }
}
