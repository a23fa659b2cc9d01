//! The command line's arguments.

mod robot;
mod see;
mod teach;

use std::path::PathBuf;
use std::time::Duration;

use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use longstep::Effort;
use longstep::session::{RepairPolicy, Settings, Strategy};
use longstep_llm::AdapterChoice;

pub(crate) use robot::{RobotCheckArguments, RobotCommand, RobotEnvironmentArguments};
pub(crate) use see::SeeArguments;
pub(crate) use teach::TeachArguments;

/// Turns instructions in plain English into verified robot action plans.
#[derive(Debug, Parser)]
#[command(name = "longstep", version, arg_required_else_help = true, max_term_width = 80)]
#[command(
    after_help = "Exit codes: 0 verified, 10 not valid, 11 proven unsolvable, 12 search gave up, \
13 clarifying question, 20 limit reached, 30 unreadable input, 40 model or network failed, 50 run stopped, \
51 robot failed, 52 robot gone, 53 robot late, 54 step rejected, 55 robot in use, 56 server missing, \
57 server of another type, 60 output not written."
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
    /// Make a plan valid with the cheapest edits
    Repair(RepairArguments),
    /// Fit the skill parameters of a plan's steps to demonstrations
    Teach(TeachArguments),
    /// Carry out a plan on a robot: monitor each step, and mend the plan when the world changes
    Run(RunArguments),
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
}

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

/// The language model and its settings.
#[derive(Debug, Clone, Args)]
pub(crate) struct ModelArguments {
    /// Language model: a name of `longstep model list`, a .gguf file, openai:NAME, azure:DEPLOYMENT,
    /// ollama:NAME, anthropic:NAME, gemini:NAME, URL#NAME or replay:FILE
    #[arg(long, value_name = "MODEL", env = "LONGSTEP_MODEL", hide_env_values = true, default_value = longstep_llm::catalogue::DEFAULT)]
    pub(crate) model: String,
    /// Adapter of an embedded model, a .gguf file, for one of its tasks (repeatable); `off` for none [default: those of the
    /// catalogue]
    #[arg(long, value_name = "FILE")]
    pub(crate) adapter: Vec<PathBuf>,
    /// Threads of an embedded model [default: the number of physical cores]
    #[arg(long, value_name = "N", env = "LONGSTEP_THREADS", hide_env_values = true, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// Sampling temperature, 0 to 2: 0 always takes the most likely token
    #[arg(long, value_name = "T", default_value_t = 0.0, value_parser = temperature)]
    pub(crate) temperature: f64,
    /// Nucleus sampling: keep the most likely tokens up to this total probability
    #[arg(long, value_name = "P", value_parser = share)]
    pub(crate) top_p: Option<f64>,
    /// Seed of the sampling; some servers ignore it
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// Size of the context in tokens, for prompt and answer [default: the server's value, 8192 for an embedded model]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) context: Option<u32>,
    /// Time limit in seconds for one call to a server, including retries
    #[arg(long, value_name = "SECONDS", env = "LONGSTEP_TIMEOUT", default_value = "600", value_parser = seconds)]
    pub(crate) timeout: Duration,
    /// Longest time in seconds in which a server may send nothing
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = seconds)]
    pub(crate) silence: Duration,
    /// Also record all requests and replies in a file; --model replay:FILE replays it
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,
}

impl ModelArguments {
    /// The adapters of an embedded model.
    pub(crate) fn adapters(&self) -> AdapterChoice {
        match &self.adapter[..] {
            [] => AdapterChoice::Catalogue,
            [one] if one.as_os_str() == "off" => AdapterChoice::Off,
            files => AdapterChoice::Files(files.to_vec()),
        }
    }
}

fn temperature(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    (0.0..=2.0)
        .contains(&value)
        .then_some(value)
        .ok_or_else(|| "must be from 0 to 2".to_owned())
}

fn seconds(text: &str) -> Result<Duration, String> {
    /// Upper limit of a timeout.
    const WEEK: f64 = 604_800.0;
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    let duration = (value > 0.0 && value <= WEEK).then(|| Duration::try_from_secs_f64(value));
    match duration {
        Some(Ok(duration)) if !duration.is_zero() => Ok(duration),
        _ => Err("must be above 0 and at most 604800 (one week)".to_owned()),
    }
}

fn share(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    (value > 0.0 && value <= 1.0)
        .then_some(value)
        .ok_or_else(|| "must be above 0 and at most 1".to_owned())
}

/// The strategy for turning an instruction into a plan.
#[derive(Debug, Args)]
pub(crate) struct StrategyArguments {
    /// Output of the model: only a goal, or the whole plan as in the paper
    #[arg(long, value_enum, default_value_t = StrategyArgument::Goal)]
    pub(crate) strategy: StrategyArgument,
    /// Rounds of feedback to the model about its plan
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub(crate) rounds: u32,
    /// Give feedback to the model first, and repair its plan only after the last round
    #[arg(long, conflicts_with = "no_repair")]
    pub(crate) feedback_first: bool,
    /// Never repair the model's plan
    #[arg(long)]
    pub(crate) no_repair: bool,
    /// Do not ask about the parts of an instruction that the plan leaves out
    #[arg(long)]
    pub(crate) accept_partial: bool,
    /// Do not ask an embedded model what an instruction forbids, measures or orders before it writes the goal
    #[arg(long)]
    pub(crate) no_screening: bool,
    /// Do not let an embedded model retell in plain English what it could only ask about
    #[arg(long)]
    pub(crate) no_retelling: bool,
    /// Folder with your own prompt parts (role.md, actions.md, ...), which replace the domain's
    #[arg(long, value_name = "FOLDER")]
    pub(crate) prompt: Option<PathBuf>,
    /// Work of the search for a goal's plan: small, normal, large, or millions of units [default: normal]
    #[arg(long, value_name = "EFFORT")]
    pub(crate) effort: Option<Effort>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum StrategyArgument {
    Goal,
    Direct,
}

impl StrategyArguments {
    pub(crate) fn settings(&self) -> Settings {
        Settings {
            strategy: match self.strategy {
                StrategyArgument::Goal => Strategy::Goal,
                StrategyArgument::Direct => Strategy::Direct,
            },
            repair: match (self.no_repair, self.feedback_first) {
                (true, _) => RepairPolicy::Never,
                (false, true) => RepairPolicy::AfterFeedback,
                (false, false) => RepairPolicy::First,
            },
            rounds: self.rounds,
            effort: self.effort,
            partial: self.accept_partial,
            screening: !self.no_screening,
            retelling: !self.no_retelling,
            ..Settings::default()
        }
    }
}

/// A new session, or one to resume.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("world").required(true).args(["env", "resume"])))]
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

#[derive(Debug, Args)]
pub(crate) struct PlanArguments {
    /// Instruction, in plain English
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
    /// Instruction, in plain English
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

/// A suite and the settings of its run, or a command for runs.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct EvalArguments {
    #[command(subcommand)]
    pub(crate) command: Option<EvalCommand>,
    /// Suite: the name of a shipped suite, a folder, or `paper` with --corpus
    #[arg(required = true)]
    pub(crate) suite: Option<String>,
    /// Folder of the run; an interrupted run is resumed [default: eval/SUITE]
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// Folder of the paper's recordings, for the suite `paper`
    #[arg(long, value_name = "FOLDER", env = "LONGSTEP_CORPUS", hide_env_values = true)]
    pub(crate) corpus: Option<PathBuf>,
    /// Use recorded replies instead of a model: a JSON array of {"case", "trial", "round", "reply"}
    #[arg(long, value_name = "REPLIES.json")]
    pub(crate) replies: Option<PathBuf>,
    /// Suite `paper` only: judge the recorded trials and the recorded feedback as in the paper
    #[arg(long, conflicts_with = "replies")]
    pub(crate) recorded: bool,
    /// Trials of each case; each further trial adds 1 to the seed
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) trials: u32,
    /// Run only cases with this tag; with several tags, cases that have all of them
    #[arg(long = "tag", value_name = "TAG")]
    pub(crate) tags: Vec<String>,
    /// Run only the case with this id
    #[arg(long = "case", value_name = "ID")]
    pub(crate) cases: Vec<String>,
    /// Run only this wording: `plain`, or one of the cases' own, such as `goal_level` [default: all]
    #[arg(long = "wording", value_name = "WORDING")]
    pub(crate) wordings: Vec<String>,
    /// Parallel requests to a server
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=64))]
    pub(crate) jobs: u16,
    /// Rename an action in prompts and plans, for example Put=PutSurface
    #[arg(long = "rename", value_name = "OLD=NEW", value_parser = renaming)]
    pub(crate) renamed: Vec<(String, String)>,
    /// Maximum number of worked examples in the prompt
    #[arg(long, value_name = "N")]
    pub(crate) examples: Option<usize>,
    #[command(flatten)]
    pub(crate) model: ModelArguments,
    #[command(flatten)]
    pub(crate) strategy: StrategyArguments,
    /// Print the measures as one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// Only check that the expected goals of the suite can be reached
    #[arg(long, conflicts_with_all = ["replies", "recorded"])]
    pub(crate) check: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum EvalCommand {
    /// List the shipped suites
    List,
    /// Write the reports of a run again, and print its summary
    Report {
        /// Folder of the run
        run: PathBuf,
    },
    /// Compare two runs: measures, and cases that became correct or incorrect
    Compare {
        /// Folder of the first run
        before: PathBuf,
        /// Folder of the second run
        after: PathBuf,
        /// Also write the comparison to an HTML file
        #[arg(long, value_name = "FILE.html")]
        html: Option<PathBuf>,
    },
}

fn renaming(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((old, new)) if !old.is_empty() && !new.is_empty() => Ok((old.to_owned(), new.to_owned())),
        _ => Err("expected OLD=NEW, for example Put=PutSurface".to_owned()),
    }
}

/// A plan and its world.
#[derive(Debug, Args)]
pub(crate) struct DraftArguments {
    /// Plan: a file in the paper's JSON format, a script (.py), or a model's reply that contains a plan
    #[arg(value_name = "PLAN.json")]
    pub(crate) plan: PathBuf,
    /// Environment file (the world before the plan) [default: the plan's own `environment_before`]
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: Option<PathBuf>,
    /// Domain (the robot's actions): the name of a shipped domain, or a folder
    #[arg(long, value_name = "DOMAIN", default_value = "household")]
    pub(crate) domain: String,
    /// File of rules that bind every plan, one a line: never opened(fridge)
    #[arg(long, value_name = "FILE")]
    pub(crate) rules: Option<PathBuf>,
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

/// A plan or an instruction, and the robot that carries it out.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("run").required(true).args(["what", "resume"])))]
pub(crate) struct RunArguments {
    /// Plan file, or an instruction in plain English (needs --env)
    #[arg(value_name = "PLAN.json|INSTRUCTION")]
    pub(crate) what: Option<String>,
    /// Log of an interrupted run to resume: a step that was under way is observed, or you are asked
    #[arg(long, value_name = "RUN.jsonl", conflicts_with_all = ["env", "goal", "rules", "skills", "log"])]
    pub(crate) resume: Option<PathBuf>,
    /// Robot: sim, sim:OPTION=VALUE,..., process:COMMAND, ros2:robot.toml or virtualhome:URL [default with --resume: the robot of the run]
    #[arg(long, value_name = "ROBOT")]
    pub(crate) robot: Option<String>,
    /// Environment file (the world before the plan) [default: the plan's own `environment_before`]
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: Option<PathBuf>,
    /// Domain (the robot's actions): the name of a shipped domain, or a folder
    #[arg(long, value_name = "DOMAIN", default_value = "household")]
    pub(crate) domain: String,
    /// File of rules that bind every plan, one a line: never opened(fridge)
    #[arg(long, value_name = "FILE")]
    pub(crate) rules: Option<PathBuf>,
    /// Goal of the plan file, which changes of the plan pursue [default: what the plan itself brings about]
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
    /// When to ask you: never, before the plan and each change of it, or also before each step
    #[arg(long, value_enum, default_value_t = ApprovalArgument::Changes)]
    pub(crate) approve: ApprovalArgument,
    /// When to observe the world; in any case before the end
    #[arg(long, value_enum, default_value_t = ObserveArgument::EachStep)]
    pub(crate) observe: ObserveArgument,
    /// Number of changes of the plan after which the run stops
    #[arg(long, value_name = "N", default_value_t = 8)]
    pub(crate) changes: u32,
    /// Values of skill parameters, by action and arguments
    #[arg(long, value_name = "SKILLS.json")]
    pub(crate) skills: Option<PathBuf>,
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

/// When the world is observed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ObserveArgument {
    /// Before the first step and after each step
    EachStep,
    /// After a failed step
    OnFailure,
}

#[derive(Debug, Args)]
pub(crate) struct ExportArguments {
    #[command(flatten)]
    pub(crate) draft: DraftArguments,
    /// Format of the output
    #[arg(long, value_enum)]
    pub(crate) format: PlanFormat,
}

/// A format of plans.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlanFormat {
    /// The paper's script: calls, if, while, and comments
    Python,
    /// The paper's JSON, with the environments before and after
    Json,
}

/// Either a goal and an environment, or a PDDL problem.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("task").required(true).args(["goal", "problem"])))]
pub(crate) struct SolveArguments {
    /// Goal that must hold at the end, for example "put(juice, shelf top) & closed(fridge)"
    #[arg(long, value_name = "GOAL", requires = "env")]
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

#[derive(Debug, Subcommand)]
pub(crate) enum DomainCommand {
    /// List the shipped domains
    List,
    /// Show the actions, states and goals of a domain
    Show {
        /// Name of a shipped domain, or a folder
        domain: String,
        /// Environment file: also show its entities, their facts, and the origin of each fact
        #[arg(long, value_name = "ENV.json")]
        env: Option<PathBuf>,
    },
    /// Report the errors in a domain, and warnings about probable mistakes
    Check {
        /// Folder, or the name of a shipped domain
        domain: String,
        /// Environment file: also warn about entities without a use, and about names that derivations miss
        #[arg(long, value_name = "ENV.json")]
        env: Option<PathBuf>,
        /// Exit with code 10 if there are warnings
        #[arg(long)]
        strict: bool,
        /// Print the warnings as one JSON array
        #[arg(long)]
        json: bool,
    },
    /// Create the folder of a new domain: from answers to a few questions, from a PDDL file, or a commented example
    New(NewDomainArguments),
    /// Make five instructions from a domain's own sentences, and show what a model understands
    Try(TryArguments),
}

#[derive(Debug, Args)]
pub(crate) struct NewDomainArguments {
    /// Folder, which must not exist yet
    pub(crate) folder: PathBuf,
    /// Read the answers from a file instead of asking
    #[arg(long, value_name = "ANSWERS.toml", conflicts_with_all = ["pddl", "ask", "starter"])]
    pub(crate) from: Option<PathBuf>,
    /// Make the domain from a PDDL domain file of any origin
    #[arg(long, value_name = "DOMAIN.pddl", conflicts_with_all = ["ask", "starter"])]
    pub(crate) pddl: Option<PathBuf>,
    /// PDDL problem whose objects and initial state become the example environment
    #[arg(long, value_name = "PROBLEM.pddl", requires = "pddl")]
    pub(crate) problem: Option<PathBuf>,
    /// Ask the questions, also without a terminal [default in a terminal]
    #[arg(long, conflicts_with = "starter")]
    pub(crate) ask: bool,
    /// Write a commented example to change by hand [default without a terminal]
    #[arg(long)]
    pub(crate) starter: bool,
}

#[derive(Debug, Args)]
pub(crate) struct TryArguments {
    /// Folder of a domain, or the name of a shipped domain
    pub(crate) domain: String,
    /// Environment file [default: environment.json in the domain's folder]
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: Option<PathBuf>,
    /// The model; --seed also selects other instructions
    #[command(flatten)]
    pub(crate) model: ModelArguments,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum ModelCommand {
    /// List the models of the catalogue, and which of them are downloaded
    List,
    /// Download a model of the catalogue into the cache
    Pull {
        /// Name in the catalogue
        name: String,
        /// Use this file instead of downloading one
        #[arg(long, value_name = "FILE")]
        from: Option<PathBuf>,
    },
    /// Print the path of a model's file
    Path {
        /// Name in the catalogue
        name: String,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_positive_and_finite() {
        for (text, expected) in [("600", Some(600.0)), ("0.5", Some(0.5)), ("604800", Some(604_800.0))] {
            assert_eq!(seconds(text).ok().map(|time| time.as_secs_f64()), expected, "{text}");
        }
        for text in ["0", "-1", "1e-30", "604801", "inf", "NaN", "", "soon"] {
            assert!(seconds(text).is_err(), "{text}");
        }
    }
}
