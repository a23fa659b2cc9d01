//! The command line's arguments.

mod complete;
mod domain;
mod eval;
mod model;
mod robot;
mod run;
mod see;
mod serve;
mod strategy;
mod teach;
mod world;

use std::path::PathBuf;

use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use longstep::Effort;

pub(crate) use domain::{DomainCommand, NewDomainArguments, NodesLanguage, TryArguments};
pub(crate) use eval::{EvalArguments, EvalCommand};
pub(crate) use model::{ModelArguments, ModelCommand};
pub(crate) use robot::{RobotCheckArguments, RobotCommand, RobotEnvironmentArguments};
pub(crate) use run::{ApprovalArgument, ExecutionArguments, ObserveArgument, RunArguments, TrustArgument};
pub(crate) use see::SeeArguments;
pub(crate) use serve::{AccessArguments, HubArguments, McpArguments, ServeArguments};
pub(crate) use strategy::StrategyArguments;
pub(crate) use teach::TeachArguments;
pub(crate) use world::{DraftArguments, WorldArguments, domain_or_default, required};

/// Turns instructions in plain words into verified robot action plans.
#[derive(Debug, Parser)]
#[command(name = "longstep", version, arg_required_else_help = true, max_term_width = 80)]
#[command(
    after_help = "Exit codes: 0 verified, 10 not valid, 11 proven unsolvable, 12 search gave up, \
13 clarifying question, 20 limit reached, 30 unreadable input, 40 model or network failed, 50 run stopped, \
51 robot failed, 52 robot gone, 53 robot late, 54 step rejected, 55 robot in use, 56 server missing, \
57 server of another type, 58 goal not seen, 60 output not written, 130 interrupted."
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Make an environment from a scene of boxes, from pictures, or from a description in words
    See(SeeArguments),
    /// Turn an instruction into a verified plan
    Plan(PlanArguments),
    /// Plan several instructions, each in the world after the last plan
    Chat(ChatArguments),
    /// List, show and replay saved sessions
    #[command(subcommand)]
    Session(SessionCommand),
    /// Verify a plan step by step
    Verify(VerifyArguments),
    /// Show a plan as a tree: what every step does, why, and what it changes
    Show(ShowArguments),
    /// Make a plan valid with the cheapest edits
    Repair(RepairArguments),
    /// Fit the skill parameters of a plan's steps to demonstrations
    Teach(TeachArguments),
    /// Carry out a plan on a robot: monitor each step, and mend the plan when the world changes
    Run(RunArguments),
    /// List the runs that were kept, and export one for other programs
    #[command(subcommand)]
    Runs(RunsCommand),
    /// Serve sessions, approvals and runs: a page for people, HTTP for programs
    Serve(Box<ServeArguments>),
    /// Serve tools to a language-model agent (Model Context Protocol, on standard input and output)
    Mcp(Box<McpArguments>),
    /// Check the configuration of a robot, or make an environment file from a running simulator
    #[command(subcommand)]
    Robot(RobotCommand),
    /// Print a verified plan in another format
    Export(ExportArguments),
    /// Find a shortest plan for a goal, without a language model
    Solve(SolveArguments),
    /// Combine stored plans: in sequence, in branches, or in parallel
    Compose(ComposeArguments),
    /// Run a suite of test cases and measure the share of correct results
    Eval(EvalArguments),
    /// List, show, check and create domains
    #[command(subcommand)]
    Domain(DomainCommand),
    /// List and download models
    #[command(subcommand)]
    Model(ModelCommand),
    /// Print the JSON Schema of a file that the program reads or writes; without a name, list the schemas
    Schema {
        /// Name of the schema
        name: Option<String>,
    },
}

/// A new session, or one to resume.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("world").args(["env", "resume"])))]
pub(crate) struct ChatArguments {
    /// Environment file (the initial world), in the paper's JSON format
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: Option<PathBuf>,
    /// Resume a session: its name in `longstep session list`, or its folder
    #[arg(long, value_name = "SESSION", conflicts_with_all = ["domain", "session"])]
    pub(crate) resume: Option<String>,
    /// Domain (the robot's actions): the name of a shipped domain, or a folder [default: household]
    #[arg(long, value_name = "DOMAIN")]
    pub(crate) domain: Option<String>,
    /// Folder for the session [default: a new one, listed by `longstep session list`]
    #[arg(long, value_name = "FOLDER")]
    pub(crate) session: Option<PathBuf>,
    /// File of rules that bind every plan, one a line: never opened(fridge)
    #[arg(long, value_name = "FILE", conflicts_with = "resume")]
    pub(crate) rules: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) model: ModelArguments,
    #[command(flatten)]
    pub(crate) strategy: StrategyArguments,
    /// Accept verified plans without confirmation
    #[arg(long, short)]
    pub(crate) yes: bool,
    /// Robot for `/run` and `/observe`: sim, sim:OPTION=VALUE,..., process:COMMAND, ros2:ROBOT.toml or virtualhome:URL
    #[arg(long, value_name = "ROBOT")]
    pub(crate) robot: Option<String>,
    #[command(flatten)]
    pub(crate) execution: ExecutionArguments,
}

#[derive(Debug, Subcommand)]
pub(crate) enum SessionCommand {
    /// List the saved sessions
    List,
    /// Show the instructions of a session and their results
    Show {
        /// Name or folder of the session
        session: String,
        /// Print the events as one JSON array
        #[arg(long)]
        json: bool,
    },
    /// Replay a session with its recorded replies, without a model, and compare the results
    Replay {
        /// Name or folder of the session
        session: String,
    },
}

#[derive(Debug, Subcommand)]
pub(crate) enum RunsCommand {
    /// List the runs that were kept, with their names
    List,
    /// Write a run to a file in another format
    Export {
        /// Name of the run in `longstep runs list`, or its log
        #[arg(value_name = "RUN")]
        run: PathBuf,
        /// Format: mcap, for Foxglove, Lichtblick and the tools of ROS
        #[arg(long, value_enum, default_value_t = RunsFormat::Mcap)]
        format: RunsFormat,
        /// File to write
        #[arg(long, short, value_name = "FILE")]
        output: PathBuf,
    },
}

/// A format of recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RunsFormat {
    /// MCAP with JSON messages
    Mcap,
}

#[derive(Debug, Args)]
pub(crate) struct PlanArguments {
    /// Instruction, in plain words
    pub(crate) instruction: String,
    #[command(flatten)]
    pub(crate) world: WorldArguments,
    #[command(flatten)]
    pub(crate) model: ModelArguments,
    #[command(flatten)]
    pub(crate) strategy: StrategyArguments,
    /// Print the prompt and the tokens of its parts instead of calling the model
    #[arg(long, conflicts_with_all = ["save", "json"])]
    pub(crate) explain_prompt: bool,
    /// Print how the instruction was understood: the model's answers with their likelihoods, and the reason for a question
    #[arg(long)]
    pub(crate) explain: bool,
    /// Let hands, arms or robots work in parallel where that saves time
    #[arg(long)]
    pub(crate) parallel: bool,
    /// Also save the plan to a file, in the paper's JSON format
    #[arg(long, value_name = "PLAN.json")]
    pub(crate) save: Option<PathBuf>,
    /// Print one JSON object; plan, verify, repair, solve and compose share its schema
    #[arg(long)]
    pub(crate) json: bool,
}

/// Stored plans, and their composition: an instruction for a model, or a script.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("wish").required(true).multiple(true).args(["instruction", "script"])))]
pub(crate) struct ComposeArguments {
    /// Instruction, in plain words
    pub(crate) instruction: Option<String>,
    /// Composition script, with the plans' names as calls; no model is used
    #[arg(long, value_name = "COMPOSITION.py")]
    pub(crate) script: Option<PathBuf>,
    /// Stored plans: plan files, or folders with plan files, such as a session's. The file name is the plan's name
    #[arg(long, value_name = "PLAN.json|FOLDER", required = true, num_args = 1..)]
    pub(crate) plans: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) world: WorldArguments,
    #[command(flatten)]
    pub(crate) model: ModelArguments,
    /// Never repair the composed plan
    #[arg(long)]
    pub(crate) no_repair: bool,
    /// Also save the plan to a file, in the paper's JSON format
    #[arg(long, value_name = "PLAN.json")]
    pub(crate) save: Option<PathBuf>,
    /// Print one JSON object; plan, verify, repair, solve and compose share its schema
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct VerifyArguments {
    #[command(flatten)]
    pub(crate) draft: DraftArguments,
    /// Print only the feedback that a model would get; nothing if the plan is valid
    #[arg(long, conflicts_with = "json")]
    pub(crate) feedback: bool,
    /// Print one JSON object; plan, verify, repair, solve and compose share its schema
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ShowArguments {
    #[command(flatten)]
    pub(crate) draft: DraftArguments,
}

#[derive(Debug, Args)]
pub(crate) struct RepairArguments {
    #[command(flatten)]
    pub(crate) draft: DraftArguments,
    /// Also save the repaired plan to a file, in the paper's JSON format
    #[arg(long, value_name = "PLAN.json")]
    pub(crate) save: Option<PathBuf>,
    /// Print one JSON object; plan, verify, repair, solve and compose share its schema
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ExportArguments {
    #[command(flatten)]
    pub(crate) draft: DraftArguments,
    /// Format of the output
    #[arg(long, value_enum)]
    pub(crate) format: PlanFormat,
    /// Goal that the plan has to reach [default: the purpose in the plan file]
    #[arg(long, value_name = "GOAL", conflicts_with = "problem")]
    pub(crate) goal: Option<String>,
    /// `pddl` only: write domain.pddl, problem.pddl and plan.pddl into a folder, which belong together
    #[arg(long, value_name = "FOLDER")]
    pub(crate) folder: Option<PathBuf>,
    /// `bt` only: check the preconditions before each step, so that the tree fails when the world has changed
    #[arg(long)]
    pub(crate) guards: bool,
    /// `svg` and `scene` only: width in pixels, from 120 to 8000
    #[arg(long, value_name = "PIXELS", default_value_t = 900, value_parser = clap::value_parser!(u16).range(120..=8000))]
    pub(crate) width: u16,
}

/// A format of plans.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlanFormat {
    /// The paper's script: calls, if, while, and comments
    Python,
    /// The paper's JSON, with the environments before and after
    Json,
    /// A behavior tree in the XML of BehaviorTree.CPP 4
    Bt,
    /// The steps in PDDL, for VAL and unified-planning; with --folder also the domain and the problem
    Pddl,
    /// A flowchart for Mermaid
    Mermaid,
    /// A graph for Graphviz
    Dot,
    /// A picture of the plan
    Svg,
    /// A picture of the world before the plan, and after it with the differences marked
    Scene,
}

/// Either a goal and an environment, or a PDDL problem.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("task").required(true).args(["goal", "problem"])))]
pub(crate) struct SolveArguments {
    /// Goal that must hold at the end, for example "put(juice, shelf top) & closed(fridge)"
    #[arg(long, value_name = "GOAL")]
    pub(crate) goal: Option<String>,
    /// Environment file (the world before the plan), in the paper's JSON format
    #[arg(long, value_name = "ENV.json", conflicts_with = "problem")]
    pub(crate) env: Option<PathBuf>,
    /// PDDL problem instead of a goal and an environment; --domain is then a PDDL file
    #[arg(long, value_name = "PROBLEM.pddl", requires = "domain")]
    pub(crate) problem: Option<PathBuf>,
    /// Domain (the robot's actions): the name of a shipped domain, or a folder [default: household]
    #[arg(long, value_name = "DOMAIN")]
    pub(crate) domain: Option<String>,
    /// File of rules that bind every plan, one a line: never opened(fridge)
    #[arg(long, value_name = "FILE", conflicts_with = "problem")]
    pub(crate) rules: Option<PathBuf>,
    /// Work of the search: small, normal, large, or millions of units
    #[arg(long, value_name = "EFFORT", default_value = "normal")]
    pub(crate) effort: Effort,
    /// Print the task as a PDDL problem for the domain's domain.pddl instead of solving it
    #[arg(long, conflicts_with_all = ["problem", "json", "save"])]
    pub(crate) pddl: bool,
    /// Write the task as a PDDL domain and problem without variables into a folder instead of solving it, for goals with
    /// an order and for rules, which a problem alone cannot say
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["problem", "json", "save", "pddl"])]
    pub(crate) pddl_task: Option<PathBuf>,
    /// Let hands, arms or robots work in parallel where that saves time
    #[arg(long, conflicts_with_all = ["problem", "pddl"])]
    pub(crate) parallel: bool,
    /// Also save the plan to a file, in the paper's JSON format
    #[arg(long, value_name = "PLAN.json")]
    pub(crate) save: Option<PathBuf>,
    /// Print one JSON object; plan, verify, repair, solve and compose share its schema
    #[arg(long)]
    pub(crate) json: bool,
}
