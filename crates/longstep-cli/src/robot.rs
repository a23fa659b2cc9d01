//! `longstep robot`: what can be learned from a robot without a plan.

mod environment;

use anyhow::Result;

use crate::arguments::RobotCommand;

pub(crate) fn run(command: &RobotCommand) -> Result<u8> {
    match command {
        RobotCommand::Environment(arguments) => environment::run(arguments),
    }
}
