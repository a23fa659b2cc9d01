//! The arguments of `longstep teach`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use longstep_teach::Hand;

use super::model::seconds;

#[derive(Debug, Args)]
pub(crate) struct TeachArguments {
    /// Plan: a verified plan in the paper's JSON format
    #[arg(value_name = "PLAN.json")]
    pub(crate) plan: PathBuf,
    /// Recording of the hand: .csv, .json, .jsonl or .mcap; several files: one for each step [default: ask for each step]
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub(crate) demo: Vec<PathBuf>,
    /// Program that records the hand while you show a step: it writes CSV or JSON Lines to its standard output until Ctrl-C
    #[arg(long, value_name = "COMMAND", conflicts_with_all = ["demo", "segments", "json"])]
    pub(crate) recorder: Option<String>,
    /// Longest time in seconds in which the recorder may write nothing [default: 30]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, requires = "recorder")]
    pub(crate) silence: Option<Duration>,
    /// Times of the steps in a recording, in seconds: 1:0-2.4,2:2.4-3.1
    #[arg(long, value_name = "STEP:FROM-TO,...", requires = "demo")]
    pub(crate) segments: Option<String>,
    /// File of the values, for `longstep run --skills`
    #[arg(long, short, value_name = "FILE", default_value = "skills.json")]
    pub(crate) output: PathBuf,
    /// Hand that demonstrates [default: any, but the hand that grasps also carries]
    #[arg(long, value_enum, value_name = "HAND")]
    pub(crate) hand: Option<HandArgument>,
    /// Frame of reference of the robot; a recording that names another one is refused
    #[arg(long, value_name = "NAME", default_value = "world")]
    pub(crate) frame: String,
    /// Positions of objects in metres, to compare with: {"<juice>": [0.3, 0.2, 0.8]}
    #[arg(long, value_name = "FILE.json")]
    pub(crate) positions: Option<PathBuf>,
    /// Environment file (the world before the plan) [default: the plan's own `environment_before`]
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: Option<PathBuf>,
    /// Environment of the project, for a plan without one of its own.
    #[arg(skip)]
    pub(crate) project_env: Option<PathBuf>,
    /// Domain (the robot's actions with their skill parameters): the name of a shipped domain, or a folder [default:
    /// household-taught]
    #[arg(long, value_name = "DOMAIN")]
    pub(crate) domain: Option<String>,
    /// File of rules that bind every plan, one a line: never opened(fridge)
    #[arg(long, value_name = "FILE")]
    pub(crate) rules: Option<PathBuf>,
    /// Print one JSON object with the values and the findings
    #[arg(long, requires = "demo")]
    pub(crate) json: bool,
}

impl TeachArguments {
    pub(crate) fn domain(&self) -> &str {
        self.domain.as_deref().unwrap_or("household-taught")
    }
}

/// A hand of the person.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum HandArgument {
    /// The left hand
    Left,
    /// The right hand
    Right,
}

impl From<HandArgument> for Hand {
    fn from(argument: HandArgument) -> Self {
        match argument {
            HandArgument::Left => Self::Left,
            HandArgument::Right => Self::Right,
        }
    }
}
