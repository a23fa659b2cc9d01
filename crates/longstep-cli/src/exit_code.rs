//! Exit codes: those of answers, and those of everything else.

use longstep::report::Status;

/// The command did what it was asked for.
pub(crate) const DONE: u8 = 0;
/// It is proven that there is no plan.
pub(crate) const UNSOLVABLE: u8 = 11;
/// A search gave up.
pub(crate) const GAVE_UP: u8 = 12;

/// Returns the exit code for the status of an answer.
pub(crate) fn of_status(status: Status) -> u8 {
    match status {
        Status::Verified => DONE,
        Status::Invalid => NOT_VALID,
        Status::Unsolvable => UNSOLVABLE,
        Status::GaveUp => GAVE_UP,
        Status::Question => 13,
    }
}

/// A plan, domain or recording that was checked is not valid.
pub(crate) const NOT_VALID: u8 = 10;
/// Arguments that do not fit together.
pub(crate) const WRONG_ARGUMENTS: u8 = 2;
/// Input that cannot be read.
pub(crate) const UNREADABLE: u8 = 30;
/// A limit was reached.
pub(crate) const LIMIT: u8 = 20;
/// A run was stopped by a person or a signal.
pub(crate) const STOPPED: u8 = 50;
/// The robot failed, in a way that has no code of its own.
pub(crate) const ROBOT: u8 = 51;
/// The robot cannot be reached, or is gone.
pub(crate) const ROBOT_GONE: u8 = 52;
/// The robot did not answer in time.
pub(crate) const ROBOT_LATE: u8 = 53;
/// The robot rejected a step before it moved.
pub(crate) const ROBOT_REFUSED: u8 = 54;
/// Another program drives the robot.
pub(crate) const ROBOT_BUSY: u8 = 55;
/// A server of the robot is not there.
pub(crate) const ROBOT_MISSING: u8 = 56;
/// A server of the robot has another type.
pub(crate) const ROBOT_TYPE: u8 = 57;
/// The goal of a run may be reached, and a fact of it was not seen.
pub(crate) const NOT_SEEN: u8 = 58;
/// The model or the network failed.
pub(crate) const MODEL: u8 = 40;
