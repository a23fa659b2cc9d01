//! The arguments for a world, and for a plan in it.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;

use crate::exit_code::WRONG_ARGUMENTS;
use crate::failure::Failure;

#[derive(Debug, Args)]
pub(crate) struct WorldArguments {
    /// Environment file (the world before the plan), in the paper's JSON format
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: Option<PathBuf>,
    /// Domain (the robot's actions): the name of a shipped domain, or a folder [default: household]
    #[arg(long, value_name = "DOMAIN")]
    pub(crate) domain: Option<String>,
    /// File of rules that bind every plan, one a line: never opened(fridge)
    #[arg(long, value_name = "FILE")]
    pub(crate) rules: Option<PathBuf>,
}

impl WorldArguments {
    pub(crate) fn env(&self) -> Result<&Path> {
        required(self.env.as_deref())
    }
}

/// The domain where none is named.
const DOMAIN: &str = "household";

/// Returns the name of a domain; `household` if none is given.
pub(crate) fn domain_or_default(named: Option<&String>) -> &str {
    named.map_or(DOMAIN, String::as_str)
}

/// Returns an environment file, which has to be given.
pub(crate) fn required(env: Option<&Path>) -> Result<&Path> {
    env.ok_or_else(|| {
        Failure::new("no environment is given", WRONG_ARGUMENTS)
            .hint("pass the environment with `--env ENV.json`, or name it in longstep.toml: environment = \"ENV.json\"")
            .into()
    })
}

/// A plan and its world.
#[derive(Debug, Args)]
pub(crate) struct DraftArguments {
    /// Plan: a file in the paper's JSON format, a script (.py), a model's reply that contains a plan, or what a planner prints;
    /// `-` reads stdin
    #[arg(value_name = "PLAN")]
    pub(crate) plan: PathBuf,
    /// Environment file (the world before the plan) [default: the plan's own `environment_before`]
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: Option<PathBuf>,
    /// Environment of the project, for a plan without one of its own.
    #[arg(skip)]
    pub(crate) project_env: Option<PathBuf>,
    /// PDDL problem: the world before the plan, and the goal that it has to reach
    #[arg(long, value_name = "FILE.pddl", requires = "domain", conflicts_with_all = ["env", "rules"])]
    pub(crate) problem: Option<PathBuf>,
    /// Domain (the robot's actions): the name of a shipped domain, or a folder; with --problem, a PDDL file or its folder
    /// [default: household]
    #[arg(long, value_name = "DOMAIN")]
    pub(crate) domain: Option<String>,
    /// File of rules that bind every plan, one a line: never opened(fridge)
    #[arg(long, value_name = "FILE")]
    pub(crate) rules: Option<PathBuf>,
}
