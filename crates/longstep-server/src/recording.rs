//! Recordings of runs as MCAP files.

use std::path::Path;

use longstep_robot::RunLog;
use longstep_robot::mcap::Recording;

use crate::hub::Hub;
use crate::id::RunId;
use crate::problem::{Problem, ProblemKind};
use crate::store::LogName;

/// The largest log of which a request gets a recording, in bytes: a recording is made in memory.
const LARGEST: usize = 64 << 20;

impl Hub {
    /// Returns a run as an MCAP file, as far as its log has it: the same log gives the same bytes.
    ///
    /// # Errors
    ///
    /// There is no such run, it has not begun, or its log cannot be read or is too large.
    pub fn recording(&self, id: &RunId) -> Result<Vec<u8>, Problem> {
        let run = self.hosted_run(id)?;
        let bytes = self.store.read(&LogName::Run(id.clone()))?;
        let bytes = bytes.ok_or_else(|| {
            Problem::conflict("the run has not begun").hint("a recording is made of the log, which begins with the run")
        })?;
        if bytes.len() > LARGEST {
            let message = format!("the log of the run has more than {} MiB", LARGEST >> 20);
            return Err(Problem::new(ProblemKind::TooLarge, message)
                .hint("export it on the computer of the server: `longstep runs export`"));
        }
        let text = String::from_utf8_lossy(&bytes);
        let (header, events) = RunLog::parse_timed(Path::new(id.as_str()), &text)
            .map_err(|error| Problem::conflict(format!("the log of the run cannot be read: {error}")))?;
        let record = run.record();
        let recording = Recording::new(&header, &events)
            .with("run", record.id.as_str())
            .with("session", record.session.as_str())
            .with("instruction", record.instruction.as_str())
            .with("approved_plan", record.plan.as_str())
            .with("approval", record.approval.as_str())
            .with("robot_name", record.robot.as_str())
            .with("by", record.by.as_str());
        let written = recording.to_bytes();
        written.map_err(|error| Problem::new(ProblemKind::Internal, error.to_string()))
    }
}
