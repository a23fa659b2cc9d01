//! The runs that were kept, and their names.

use std::path::{Path, PathBuf};

use anyhow::Result;
use longstep_core::execution::Event;
use longstep_robot::{RunHeader, RunLog};

use super::runs_folder;
use crate::output::{self, Style, counted, print_line};

/// The extension of a log.
const EXTENSION: &str = "jsonl";

/// Returns the log of a run: a file, or the one with this name in the folder of runs.
pub(crate) fn log_named(named: &Path) -> Result<PathBuf> {
    if named.exists() || named.components().count() != 1 {
        return Ok(named.to_owned());
    }
    let kept = runs_folder()?.join(named).with_extension(EXTENSION);
    Ok(if kept.is_file() { kept } else { named.to_owned() })
}

/// Returns the name of a run on the command line: that of its log in the folder of runs, or else the path.
pub(super) fn name_of(log: &Path) -> String {
    let is_kept = runs_folder().is_ok_and(|folder| log.parent() == Some(&folder));
    match log.file_stem().filter(|_| is_kept) {
        Some(stem) => stem.to_string_lossy().into_owned(),
        None => log.display().to_string(),
    }
}

/// Lists the runs in the folder of runs, the latest last.
pub(crate) fn list() -> Result<u8> {
    let folder = runs_folder()?;
    let mut logs: Vec<(std::time::SystemTime, PathBuf)> = std::fs::read_dir(&folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|own| own == EXTENSION))
        .filter_map(|path| Some((path.metadata().ok()?.modified().ok()?, path)))
        .collect();
    logs.sort();
    if logs.is_empty() {
        print_line!("No runs in {}", folder.display());
        return Ok(0);
    }
    let names: Vec<String> = logs.iter().map(|(_, path)| name_of(path)).collect();
    let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
    for ((time, path), name) in logs.iter().zip(&names) {
        let day = jiff::Timestamp::try_from(*time).map_or_else(|_| String::new(), |time| time.to_string());
        let day = day.get(..16).unwrap_or(&day).replace('T', " ");
        match RunLog::read(path) {
            Ok((header, events)) => {
                print_line!("{:width$}  {day}  {}", name.as_str().bold(), outcome(&header, &events));
                if let Some(goal) = goal(&events) {
                    print_line!("{:width$}  {}", "", goal.dimmed());
                }
            }
            Err(error) => print_line!("{:width$}  {day}  {}", name.as_str().bold(), error.red()),
        }
    }
    output::blank();
    print_line!(
        "Runs are saved in {}; `longstep run --resume NAME` goes on with one",
        folder.display()
    );
    Ok(0)
}

fn goal(events: &[Event]) -> Option<&str> {
    events.iter().find_map(|event| match event {
        Event::Began { goal, .. } => goal.as_deref(),
        _ => None,
    })
}

/// The end of a run, with the number of its steps.
fn outcome(header: &RunHeader, events: &[Event]) -> String {
    let performed = |event: &&Event| matches!(event, Event::Performed { .. } | Event::Found { .. });
    let steps = counted(events.iter().filter(performed).count(), "step");
    let end = match events
        .iter()
        .rev()
        .find(|event| !matches!(event, Event::Observed { .. }))
    {
        Some(Event::Done { .. }) => "done".to_owned(),
        Some(Event::Stopped { why, .. }) => format!("stopped: {why}"),
        _ => "not ended".to_owned(),
    };
    let dry = if header.dry_run { " (dry run)" } else { "" };
    format!("{steps}{dry}, {end}")
}
