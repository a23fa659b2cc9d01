//! `longstep runs`: lists the runs that were kept, and exports one.

use std::path::Path;

use anyhow::Result;
use longstep_files::write_whole;
use longstep_robot::RunLog;
use longstep_robot::mcap::Recording;

use crate::arguments::{RunsCommand, RunsFormat};
use crate::failure::Failure;
use crate::output::remark;
use crate::run::{list, log_named};

pub(crate) fn run(command: &RunsCommand) -> Result<u8> {
    match command {
        RunsCommand::List => list(),
        RunsCommand::Export { run, format, output } => export(run, *format, output),
    }
}

/// Writes a run to a file in another format.
fn export(named: &Path, format: RunsFormat, output: &Path) -> Result<u8> {
    let log = log_named(named)?;
    let (header, events) = RunLog::read_timed(&log)
        .map_err(|error| Failure::unreadable(error.to_string()).hint("`longstep runs list` has the names of runs"))?;
    let bytes = match format {
        RunsFormat::Mcap => Recording::new(&header, &events).to_bytes()?,
    };
    write_whole(output, &bytes)
        .map_err(|error| Failure::unreadable(format!("cannot write {}: {error}", output.display())))?;
    remark!("The recording is {}", output.display());
    if events.iter().any(|own| own.at.is_none()) {
        remark!("The log has events without a time: in the recording they are a millisecond apart");
    }
    Ok(0)
}
