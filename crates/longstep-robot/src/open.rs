//! Robots that are opened by their reference, with their locks.

use std::path::{Path, PathBuf};

use longstep_core::autonomy::Autonomy;
use longstep_core::diagnostic::Diagnostics;
use longstep_core::environment::World;
use longstep_core::execution::Event;
use longstep_core::model::Domain;
use longstep_files::{NoHomeFolder, TextFileError, read_text, session_directory};

use crate::dry_run::DryRun;
use crate::error::RobotError;
use crate::exclusive::Exclusive;
use crate::reference::{ReferenceError, RobotKind, RobotReference};
use crate::robot::Robot;
use crate::ros2::{self, Configuration, Preview, Ros2};
use crate::sim::Sim;
use crate::stop::StopRequest;
use crate::virtualhome::VirtualHome;

/// An open robot.
pub struct Opened {
    /// The robot.
    pub robot: Box<dyn Robot>,
    /// True if nothing moves: the robot is no simulation, and [`OpenOptions::live`] is false.
    pub is_dry: bool,
    /// The levels of autonomy and the limits of the robot's own configuration.
    pub autonomy: Autonomy,
    /// The number of goals that an interrupted run had left under way, and that were cancelled.
    pub cancelled: usize,
}

impl Opened {
    fn new(robot: impl Robot + 'static) -> Self {
        Self {
            robot: Box::new(robot),
            is_dry: false,
            autonomy: Autonomy::default(),
            cancelled: 0,
        }
    }

    /// Returns the robot that goes on in the same world after a stop; none if it has to be opened again.
    pub fn revived(&self) -> Option<Self> {
        self.robot.revived().map(|robot| Self {
            robot,
            is_dry: self.is_dry,
            autonomy: self.autonomy.clone(),
            cancelled: 0,
        })
    }
}

/// The options of [`open`].
///
/// ```
/// use longstep_robot::OpenOptions;
/// let options = OpenOptions::default().with_live(true).with_locks("/run/robots".into());
/// assert!(options.live && options.locks.is_some());
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct OpenOptions {
    /// True to move a robot that is no simulation.
    pub live: bool,
    /// The folder of the locks, which must exist; none for [`lock_folder`].
    pub locks: Option<PathBuf>,
}

impl OpenOptions {
    /// Moves a robot that is no simulation, or not.
    #[must_use]
    pub fn with_live(self, live: bool) -> Self {
        Self { live, ..self }
    }

    /// Sets the folder of the locks, which must exist. Robots are locked among the programs that use the same folder.
    #[must_use]
    pub fn with_locks(self, locks: PathBuf) -> Self {
        Self {
            locks: Some(locks),
            ..self
        }
    }
}

/// The beginning of a run, as far as its robot is concerned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunStart {
    /// The robot stands still.
    New,
    /// The robot may still perform orders of this run, which was interrupted.
    Interrupted,
}

impl RunStart {
    /// Returns how a run continues from its log: the robot may still perform an order whose end the log does not have.
    ///
    /// ```
    /// use longstep_core::execution::Event;
    /// use longstep_robot::RunStart;
    /// let ordered = r#"{"event": "ordered", "order": 1, "step": 1, "call": "grasp(<cup>)", "explanation": "grasp the cup"}"#;
    /// let mut log: Vec<Event> = vec![serde_json::from_str(ordered).unwrap()];
    /// assert_eq!(RunStart::of_log(&log), RunStart::Interrupted);
    /// log.push(serde_json::from_str(r#"{"event": "performed", "order": 1}"#).unwrap());
    /// assert_eq!(RunStart::of_log(&log), RunStart::New);
    /// ```
    pub fn of_log(events: &[Event]) -> Self {
        let mut under_way = Vec::new();
        for event in events {
            match event {
                Event::Ordered { order, .. } => under_way.push(*order),
                Event::Performed { order, .. } | Event::Failed { order, .. } => under_way.retain(|own| own != order),
                // The orders before an earlier interruption were ended when the run went on.
                Event::Interrupted { .. } => under_way.clear(),
                _ => {}
            }
        }
        if under_way.is_empty() {
            Self::New
        } else {
            Self::Interrupted
        }
    }
}

/// A robot that cannot be opened. Nothing has moved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// The text names no robot.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// The configuration of the robot cannot be read as a file.
    #[error(transparent)]
    File(#[from] TextFileError),
    /// The configuration of the robot is wrong, or does not fit the domain or the world.
    #[error(transparent)]
    Configuration(#[from] Diagnostics),
    /// No folder is known for the locks.
    #[error(transparent)]
    NoHomeFolder(#[from] NoHomeFolder),
    /// The folder of the locks cannot be made.
    #[error("cannot make {}: {}", .path.display(), .error)]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The error.
        error: std::io::Error,
    },
    /// The robot cannot be opened, or was stopped while it was opened.
    #[error(transparent)]
    Robot(#[from] RobotError),
}

impl OpenError {
    /// Returns the next step for the user, if there is one. The findings of a configuration have their own.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::Reference(error) => Some(error.hint()),
            Self::File(error) => error.hint(),
            Self::NoHomeFolder(error) => Some(error.hint()),
            Self::Robot(error) => error.hint(),
            Self::Configuration(_) | Self::Folder { .. } => None,
        }
    }
}

/// Opens a robot in a world. A robot that is no simulation moves only if the options say so, and only if no other program
/// drives it; otherwise the result is a dry run.
///
/// The request stops the robot from then on, and ends the opening of a robot that takes its time. Orders of an interrupted run
/// have ended when this returns.
///
/// ```
/// use longstep_core::{domain, environment};
/// use longstep_robot::{OpenOptions, RobotReference, RunStart, Scope, StopRequest, open};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let world = environment::parse(&household, "env.json", r#"{"assets": ["<desk>"], "objects": ["<pen>"]}"#).unwrap();
/// let reference: RobotReference = "sim:seed=7".parse()?;
/// let request = StopRequest::default();
/// let mut opened = open(&reference, &world, &OpenOptions::default(), &request, RunStart::New)?;
/// assert!(!opened.is_dry && opened.robot.observe(&Scope::All)?.of_entity("<pen>").is_some());
/// request.stop();
/// assert!(opened.robot.observe(&Scope::All).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`OpenError`]; the robot's own errors, [`RobotError::InUse`] for one that another program drives among them.
pub fn open(
    reference: &RobotReference,
    world: &World,
    options: &OpenOptions,
    request: &StopRequest,
    start: RunStart,
) -> Result<Opened, OpenError> {
    let opening = Opening { world, options };
    let opened = match reference.kind() {
        RobotKind::Sim(own) => opening.moving(Sim::new(world.clone(), own)?),
        #[cfg(unix)]
        RobotKind::Process(command) => opening.process(command, request),
        RobotKind::Ros2(file) => opening.ros2(file, start),
        RobotKind::VirtualHome(own) => {
            let locks = opening.locks()?;
            let open = || Ok(Box::new(VirtualHome::open(world.clone(), own)?) as Box<dyn Robot>);
            Ok(Opened::new(Exclusive::open(&own.drives(), &locks, open)?))
        }
    }?;
    request.attach(opened.robot.stop_switch());
    if request.is_requested() {
        Err(RobotError::Stopped.into())
    } else {
        Ok(opened)
    }
}

/// Returns the folder of the locks of robots beside the sessions, which is made if it does not exist.
///
/// # Errors
///
/// No folder is known, or it cannot be made.
pub fn lock_folder() -> Result<PathBuf, OpenError> {
    let sessions = session_directory()?;
    let path = sessions.parent().unwrap_or(&sessions).join("robots");
    match std::fs::create_dir_all(&path) {
        Ok(()) => Ok(path),
        Err(error) => Err(OpenError::Folder { path, error }),
    }
}

/// Reads the configuration of a robot in ROS 2, which has to fit the domain and the world.
///
/// # Errors
///
/// A file that cannot be read; mistakes in it, with their places.
fn configuration(file: &Path, domain: &Domain, world: &World) -> Result<Configuration, OpenError> {
    let configuration = Configuration::parse(&file.display().to_string(), &read_text(file)?)?;
    let checked = ros2::check(&configuration, domain, Some(world));
    if checked.mismatches.is_empty() {
        Ok(configuration)
    } else {
        Err(Diagnostics(checked.mismatches).into())
    }
}

/// A robot that is being opened.
struct Opening<'a> {
    world: &'a World,
    options: &'a OpenOptions,
}

impl Opening<'_> {
    fn locks(&self) -> Result<PathBuf, OpenError> {
        self.options.locks.clone().map_or_else(lock_folder, Ok)
    }

    #[cfg(unix)]
    fn process(&self, command: &str, request: &StopRequest) -> Result<Opened, OpenError> {
        let domain = &self.world.domain().name;
        let command = crate::process::Command::parse(command)?
            .presences(self.locks()?)
            .scene(domain, self.world.environment().clone());
        let robot = command.open_until(request)?;
        if self.options.live || robot.describe().simulated {
            return self.moving(robot);
        }
        let description = robot.describe().clone();
        drop(robot);
        let message = |order: &crate::order::Order| {
            serde_json::to_value(order).map_err(|error| RobotError::InvalidOrder {
                step: order.step,
                reason: error.to_string(),
            })
        };
        Ok(dry(DryRun::new(&description, self.world.clone(), message)?))
    }

    fn ros2(&self, file: &Path, start: RunStart) -> Result<Opened, OpenError> {
        let domain = self.world.domain();
        let configuration = configuration(file, domain, self.world)?;
        let autonomy = configuration.autonomy(domain, Some(self.world))?;
        let opened = if self.options.live || configuration.is_simulated() {
            self.connected(configuration, start)?
        } else {
            let preview = Preview::new(configuration, domain);
            let description = preview.description().clone();
            let message = move |order: &crate::order::Order| preview.message(order);
            dry(DryRun::new(&description, self.world.clone(), message)?)
        };
        Ok(Opened { autonomy, ..opened })
    }

    /// Connects to a robot behind a bridge, which no other program may drive by then.
    fn connected(&self, configuration: Configuration, start: RunStart) -> Result<Opened, OpenError> {
        let (drives, domain) = (configuration.drives(), self.world.domain());
        let mut cancelled = 0;
        let robot = Exclusive::open(&drives, &self.locks()?, || {
            let robot = match start {
                RunStart::New => Ros2::connect(configuration, domain)?,
                RunStart::Interrupted => Ros2::reconnect(configuration, domain)?,
            };
            cancelled = robot.cancelled();
            Ok(Box::new(robot))
        })?;
        Ok(Opened {
            cancelled,
            ..Opened::new(robot)
        })
    }

    /// Returns a robot that moves, with its locks.
    fn moving(&self, robot: impl Robot + 'static) -> Result<Opened, OpenError> {
        let drives = robot.describe().drives.clone();
        if drives.is_empty() {
            return Ok(Opened::new(robot));
        }
        Ok(Opened::new(Exclusive::take(Box::new(robot), &drives, &self.locks()?)?))
    }
}

fn dry(robot: DryRun) -> Opened {
    Opened {
        is_dry: true,
        ..Opened::new(robot)
    }
}
