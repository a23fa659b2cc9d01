//! The arguments of `longstep robot`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

#[derive(Debug, Subcommand)]
pub(crate) enum RobotCommand {
    /// Compare a robot.toml with a domain, and try the connection without moving anything
    Check(RobotCheckArguments),
    /// Make an environment file from what a running simulator has in its scene
    Environment(RobotEnvironmentArguments),
}

#[derive(Debug, Args)]
pub(crate) struct RobotCheckArguments {
    /// Configuration of a robot behind ROS 2
    #[arg(value_name = "ROBOT.toml")]
    pub(crate) file: PathBuf,
    /// Domain (the robot's actions): the name of a shipped domain, or a folder [default: household]
    #[arg(long, value_name = "DOMAIN")]
    pub(crate) domain: Option<String>,
    /// Environment file: also compare tables and observations with its entities
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: Option<PathBuf>,
    /// Do not try the connection
    #[arg(long)]
    pub(crate) offline: bool,
}

#[derive(Debug, Args)]
pub(crate) struct RobotEnvironmentArguments {
    /// Simulator: virtualhome:URL
    #[arg(value_name = "ROBOT")]
    pub(crate) robot: String,
    /// Load this scene first, by its number, without characters and with everything in its place
    #[arg(long, value_name = "N")]
    pub(crate) scene: Option<i64>,
    /// Only what is in this room; several with several options [default: all rooms]
    #[arg(long, value_name = "ROOM")]
    pub(crate) room: Vec<String>,
    /// Save the environment to a file instead of printing it
    #[arg(long, value_name = "ENV.json")]
    pub(crate) save: Option<PathBuf>,
}
