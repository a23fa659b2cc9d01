//! The robot that `--robot` names.

use std::path::{Path, PathBuf};

use anyhow::Result;
use longstep_core::environment::World;
use longstep_core::model::Domain;
use longstep_files::{read_text, session_directory};
use longstep_robot::ros2::{self, Configuration, Preview, Ros2};
use longstep_robot::virtualhome::{VirtualHome, VirtualHomeOptions, VirtualHomeOptionsError};
use longstep_robot::{DryRun, Exclusive, Robot, RobotError, Sim, SimOptions, SimOptionsError, StopRequest};

use crate::exit_code::{ROBOT, ROBOT_BUSY, ROBOT_GONE, ROBOT_LATE, ROBOT_MISSING, ROBOT_REFUSED, ROBOT_TYPE, STOPPED};
use crate::failure::Failure;
use crate::output::{counted, remark};

/// An open robot.
pub(crate) struct Opened {
    pub(crate) robot: Box<dyn Robot>,
    /// True if nothing moves: the robot is real, and nobody said `--live`.
    pub(crate) is_dry: bool,
}

/// The beginning of a run, as far as the robot is concerned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RunStart {
    /// The robot stands still.
    New,
    /// The robot may still perform orders of this run, which was interrupted.
    Interrupted,
}

/// Opens a robot: `sim`, `sim:OPTIONS`, `process:COMMAND`, `ros2:FILE` or `virtualhome:URL`. A robot that is not a
/// simulation moves only if `live` is true, and only if no other program drives it. The request stops it from then on, and
/// ends the opening of a robot behind a program that takes its time. Orders of an interrupted run have ended then.
pub(crate) fn open(named: &str, world: &World, live: bool, request: &StopRequest, entry: RunStart) -> Result<Opened> {
    let opened = open_kind(named, world, live, request, entry)?;
    request.attach(opened.robot.stop_switch());
    if request.is_requested() {
        Err(failure(&RobotError::Stopped).into())
    } else {
        Ok(opened)
    }
}

fn open_kind(named: &str, world: &World, live: bool, request: &StopRequest, entry: RunStart) -> Result<Opened> {
    let (kind, rest) = named.split_once(':').unwrap_or((named, ""));
    match kind {
        "sim" => {
            let options: SimOptions = rest.parse().map_err(|error: SimOptionsError| {
                Failure::unreadable(error.to_string()).hint("for example `--robot sim:faults=2,seed=7`")
            })?;
            let sim = Sim::new(world.clone(), &options).map_err(|error| failure(&error))?;
            moving(Box::new(sim))
        }
        #[cfg(unix)]
        "process" if !rest.trim().is_empty() => process(rest, world, live, request),
        "ros2" if !rest.trim().is_empty() => ros2(Path::new(rest), world, live, entry),
        "virtualhome" => {
            let options = virtualhome_options(rest)?;
            locked(&options.drives(), || {
                Ok(Box::new(VirtualHome::open(world.clone(), &options)?))
            })
        }
        _ => Err(Failure::unreadable(format!("`{named}` is no robot"))
            .hint("write `sim`, `sim:faults=2,seed=7`, `process:COMMAND`, `ros2:robot.toml` or `virtualhome:URL`")
            .into()),
    }
}

#[cfg(unix)]
fn process(command: &str, world: &World, live: bool, request: &StopRequest) -> Result<Opened> {
    let command = longstep_robot::process::Command::parse(command).map_err(|error| failure(&error))?;
    let domain = world.domain().name.clone();
    let command = command
        .presences(lock_folder()?)
        .scene(&domain, world.environment().clone());
    let robot = command.open_until(request).map_err(|error| failure(&error))?;
    if live || robot.describe().simulated {
        return moving(Box::new(robot));
    }
    let description = robot.describe().clone();
    drop(robot);
    let message = |order: &longstep_robot::Order| {
        serde_json::to_value(order).map_err(|error| RobotError::InvalidOrder {
            step: order.step,
            reason: error.to_string(),
        })
    };
    dry(DryRun::new(&description, world.clone(), message))
}

fn ros2(path: &Path, world: &World, live: bool, entry: RunStart) -> Result<Opened> {
    let configuration = configuration(path, world.domain(), Some(world))?;
    if live || configuration.is_simulated() {
        return connected(configuration, world.domain(), entry);
    }
    let preview = Preview::new(configuration, world.domain());
    let description = preview.description().clone();
    dry(DryRun::new(&description, world.clone(), move |order| {
        preview.message(order)
    }))
}

/// Connects to a robot behind a bridge, which no other program may drive by then.
fn connected(configuration: Configuration, domain: &Domain, entry: RunStart) -> Result<Opened> {
    let drives = configuration.drives();
    locked(&drives, || {
        let robot = match entry {
            RunStart::New => Ros2::connect(configuration, domain)?,
            RunStart::Interrupted => Ros2::reconnect(configuration, domain)?,
        };
        let count = robot.cancelled();
        if count > 0 {
            remark!(
                "Cancelled what the interrupted run had left under way: {}",
                counted(count, "goal")
            );
        }
        Ok(Box::new(robot))
    })
}

/// Reads `robot.toml`, which has to fit the domain.
fn configuration(path: &Path, domain: &Domain, world: Option<&World>) -> Result<Configuration> {
    let configuration = Configuration::parse(&path.display().to_string(), &read_text(path)?)?;
    let checked = ros2::check(&configuration, domain, world);
    if checked.mismatches.is_empty() {
        Ok(configuration)
    } else {
        Err(longstep_core::diagnostic::Diagnostics(checked.mismatches).into())
    }
}

/// Returns a robot that moves, with its locks.
fn moving(robot: Box<dyn Robot>) -> Result<Opened> {
    let drives = robot.describe().drives.clone();
    if drives.is_empty() {
        Ok(Opened { robot, is_dry: false })
    } else {
        locked(&drives, || Ok(robot))
    }
}

/// Opens a robot that moves, after its locks were taken.
fn locked(drives: &[String], open: impl FnOnce() -> Result<Box<dyn Robot>, RobotError>) -> Result<Opened> {
    let robot = Exclusive::open(drives, &lock_folder()?, open).map_err(|error| failure(&error))?;
    Ok(Opened {
        robot: Box::new(robot),
        is_dry: false,
    })
}

fn dry(robot: Result<DryRun, RobotError>) -> Result<Opened> {
    let robot = Box::new(robot.map_err(|error| failure(&error))?);
    Ok(Opened { robot, is_dry: true })
}

/// Returns the folder of the locks of robots, beside the sessions.
fn lock_folder() -> Result<PathBuf> {
    let sessions = session_directory()?;
    let folder = sessions.parent().unwrap_or(&sessions).join("robots");
    std::fs::create_dir_all(&folder)
        .map_err(|error| Failure::unreadable(format!("cannot make {}: {error}", folder.display())))?;
    Ok(folder)
}

/// Reads the options of a VirtualHome simulator.
pub(crate) fn virtualhome_options(text: &str) -> Result<VirtualHomeOptions> {
    let options = text.parse();
    let unreadable = |error: VirtualHomeOptionsError| {
        Failure::unreadable(error.to_string()).hint("for example `virtualhome:http://127.0.0.1:8080,room=kitchen`")
    };
    Ok(options.map_err(unreadable)?)
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
