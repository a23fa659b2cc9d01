//! `longstep run`: carries out a verified plan on a robot, monitored and mended.

mod begin;
mod person;
pub(crate) mod robot;
mod stop;
mod view;

use std::path::{Path, PathBuf};

use anyhow::Result;
use longstep_core::environment::World;
use longstep_core::execution::{Approval, Execution, Stop, Watch};
use longstep_llm::{load_domain, session_directory};
use longstep_robot::{RunHeader, RunLog, StopRequest, drive};

use crate::arguments::{ApprovalArgument, ObserveArgument, RunArguments};
use crate::exit_code::{LIMIT, NOT_VALID, ROBOT, STOPPED};
use crate::failure::Failure;
use crate::output::remark;
use crate::show;
use begin::Begun;
use view::View;

pub(crate) fn run(arguments: &RunArguments) -> Result<u8> {
    match (&arguments.resume, &arguments.what) {
        (Some(log), _) => resume(arguments, log),
        (None, Some(what)) => begin(arguments, what),
        // clap requires one of the two.
        (None, None) => Err(Failure::unreadable("nothing to run").into()),
    }
}

fn begin(arguments: &RunArguments, what: &str) -> Result<u8> {
    let Some(named) = &arguments.robot else {
        return Err(Failure::unreadable("no robot is given")
            .hint("add `--robot sim`, or `--robot \"process:COMMAND\"`")
            .into());
    };
    let begun = match begin::begin(arguments, what)? {
        Ok(begun) => begun,
        Err(code) => return Ok(code),
    };
    let Begun { plan, aim } = begun;
    let mut robot = robot::open(named, plan.world())?;
    let settings = begin::settings(arguments, robot.as_ref(), plan.world())?;
    let execution = Execution::new(&plan, &aim, settings).map_err(|error| {
        Failure::unreadable(error.to_string()).hint("nothing has moved; pass the values with `--skills FILE`")
    })?;
    let path = match &arguments.log {
        Some(path) => path.clone(),
        None => new_log()?,
    };
    let log = RunLog::create(&path, &RunHeader::new(named, &arguments.domain))
        .map_err(|error| Failure::unreadable(error.to_string()).hint("name a new file with `--log RUN.jsonl`"))?;
    carry_out(arguments, execution, robot.as_mut(), log, &path)
}

fn resume(arguments: &RunArguments, path: &Path) -> Result<u8> {
    let (log, header, events) = RunLog::resume(path).map_err(|error| Failure::unreadable(error.to_string()))?;
    let domain = load_domain(&header.domain)?;
    let execution = Execution::resume(&domain, &events).map_err(|error| Failure::unreadable(error.to_string()))?;
    let named = arguments.robot.as_ref().unwrap_or(&header.robot);
    let mut robot = robot::open(named, execution.world())?;
    remark!("Resuming {}", path.display());
    carry_out(arguments, execution, robot.as_mut(), log, path)
}

/// Runs to the end and returns the exit code.
fn carry_out(
    arguments: &RunArguments,
    mut execution: Execution,
    robot: &mut dyn longstep_robot::Robot,
    log: RunLog,
    path: &Path,
) -> Result<u8> {
    let before = execution.world().environment().clone();
    let request = StopRequest::of(robot);
    stop::on_signals(&request).map_err(|error| Failure::unreadable(format!("cannot watch for signals: {error}")))?;
    remark!("The log is {}", path.display());
    let mut view = View::new(log, request.clone(), arguments.json);
    let stop = drive(&mut execution, robot, &mut view, &request);
    // Ends the program of a robot behind one.
    let _ = robot.stop();
    let after = execution.environment();
    if let Some(file) = &arguments.save_after {
        let mut json = serde_json::to_string_pretty(&after)?;
        json.push('\n');
        let written = longstep_llm::write_whole(file, json.as_bytes());
        written.map_err(|error| Failure::unreadable(format!("cannot write {}: {error}", file.display())))?;
    }
    if !arguments.json {
        view::end(execution.world(), stop.as_ref());
        show::changes(&before, &after);
        if let Some(stop) = &stop {
            resume_hint(&execution, stop, path);
        }
    }
    Ok(stop.map_or(0, |stop| code(&stop)))
}

fn resume_hint(execution: &Execution, stop: &Stop, path: &Path) {
    let log = path.display();
    let under_way = execution.running().len();
    if under_way > 0 {
        show::hint(&format!(
            "{under_way} step(s) were under way when the robot was stopped; {log} says which"
        ));
    }
    if stop.is_resumable() {
        show::hint(&format!("`longstep run --resume {log}` continues"));
    }
}

fn code(stop: &Stop) -> u8 {
    match stop {
        Stop::NoPlan { .. } => longstep::report::Status::Unsolvable.exit_code(),
        Stop::GaveUp { .. } => longstep::report::Status::GaveUp.exit_code(),
        Stop::Broken { .. } => NOT_VALID,
        Stop::TooManyChanges(_) | Stop::Repeated => LIMIT,
        Stop::Robot(_) => ROBOT,
        _ => STOPPED,
    }
}

/// Returns a new file for a log, beside the sessions.
fn new_log() -> Result<PathBuf> {
    let sessions = session_directory()?;
    let folder = sessions.parent().unwrap_or(&sessions).join("runs");
    std::fs::create_dir_all(&folder)
        .map_err(|error| Failure::unreadable(format!("cannot make {}: {error}", folder.display())))?;
    for number in 1..100_000 {
        let path = folder.join(format!("run-{number}.jsonl"));
        if !path.exists() {
            return Ok(path);
        }
    }
    Err(Failure::unreadable(format!("{} is full", folder.display())).into())
}

impl From<ApprovalArgument> for Approval {
    fn from(argument: ApprovalArgument) -> Self {
        match argument {
            ApprovalArgument::Never => Self::Never,
            ApprovalArgument::Changes => Self::Changes,
            ApprovalArgument::EachStep => Self::EachStep,
        }
    }
}

impl From<ObserveArgument> for Watch {
    fn from(argument: ObserveArgument) -> Self {
        match argument {
            ObserveArgument::EachStep => Self::EachStep,
            ObserveArgument::OnFailure => Self::OnFailure,
        }
    }
}

/// The name of an entity of the world, for a person.
fn shown(world: &World, identifier: &str) -> String {
    world
        .find(identifier)
        .map_or_else(|| identifier.to_owned(), |entity| world.entity(entity).name.clone())
}
