//! A robot that no other program drives at the same time.

use std::fs::File;
use std::path::Path;
use std::time::Duration;

use longstep_core::environment::World;
use serde_json::Value;

use crate::description::Description;
use crate::error::RobotError;
use crate::lock;
use crate::order::{Handle, Order};
#[cfg(unix)]
use crate::presence::{self, Presence};
use crate::robot::{Progress, Robot, StopSwitch};
use crate::scope::Scope;
use longstep_core::environment::Observation;

/// A robot with a lock for everything that it [drives](Description::drives). The locks are files that the operating system
/// releases when the program ends, however it ends. They hold among the programs that use the same folder.
///
/// A robot behind a program of its own ([`Robot::presence`]) may still be driven by it after this program was killed: no other
/// program can take the robot until that one has ended.
///
/// ```
/// use longstep_core::{domain, environment};
/// use longstep_robot::{Description, DryRun, Exclusive, Robot, RobotError};
/// # let household = domain::shipped("household").unwrap().unwrap();
/// # let world = environment::parse(&household, "env.json", r#"{"assets": ["<desk>"], "objects": []}"#).unwrap();
/// # let folder = tempfile::tempdir().unwrap();
/// # let folder = folder.path();
/// let arm = || Box::new(longstep_robot::Sim::new(world.clone(), &"".parse().unwrap()).unwrap());
/// let first = Exclusive::take(arm(), &["left arm".to_owned()], folder)?;
/// let second = Exclusive::take(arm(), &["left arm".to_owned()], folder);
/// assert_eq!(second.err(), Some(RobotError::InUse { robot: "left arm".to_owned() }));
/// assert!(Exclusive::take(arm(), &["right arm".to_owned()], folder).is_ok());
/// drop(first);
/// assert!(Exclusive::take(arm(), &["left arm".to_owned()], folder).is_ok());
/// # Ok::<(), RobotError>(())
/// ```
pub struct Exclusive {
    // Dropped first: the robot is stopped before another program may drive it.
    robot: Box<dyn Robot>,
    _locks: Vec<File>,
}

impl Exclusive {
    /// Takes the locks of a robot in a folder, which must exist.
    ///
    /// # Errors
    ///
    /// [`RobotError::InUse`] if another program has one of them, [`RobotError::Abandoned`] if the program of a robot outlived a
    /// Longstep that was killed, and [`RobotError::Unreachable`] for a folder in which no file can be made. The robot is dropped
    /// then.
    pub fn take(robot: Box<dyn Robot>, drives: &[String], folder: &Path) -> Result<Self, RobotError> {
        Self::open(drives, folder, || Ok(robot))
    }

    /// Takes the locks, then opens the robot: for a robot of which it is known before what it drives, and which is changed by being
    /// opened.
    ///
    /// # Errors
    ///
    /// Those of [`Exclusive::take`] and of `open`.
    pub fn open(
        drives: &[String],
        folder: &Path,
        open: impl FnOnce() -> Result<Box<dyn Robot>, RobotError>,
    ) -> Result<Self, RobotError> {
        let mut locks = Vec::new();
        for driven in drives {
            locks.push(lock::take(driven, folder)?);
        }
        let robot = open()?;
        #[cfg(unix)]
        claim(robot.as_ref(), drives, folder)?;
        Ok(Self { robot, _locks: locks })
    }
}

/// Checks that no program of an earlier run drives the robot, and keeps what its own program drives.
#[cfg(unix)]
fn claim(robot: &dyn Robot, drives: &[String], folder: &Path) -> Result<(), RobotError> {
    let own = robot.presence();
    presence::refuse_robots(folder, own, drives)?;
    let declared = own.map_or(Ok(()), |own| own.declare(drives));
    declared.map_err(|error| RobotError::Unreachable {
        robot: drives.join(", "),
        reason: format!("its presence cannot be written to {}: {error}", folder.display()),
    })
}

impl Robot for Exclusive {
    fn describe(&self) -> &Description {
        self.robot.describe()
    }

    fn start(&mut self, order: &Order) -> Result<Handle, RobotError> {
        self.robot.start(order)
    }

    fn poll(&mut self, handle: Handle) -> Result<Progress, RobotError> {
        self.robot.poll(handle)
    }

    fn observe(&mut self, scope: &Scope) -> Result<Observation, RobotError> {
        self.robot.observe(scope)
    }

    fn message(&self, order: &Order) -> Result<Value, RobotError> {
        self.robot.message(order)
    }

    fn stop(&mut self) -> Result<(), RobotError> {
        self.robot.stop()
    }

    fn stop_switch(&self) -> StopSwitch {
        self.robot.stop_switch()
    }

    fn begin_plan(&mut self, world: &World) {
        self.robot.begin_plan(world);
    }

    fn wait(&mut self, limit: Duration) {
        self.robot.wait(limit);
    }

    #[cfg(unix)]
    fn presence(&self) -> Option<&Presence> {
        self.robot.presence()
    }
}
