//! `longstep run`: carries out a verified plan on a robot, monitored and mended.

mod begin;
mod board;
mod list;
mod person;
pub(crate) mod robot;
mod view;

use std::path::{Path, PathBuf};

use anyhow::Result;
use longstep_core::domain::phrase;
use longstep_core::environment::World;
use longstep_core::execution::{Approval, Execution, Resumed, Settings, Stop, Trust, Watch};
use longstep_core::secret;
use longstep_files::session_directory;
use longstep_llm::load_domain;
use longstep_robot::{Opened, RunControl, RunHeader, RunLog, RunStart, StopRequest, check_resumed, drive};

use crate::arguments::{
    ApprovalArgument, ExecutionArguments, ObserveArgument, RunArguments, TrustArgument, domain_or_default,
};
use crate::exit_code::{GAVE_UP, LIMIT, NOT_SEEN, NOT_VALID, ROBOT, STOPPED, UNSOLVABLE};
use crate::failure::Failure;
use crate::output::{remark, shell_word};
use crate::show;
use crate::signals::{self, Armed};
use begin::Begun;
use person::Person;

pub(crate) use begin::{aim_of, execution, unfit};
pub(crate) use list::{list, log_named};
pub(crate) use person::{Decide, Question};
pub(crate) use robot::{exit_code as robot_exit_code, failure as robot_failure, open};
pub(crate) use view::{View, end};

pub(crate) fn run(arguments: &RunArguments) -> Result<u8> {
    if arguments.list {
        return list::list();
    }
    match (&arguments.resume, &arguments.what) {
        (Some(log), _) => resume(arguments, &list::log_named(log)?),
        (None, Some(what)) => begin(arguments, what),
        // clap requires one of the three.
        (None, None) => Err(Failure::unreadable("nothing to run").into()),
    }
}

fn begin(arguments: &RunArguments, what: &str) -> Result<u8> {
    let Some(named) = &arguments.robot else {
        return Err(Failure::unreadable("no robot is given")
            .hint("add `--robot sim`, `--robot \"process:COMMAND\"` or `--robot ros2:robot.toml`")
            .into());
    };
    let begun = match begin::begin(arguments, what)? {
        Ok(begun) => begun,
        Err(code) => return Ok(code),
    };
    let Begun { plan, aim, not_in_plan } = begun;
    let request = StopRequest::default();
    let _armed = armed(&request)?;
    let opened = open(named, plan.world(), arguments.execution.live, &request, RunStart::New)?;
    let teach = "nothing has moved; `longstep teach PLAN.json --demo FILE` writes the values for `--skills FILE`";
    let execution = execution(&arguments.execution, &opened, &plan, &aim, teach)?;
    let path = match &arguments.log {
        Some(path) => path.clone(),
        None => new_log(&runs_folder()?, &name_for(arguments, what))?,
    };
    let header = RunHeader::new(named, domain_or_default(arguments.domain.as_ref())).with_dry_run(opened.is_dry);
    let log = RunLog::create(&path, &header)
        .map_err(|error| Failure::unreadable(error.to_string()).hint("name a new file with `--log RUN.jsonl`"))?;
    if !not_in_plan.is_empty() {
        let words: Vec<String> = not_in_plan.iter().map(|words| format!("\"{words}\"")).collect();
        remark!("Not in the plan: {}", words.join(", "));
    }
    carry_out(arguments, execution, opened, (log, &path), &request)
}

fn resume(arguments: &RunArguments, path: &Path) -> Result<u8> {
    let (log, header, events) = RunLog::resume(path).map_err(|error| Failure::unreadable(error.to_string()))?;
    if header.dry_run {
        return Err(
            Failure::unreadable("this is the log of a dry run, in which nothing moved")
                .hint("begin a new run, with `--live` to move the robot")
                .into(),
        );
    }
    let domain = load_domain(&header.domain)?;
    let resumed = Resumed::default()
        .with_approval(arguments.execution.approve.map(Approval::from))
        .with_trust(arguments.execution.trust.map(Trust::from));
    let execution = Execution::resume(&domain, &events, resumed);
    let execution = execution.map_err(|error| Failure::unreadable(error.to_string()))?;
    let named = arguments.robot.as_ref().unwrap_or(&header.robot);
    if named.contains(secret::REMOVED) {
        return Err(
            Failure::unreadable(format!("the log does not keep the password of `{named}`"))
                .hint("name the robot again with `--robot`")
                .into(),
        );
    }
    let request = StopRequest::default();
    let _armed = armed(&request)?;
    let opened = open(
        named,
        execution.world(),
        arguments.execution.live,
        &request,
        RunStart::of_log(&events),
    )?;
    if opened.is_dry {
        return Err(Failure::unreadable("an interrupted run can only go on for real: this robot is not a simulation")
            .hint("add `--live`; the robot is observed first, and you are asked about steps that no observation decides")
            .into());
    }
    check_resumed(&execution, opened.robot.as_ref()).map_err(|error| unfit(&error))?;
    check_limits(arguments, &execution, &opened)?;
    remark!("Resuming {}", path.display());
    carry_out(arguments, execution, opened, (log, path), &request)
}

/// Refuses levels and limits that are stricter than those with which the run began.
fn check_limits(arguments: &RunArguments, execution: &Execution, opened: &Opened) -> Result<()> {
    let now = begin::autonomy(&arguments.execution, opened, execution.world())?;
    if execution.settings().autonomy.is_as_strict_as(&now) {
        Ok(())
    } else {
        Err(
            Failure::unreadable("the levels or limits are stricter than those with which the run began")
                .hint("begin a new run, in which they are in force")
                .into(),
        )
    }
}

/// From now on signals stop the run, also while its robot is being opened.
fn armed(request: &StopRequest) -> Result<Armed> {
    let armed = Armed::new(request);
    signals::stop_runs().map_err(|error| Failure::unreadable(format!("cannot watch for signals: {error}")))?;
    Ok(armed)
}

/// Runs to the end and returns the exit code.
fn carry_out(
    arguments: &RunArguments,
    mut execution: Execution,
    opened: Opened,
    (log, path): (RunLog, &Path),
    request: &StopRequest,
) -> Result<u8> {
    let Opened { mut robot, is_dry, .. } = opened;
    let robot = robot.as_mut();
    if let Some(file) = arguments.save_after.as_ref().filter(|_| is_dry) {
        return Err(
            Failure::unreadable(format!("a dry run changes no world that {} could keep", file.display()))
                .hint("leave `--save-after` out, or add `--live`")
                .into(),
        );
    }
    let before = execution.world().environment().clone();
    announce(path, is_dry);
    let mut view = View::new(log, Person::new(request.clone()), arguments.json, is_dry);
    let stop = drive(&mut execution, robot, &mut view, &RunControl::from(request.clone())).into_stop();
    view.end();
    // Ends the program of a robot behind one.
    let _ = robot.stop();
    let after = execution.environment();
    if let Some(file) = &arguments.save_after {
        let mut json = serde_json::to_string_pretty(&after)?;
        json.push('\n');
        let written = longstep_files::write_whole(file, json.as_bytes());
        written.map_err(|error| Failure::unreadable(format!("cannot write {}: {error}", file.display())))?;
    }
    if !arguments.json {
        end(&execution, stop.as_ref(), is_dry);
        show::changes(&before, &after);
        if let Some(stop) = stop.as_ref().filter(|_| !is_dry) {
            resume_hint(&execution, stop, path);
        }
    }
    Ok(match (stop, view.robot_error()) {
        (Some(Stop::Robot(_)), Some(error)) => robot::exit_code(error),
        (stop, _) => stop.map_or(0, |stop| code(&stop)),
    })
}

/// Says where the log of a run is, and that a dry run is one.
pub(crate) fn announce(log: &Path, is_dry: bool) {
    remark!("The log is {}", log.display());
    if is_dry {
        remark!("Dry run: nothing is sent to the robot, and nothing moves. Steps do what the plan predicts.");
    }
}

fn resume_hint(execution: &Execution, stop: &Stop, path: &Path) {
    let log = shell_word(list::name_of(path));
    let under_way: Vec<&str> = execution
        .running()
        .iter()
        .map(|order| phrase(&order.explanation))
        .collect();
    if let Stop::Robot(_) = stop {
        let unknown = match &under_way[..] {
            [] => "no step was under way".to_owned(),
            steps => format!(
                "under way, and unknown until the world is observed: {}",
                steps.join("; ")
            ),
        };
        show::hint(&format!(
            "{unknown}; `longstep run --resume {log}` goes on from the observed world"
        ));
    } else if !under_way.is_empty() {
        show::hint(&format!(
            "under way when the robot was stopped: {}",
            under_way.join("; ")
        ));
    }
    match stop {
        Stop::Unseen { denied: false, .. } => show::hint(
            "let the robot look there, look yourself and pass `--approve changes`, or begin with `--trust promised`",
        ),
        Stop::Unseen { denied: true, .. } => {
            show::hint(
                "let the robot look there: what it sees changes the plan, and a person's \"no\" does not say what is so",
            );
        }
        _ => {}
    }
    // The hint about a robot that failed has said so.
    if stop.is_resumable() && !matches!(stop, Stop::Robot(_)) {
        show::hint(&format!("`longstep run --resume {log}` continues"));
    }
}

fn code(stop: &Stop) -> u8 {
    match stop {
        Stop::NoPlan { .. } => UNSOLVABLE,
        Stop::GaveUp { .. } => GAVE_UP,
        Stop::Broken { .. } | Stop::OutOfLimits { .. } => NOT_VALID,
        Stop::TooManyChanges(_) | Stop::Repeated => LIMIT,
        Stop::Unseen { .. } => NOT_SEEN,
        Stop::Robot(_) => ROBOT,
        _ => STOPPED,
    }
}

/// Returns the folder of the logs, beside the sessions.
fn runs_folder() -> Result<PathBuf> {
    let sessions = session_directory()?;
    let folder = sessions.parent().unwrap_or(&sessions).join("runs");
    std::fs::create_dir_all(&folder)
        .map_err(|error| Failure::unreadable(format!("cannot make {}: {error}", folder.display())))?;
    Ok(folder)
}

/// The beginning of a run's name: the file of its plan, or the environment of its instruction.
fn name_for(arguments: &RunArguments, what: &str) -> String {
    let env = || arguments.env.as_deref().or(arguments.project_env.as_deref());
    let file = if Path::new(what).is_file() {
        Some(Path::new(what))
    } else {
        env()
    };
    let stem = file
        .and_then(Path::file_stem)
        .map(|stem| stem.to_string_lossy().into_owned());
    stem.unwrap_or_else(|| "run".to_owned())
}

/// Returns a new file for a log in a folder.
pub(crate) fn new_log(folder: &Path, name: &str) -> Result<PathBuf> {
    let mut names = (1..100_000).map(|number| folder.join(format!("{name}-{number}.jsonl")));
    let free = names.find(|path| !path.exists());
    free.ok_or_else(|| Failure::unreadable(format!("{} is full", folder.display())).into())
}

impl From<&ExecutionArguments> for Settings {
    /// Returns the settings that do not depend on the robot or the world.
    fn from(arguments: &ExecutionArguments) -> Self {
        Self::default()
            .with_approval(arguments.approve.map_or_else(Approval::default, Approval::from))
            .with_trust(arguments.trust.map_or_else(Trust::default, Trust::from))
            .with_watch(arguments.observe.map_or_else(Watch::default, Watch::from))
            .with_changes(arguments.changes.unwrap_or(Self::default().changes))
    }
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

impl From<TrustArgument> for Trust {
    fn from(argument: TrustArgument) -> Self {
        match argument {
            TrustArgument::Observed => Self::Observed,
            TrustArgument::Promised => Self::Promised,
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
