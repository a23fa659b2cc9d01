//! The arguments for a world, and for a plan in it.

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
pub(crate) struct WorldArguments {
    /// Environment file (the world before the plan), in the paper's JSON format
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: PathBuf,
    /// Domain (the robot's actions): the name of a shipped domain, or a folder
    #[arg(long, value_name = "DOMAIN", default_value = "household")]
    pub(crate) domain: String,
    /// File of rules that bind every plan, one a line: never opened(fridge)
    #[arg(long, value_name = "FILE")]
    pub(crate) rules: Option<PathBuf>,
}

/// A plan and its world.
#[derive(Debug, Args)]
pub(crate) struct DraftArguments {
    /// Plan: a file in the paper's JSON format, a script (.py), a model's reply that contains a plan, or what a planner prints
    #[arg(value_name = "PLAN")]
    pub(crate) plan: PathBuf,
    /// Environment file (the world before the plan) [default: the plan's own `environment_before`]
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: Option<PathBuf>,
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
