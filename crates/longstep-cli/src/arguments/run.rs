//! The arguments of `longstep run`, and those for execution.

use std::path::PathBuf;

use clap::{ArgGroup, Args, ValueEnum};

use super::model::ModelArguments;
use super::strategy::StrategyArguments;

/// A plan or an instruction, and the robot that carries it out.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("run").required(true).args(["what", "resume", "list"])))]
pub(crate) struct RunArguments {
    /// Plan file, or an instruction in plain words (needs --env)
    #[arg(value_name = "PLAN.json|INSTRUCTION")]
    pub(crate) what: Option<String>,
    /// List the runs that were kept, with their names
    #[arg(long)]
    pub(crate) list: bool,
    /// Interrupted run to resume, its name in `--list` or its log: a step that was under way is observed, or you are asked
    #[arg(long, value_name = "RUN", conflicts_with_all = ["env", "domain", "goal", "rules", "skills", "log", "observe", "changes"])]
    pub(crate) resume: Option<PathBuf>,
    /// Robot: sim, sim:OPTION=VALUE,..., process:COMMAND, ros2:robot.toml or virtualhome:URL [default with --resume: the robot of the run]
    #[arg(long, value_name = "ROBOT")]
    pub(crate) robot: Option<String>,
    /// Environment file (the world before the plan) [default: the plan's own `environment_before`]
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: Option<PathBuf>,
    /// Environment of the project, for an instruction and for a plan without one of its own.
    #[arg(skip)]
    pub(crate) project_env: Option<PathBuf>,
    /// Domain (the robot's actions): the name of a shipped domain, or a folder [default: household]
    #[arg(long, value_name = "DOMAIN")]
    pub(crate) domain: Option<String>,
    /// File of rules that bind every plan, one a line: never opened(fridge)
    #[arg(long, value_name = "FILE")]
    pub(crate) rules: Option<PathBuf>,
    /// Goal of the plan, which it has to achieve and its changes pursue [default: the purpose in the plan file]
    #[arg(long, value_name = "GOAL")]
    pub(crate) goal: Option<String>,
    #[command(flatten)]
    pub(crate) execution: ExecutionArguments,
    /// New file for the log of the run [default: a file beside the sessions]
    #[arg(long, value_name = "RUN.jsonl")]
    pub(crate) log: Option<PathBuf>,
    /// Also save the environment after the run to a file
    #[arg(long, value_name = "ENV.json")]
    pub(crate) save_after: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) model: ModelArguments,
    #[command(flatten)]
    pub(crate) strategy: StrategyArguments,
    /// Print the events as JSON, one a line
    #[arg(long)]
    pub(crate) json: bool,
}

/// The monitoring and the approval of a plan that a robot carries out.
#[derive(Debug, Args)]
pub(crate) struct ExecutionArguments {
    /// Move a robot that is not a simulation; without this, a dry run shows what it would be sent
    #[arg(long)]
    pub(crate) live: bool,
    /// When to ask you: never, before the plan and each change of it, or also before each step; with --resume, the stricter of
    /// this and the run's own setting counts [default: changes]
    #[arg(long, value_enum)]
    pub(crate) approve: Option<ApprovalArgument>,
    /// Evidence that the goal is reached: observations, or also the robot's promises; with --resume, the stricter counts
    /// [default: observed]
    #[arg(long, value_enum)]
    pub(crate) trust: Option<TrustArgument>,
    /// When to observe the world; in any case before the first step and before the end [default: each-step]
    #[arg(long, value_enum)]
    pub(crate) observe: Option<ObserveArgument>,
    /// Number of changes of the plan after which the run stops [default: 8]
    #[arg(long, value_name = "N")]
    pub(crate) changes: Option<u32>,
    /// Values of skill parameters, by action and arguments
    #[arg(long, value_name = "SKILLS.json")]
    pub(crate) skills: Option<PathBuf>,
    /// Levels of autonomy by action, and limits of values and places, besides those of the robot's own file
    #[arg(long, value_name = "AUTONOMY.toml")]
    pub(crate) autonomy: Option<PathBuf>,
}

/// When a person is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ApprovalArgument {
    /// Never
    Never,
    /// Before the first step, and before each change of the plan
    Changes,
    /// Also before each step
    EachStep,
}

/// The evidence that progress and the end need.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TrustArgument {
    /// Facts observed since the last step that could have changed them; you are asked about the rest
    Observed,
    /// Also what the robot says it did; the run says what nobody has seen
    Promised,
}

/// When the world is observed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ObserveArgument {
    /// After each step
    EachStep,
    /// After a failed step, and where a stage of the goal would be achieved
    OnFailure,
}
