//! Runs of verified plans on robots, and programs that end with the test.
#![allow(clippy::unwrap_used, clippy::panic, dead_code, missing_docs, unreachable_pub)]

mod agreeing;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use longstep_core::execution::{Aim, Approval, Event, Execution, Settings, Stop};
use longstep_core::verify::VerifiedPlan;
use longstep_robot::{Robot, RunControl, drive, reports};

use agreeing::Agreeing;

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Carries out a plan; returns the events and the reason of a stop.
pub fn carried_out(plan: &VerifiedPlan, aim: &Aim, robot: &mut dyn Robot) -> (Execution, Vec<Event>, Option<Stop>) {
    let settings = Settings::default()
        .with_approval(Approval::Never)
        .with_reports(reports(robot, plan.world()).unwrap());
    let mut execution = Execution::new(plan, aim, settings).unwrap();
    let (mut kept, control) = (Vec::new(), RunControl::of(robot));
    let mut watcher = Agreeing(|_: &Execution, events: &[Event]| kept.extend_from_slice(events));
    let driven = drive(&mut execution, robot, &mut watcher, &control);
    (execution, kept, driven.into_stop())
}

/// A program that is ended with the test.
pub struct Program {
    child: Child,
    /// The first line that it wrote.
    pub first_line: String,
}

impl Program {
    /// Starts a program and waits for its first line.
    pub fn start(command: &mut Command) -> Self {
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().unwrap();
        let mut first_line = String::new();
        let mut output = BufReader::new(child.stdout.take().unwrap());
        output.read_line(&mut first_line).unwrap();
        let first_line = first_line.trim().to_owned();
        assert!(!first_line.is_empty(), "{command:?} wrote nothing");
        Self { child, first_line }
    }

    pub fn kill(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        self.kill();
    }
}
