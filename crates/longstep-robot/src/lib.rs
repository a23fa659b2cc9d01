//! Robots for Longstep.
//!
//! A [`Robot`] performs one step of a verified plan at a time in each lane, reports how the step ended, and observes the
//! world. This crate moves robots; it does not decide what they do: an [`Order`] comes from an execution, which checks
//! the step against the observed world.
//!
//! Key types:
//!
//! - [`Robot`]: the interface of every robot. No method but [`Robot::observe`] and [`Robot::stop`] waits for the robot.
//! - [`Order`]: one step as a robot receives it. [`Progress`]: the state of a step that was started.
//! - [`Observation`]: what a robot saw, in the words of an environment file.
//! - [`drive`]: runs an execution on a robot. [`Sim`]: a simulated robot with seeded mishaps. [`RunLog`]: the log of a run.
//! - [`RunControl`]: stops, pauses and continues a run. [`StopRequest`]: stops a run, also while its robot is being opened. [`StopSwitch`]: stops a robot from any thread,
//!   also while another one waits for it.
//! - [`process::Process`]: a robot behind another program, in any language. [`ros2::Ros2`]: one behind ROS 2.
//! - [`rosbridge`]: the protocol between Longstep and a bridge to ROS 2.
//! - [`virtualhome::VirtualHome`]: a character in the VirtualHome simulator.
//! - [`recorder::Recorder`]: a program that records the hand of a person who shows a step.
//! - [`mcap::Recording`]: a run as an MCAP file, for Foxglove and Lichtblick.
//! - [`DryRun`]: shows what a robot would be sent, and moves nothing. [`Exclusive`]: a robot that no other program drives.
//!
//! Usage:
//!
//! 1. [`open`] a robot that a [`RobotReference`] names, and read its [`Robot::describe`]: actions it lacks are found before anything moves.
//! 2. Give its [`Robot::stop_switch`] to whatever handles signals.
//! 3. [`Robot::start`] an order, then [`Robot::poll`] it until it is [`Progress::Done`] or [`Progress::Failed`].
//! 4. [`Robot::observe`] the world.
//! 5. After an error that [`RobotError::is_final`], the robot is stopped already and accepts nothing more.

mod control;
mod description;
mod drive;
mod dry_run;
mod error;
mod exclusive;
mod fitness;
mod lock;
pub mod mcap;
mod open;
mod order;
mod preflight;
#[cfg(unix)]
mod presence;
/// Process groups and pipes that do not block are those of Unix.
#[cfg(unix)]
pub mod process;
#[cfg(unix)]
mod processes;
#[cfg(unix)]
mod program;
#[cfg(unix)]
pub mod recorder;
mod reference;
mod robot;
pub mod ros2;
pub mod rosbridge;
mod run_log;
mod scope;
mod sim;
mod stop;
pub mod virtualhome;

pub use control::RunControl;
pub use description::{Description, Timeouts};
pub use drive::{Driven, Watcher, drive, order_of, reports};
pub use dry_run::DryRun;
pub use error::RobotError;
pub use exclusive::Exclusive;
pub use fitness::{Unfit, check_observes, check_resumed, observed_reports};
pub use longstep_core::environment::Observation;
pub use open::{OpenError, OpenOptions, Opened, RunStart, lock_folder, open};
pub use order::{ArgumentValue, Order};
pub use preflight::preflight;
#[cfg(unix)]
pub use presence::Presence;
#[cfg(unix)]
pub use program::{CommandLine, CommandLineError};
pub use reference::{ReferenceError, RobotKind, RobotReference};
pub use robot::{Feedback, Handle, Progress, Robot, StopSwitch};
pub use run_log::{RUN_LOG_SCHEMA, RunHeader, RunLog, RunLogError, TimedEvent};
pub use scope::Scope;
pub use sim::{Mishap, Sim, SimCounts, SimOptions, SimOptionsError};
pub use stop::StopRequest;
