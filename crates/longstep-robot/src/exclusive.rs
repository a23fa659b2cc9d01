//! A robot that no other program drives at the same time.

use std::fs::{File, OpenOptions, TryLockError};
use std::path::Path;
use std::time::Duration;

use longstep_core::environment::World;
use serde_json::Value;

use crate::description::Description;
use crate::error::RobotError;
use crate::observation::{Observation, Scope};
use crate::order::{Handle, Order};
use crate::robot::{Progress, Robot, StopSwitch};

/// The longest name of a lock's file, in characters.
const LONGEST: usize = 120;

/// A robot with a lock for everything that it [drives](Description::drives). The locks are files that the operating system
/// releases when the program ends, however it ends. They hold among the programs that use the same folder.
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
    /// [`RobotError::InUse`] if another program has one of them, and [`RobotError::Unreachable`] for a folder in which no file
    /// can be made. The robot is dropped then.
    pub fn take(robot: Box<dyn Robot>, drives: &[String], folder: &Path) -> Result<Self, RobotError> {
        let mut locks = Vec::new();
        for driven in drives {
            locks.push(lock(driven, folder)?);
        }
        Ok(Self { robot, _locks: locks })
    }
}

fn lock(driven: &str, folder: &Path) -> Result<File, RobotError> {
    let path = folder.join(file_name(driven));
    let failed = |error: std::io::Error| RobotError::Unreachable {
        robot: driven.to_owned(),
        reason: format!("its lock {} cannot be taken: {error}", path.display()),
    };
    let file = OpenOptions::new()
        .append(true)
        .create(true)
        .open(&path)
        .map_err(failed)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(RobotError::InUse {
            robot: driven.to_owned(),
        }),
        Err(TryLockError::Error(error)) => Err(failed(error)),
    }
}

/// Returns the name of a lock's file: readable, and different for different robots.
fn file_name(driven: &str) -> String {
    let readable = driven.chars().map(|own| {
        if own.is_ascii_alphanumeric() || own == '.' {
            own
        } else {
            '-'
        }
    });
    let readable: String = readable.take(LONGEST).collect();
    // FNV-1a, which is the same in every version and on every machine.
    let hash = driven.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{readable}-{hash:016x}.lock")
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
}
