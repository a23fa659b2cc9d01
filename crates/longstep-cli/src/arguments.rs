//! The command line's arguments.

use std::path::PathBuf;
use std::time::Duration;

use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use longstep::session::{RepairPolicy, Settings, Strategy};

/// Say what you want; get a robot action plan that has been checked, step by step.
#[derive(Debug, Parser)]
#[command(name = "longstep", version, arg_required_else_help = true)]
#[command(
    after_help = "Exit codes: 0 verified, 10 not valid, 11 proven unsolvable, 12 search gave up, \
13 a question back, 20 a limit, 30 unreadable input, 40 model or network, 50 output not written."
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Turn an instruction into a verified plan
    Plan(PlanArguments),
    /// Give one instruction after the other, each in the world that the last plan left
    Chat(ChatArguments),
    /// Look at sessions that are kept
    #[command(subcommand)]
    Session(SessionCommand),
    /// Check a plan step by step
    Verify(VerifyArguments),
    /// Make a plan valid with the least change
    Repair(RepairArguments),
    /// Write a verified plan in another notation
    Export(ExportArguments),
    /// Find a shortest plan for a goal, without a language model
    Solve(SolveArguments),
    /// Put stored plans together: one after the other, in branches, side by side
    Compose(ComposeArguments),
    /// Measure how many instructions of a suite come out right
    Eval(EvalArguments),
    /// Look at domains, check one, begin a new one
    #[command(subcommand)]
    Domain(DomainCommand),
    /// Look at models and fetch one
    #[command(subcommand)]
    Model(ModelCommand),
}

#[derive(Debug, Args)]
pub(crate) struct WorldArguments {
    /// The world: an environment file in the paper's JSON
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: PathBuf,
    /// What the robot can do: a shipped domain's name or a folder
    #[arg(long, value_name = "DOMAIN", default_value = "household")]
    pub(crate) domain: String,
}

/// Which language model, and how it is asked.
#[derive(Debug, Clone, Args)]
pub(crate) struct ModelArguments {
    /// Which language model: a name of `longstep model list`, a .gguf file, openai:NAME, azure:DEPLOYMENT,
    /// ollama:NAME, anthropic:NAME, gemini:NAME, URL#NAME or replay:FILE
    #[arg(long, value_name = "MODEL", env = "LONGSTEP_MODEL", hide_env_values = true, default_value = longstep_llm::catalogue::DEFAULT)]
    pub(crate) model: String,
    /// Threads of an embedded model [default: one for each physical core]
    #[arg(long, value_name = "N", env = "LONGSTEP_THREADS", hide_env_values = true, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// How freely the model chooses its words: 0 takes the likeliest
    #[arg(long, value_name = "T", default_value_t = 0.0, value_parser = temperature)]
    pub(crate) temperature: f64,
    /// Of the likeliest words, only those that make up this share
    #[arg(long, value_name = "P", value_parser = share)]
    pub(crate) top_p: Option<f64>,
    /// The same seed chooses the same words again, where the model keeps to it
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// Tokens that prompt and answer may have together [default: what the model says, 8192 for an embedded one]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) context: Option<u32>,
    /// Seconds that one call to a server may take, with all its tries
    #[arg(long, value_name = "SECONDS", env = "LONGSTEP_TIMEOUT", default_value = "600", value_parser = seconds)]
    pub(crate) timeout: Duration,
    /// Seconds that a server may send nothing
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = seconds)]
    pub(crate) silence: Duration,
    /// Also write every request and its reply to a file, which --model replay:FILE answers from
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,
}

fn temperature(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "it is not a number".to_owned())?;
    (0.0..=2.0)
        .contains(&value)
        .then_some(value)
        .ok_or_else(|| "it is from 0 to 2".to_owned())
}

fn seconds(text: &str) -> Result<Duration, String> {
    /// Upper limit of a timeout.
    const WEEK: f64 = 604_800.0;
    let value: f64 = text.parse().map_err(|_| "it is not a number".to_owned())?;
    let duration = (value > 0.0 && value <= WEEK).then(|| Duration::try_from_secs_f64(value));
    match duration {
        Some(Ok(duration)) if !duration.is_zero() => Ok(duration),
        _ => Err("it is above 0 and up to 604800 (a week)".to_owned()),
    }
}

fn share(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "it is not a number".to_owned())?;
    (value > 0.0 && value <= 1.0)
        .then_some(value)
        .ok_or_else(|| "it is above 0 and up to 1".to_owned())
}

/// How an instruction becomes a plan.
#[derive(Debug, Args)]
pub(crate) struct StrategyArguments {
    /// What the model writes: only the goal, or the whole plan as in the paper
    #[arg(long, value_enum, default_value_t = StrategyArgument::Goal)]
    pub(crate) strategy: StrategyArgument,
    /// How often the model is told what is wrong with its plan
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub(crate) rounds: u32,
    /// Tell the model what is wrong first, and repair its plan only when the rounds are used up
    #[arg(long, conflicts_with = "no_repair")]
    pub(crate) feedback_first: bool,
    /// Never repair a plan of the model
    #[arg(long)]
    pub(crate) no_repair: bool,
    /// A folder with prompt parts of your own (role.md, actions.md, ...) in place of the domain's
    #[arg(long, value_name = "FOLDER")]
    pub(crate) prompt: Option<PathBuf>,
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
            ..Settings::default()
        }
    }
}

/// A session that begins, or one that goes on.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("world").required(true).args(["env", "resume"])))]
pub(crate) struct ChatArguments {
    /// The world to begin in: an environment file in the paper's JSON
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: Option<PathBuf>,
    /// Go on with a session: its name in `longstep session list`, or its folder
    #[arg(long, value_name = "SESSION", conflicts_with_all = ["domain", "session"])]
    pub(crate) resume: Option<String>,
    /// What the robot can do: a shipped domain's name or a folder [default: household]
    #[arg(long, value_name = "DOMAIN")]
    pub(crate) domain: Option<String>,
    /// Keep the session in this folder [default: a new one that `longstep session list` shows]
    #[arg(long, value_name = "FOLDER")]
    pub(crate) session: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) model: ModelArguments,
    #[command(flatten)]
    pub(crate) strategy: StrategyArguments,
    /// Accept verified plans without asking
    #[arg(long, short)]
    pub(crate) yes: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum SessionCommand {
    /// List the sessions that are kept
    List,
    /// Show what happened in a session
    Show {
        /// Its name, or its folder
        session: String,
        /// Write the events as one JSON array for programs
        #[arg(long)]
        json: bool,
    },
    /// Go through a session again with the replies of its log, without a model, and compare
    Replay {
        /// Its name, or its folder
        session: String,
    },
}

#[derive(Debug, Args)]
pub(crate) struct PlanArguments {
    /// What you want, in your own words
    pub(crate) instruction: String,
    #[command(flatten)]
    pub(crate) world: WorldArguments,
    #[command(flatten)]
    pub(crate) model: ModelArguments,
    #[command(flatten)]
    pub(crate) strategy: StrategyArguments,
    /// Do not ask the model: show what it would be sent, and what each part costs in tokens
    #[arg(long, conflicts_with_all = ["save", "json"])]
    pub(crate) explain_prompt: bool,
    /// Let hands, arms or robots work side by side where that saves time
    #[arg(long)]
    pub(crate) parallel: bool,
    /// Also write the plan to a file, in the paper's JSON
    #[arg(long, value_name = "PLAN.json")]
    pub(crate) save: Option<PathBuf>,
    /// Write one JSON object for programs
    #[arg(long)]
    pub(crate) json: bool,
}

/// Stored plans, and what is wanted of them: in words for a model, or as a script.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("wish").required(true).multiple(true).args(["instruction", "script"])))]
pub(crate) struct ComposeArguments {
    /// What you want, in your own words
    pub(crate) instruction: Option<String>,
    /// The composition itself, with the plans' names as calls: then no model is asked
    #[arg(long, value_name = "COMPOSITION.py")]
    pub(crate) script: Option<PathBuf>,
    /// Stored plans: plan files, or folders of them such as a session's. A plan is called like its file
    #[arg(long, value_name = "PLAN.json|FOLDER", required = true, num_args = 1..)]
    pub(crate) plans: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) world: WorldArguments,
    #[command(flatten)]
    pub(crate) model: ModelArguments,
    /// Never repair what the composition comes to
    #[arg(long)]
    pub(crate) no_repair: bool,
    /// Also write the plan to a file, in the paper's JSON
    #[arg(long, value_name = "PLAN.json")]
    pub(crate) save: Option<PathBuf>,
    /// Write one JSON object for programs
    #[arg(long)]
    pub(crate) json: bool,
}

/// A suite, and how it is run; or what is done with runs.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct EvalArguments {
    #[command(subcommand)]
    pub(crate) command: Option<EvalCommand>,
    /// The suite: a shipped one's name, a folder, or `paper` with --corpus
    #[arg(required = true)]
    pub(crate) suite: Option<String>,
    /// Where the run is kept; a run that was cut off goes on from where it was [default: eval/SUITE]
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// The folder of the paper's recordings, for the suite `paper`
    #[arg(long, value_name = "FOLDER", env = "LONGSTEP_CORPUS", hide_env_values = true)]
    pub(crate) corpus: Option<PathBuf>,
    /// Recorded replies instead of a model: a JSON array of {"case", "trial", "round", "reply"}
    #[arg(long, value_name = "REPLIES.json")]
    pub(crate) replies: Option<PathBuf>,
    /// For the suite `paper`: the recorded trials and the recorded feedback, judged as the paper does
    #[arg(long, conflicts_with = "replies")]
    pub(crate) recorded: bool,
    /// How often each case is run; each trial has the next seed
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) trials: u32,
    /// Only cases with this tag; several tags must all be there
    #[arg(long = "tag", value_name = "TAG")]
    pub(crate) tags: Vec<String>,
    /// Only the case with this id
    #[arg(long = "case", value_name = "ID")]
    pub(crate) cases: Vec<String>,
    /// Only this wording: `plain`, or one that cases name, such as `goal_level` [default: all that there are]
    #[arg(long = "wording", value_name = "WORDING")]
    pub(crate) wordings: Vec<String>,
    /// Requests to a server at the same time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=64))]
    pub(crate) jobs: u16,
    /// Call an action by another word in prompts and plans: Put=PutSurface
    #[arg(long = "rename", value_name = "OLD=NEW", value_parser = renaming)]
    pub(crate) renamed: Vec<(String, String)>,
    /// Show the model at most so many worked examples
    #[arg(long, value_name = "N")]
    pub(crate) examples: Option<usize>,
    #[command(flatten)]
    pub(crate) model: ModelArguments,
    #[command(flatten)]
    pub(crate) strategy: StrategyArguments,
    /// Write the measures as one JSON object for programs
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum EvalCommand {
    /// List the shipped suites
    List,
    /// Write the report of a run anew, and print its summary
    Report {
        /// The run's folder
        run: PathBuf,
    },
    /// Show two runs side by side, and what became right or wrong
    Compare {
        /// The run's folder
        before: PathBuf,
        /// The other one's
        after: PathBuf,
        /// Also write the comparison as a page
        #[arg(long, value_name = "FILE.html")]
        html: Option<PathBuf>,
    },
}

fn renaming(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((old, new)) if !old.is_empty() && !new.is_empty() => Ok((old.to_owned(), new.to_owned())),
        _ => Err("it is written OLD=NEW, for example Put=PutSurface".to_owned()),
    }
}

/// A plan and the world that it is for.
#[derive(Debug, Args)]
pub(crate) struct DraftArguments {
    /// The plan, in the paper's JSON or as a script (.py), or a model's reply that holds one
    #[arg(value_name = "PLAN.json")]
    pub(crate) plan: PathBuf,
    /// The world before the plan [default: the plan's own `environment_before`]
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: Option<PathBuf>,
    /// What the robot can do: a shipped domain's name or a folder
    #[arg(long, value_name = "DOMAIN", default_value = "household")]
    pub(crate) domain: String,
}

#[derive(Debug, Args)]
pub(crate) struct VerifyArguments {
    #[command(flatten)]
    pub(crate) draft: DraftArguments,
    /// Write what a model would be told about the plan, if it is not valid
    #[arg(long, conflicts_with = "json")]
    pub(crate) feedback: bool,
    /// Write one JSON object for programs
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct RepairArguments {
    #[command(flatten)]
    pub(crate) draft: DraftArguments,
    /// Also write the repaired plan to a file, in the paper's JSON
    #[arg(long, value_name = "PLAN.json")]
    pub(crate) save: Option<PathBuf>,
    /// Write one JSON object for programs
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ExportArguments {
    #[command(flatten)]
    pub(crate) draft: DraftArguments,
    /// How the plan is written
    #[arg(long, value_enum)]
    pub(crate) format: PlanFormat,
}

/// A notation of plans.
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
    /// What must hold at the end, for example "put(juice, shelf top) & closed(fridge)"
    #[arg(long, value_name = "GOAL", requires = "env")]
    pub(crate) goal: Option<String>,
    /// The world: an environment file in the paper's JSON
    #[arg(long, value_name = "ENV.json", conflicts_with = "problem")]
    pub(crate) env: Option<PathBuf>,
    /// A PDDL problem instead of a goal and an environment; --domain is then a PDDL file
    #[arg(long, value_name = "PROBLEM.pddl", requires = "domain")]
    pub(crate) problem: Option<PathBuf>,
    /// What the robot can do: a shipped domain's name or a folder [default: household]
    #[arg(long, value_name = "DOMAIN")]
    pub(crate) domain: Option<String>,
    /// Do not solve it: print it as a PDDL problem for the domain's domain.pddl
    #[arg(long, conflicts_with_all = ["problem", "json", "save"])]
    pub(crate) pddl: bool,
    /// Let hands, arms or robots work side by side where that saves time
    #[arg(long, conflicts_with_all = ["problem", "pddl"])]
    pub(crate) parallel: bool,
    /// Also write the plan to a file, in the paper's JSON
    #[arg(long, value_name = "PLAN.json")]
    pub(crate) save: Option<PathBuf>,
    /// Write one JSON object for programs
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum DomainCommand {
    /// List the shipped domains
    List,
    /// Show what a domain's robot can do and be asked for
    Show {
        /// A shipped domain's name or a folder
        domain: String,
    },
    /// Report everything that is wrong with a domain's folder, and what probably is
    Check {
        /// The folder (or a shipped domain's name)
        domain: String,
        /// Exit with 10 when there are warnings
        #[arg(long)]
        strict: bool,
        /// Write the warnings as one JSON array for programs
        #[arg(long)]
        json: bool,
    },
    /// Write a commented folder to start from
    New {
        /// The folder, which must not be there yet
        folder: PathBuf,
    },
}

#[derive(Debug, Subcommand)]
pub(crate) enum ModelCommand {
    /// List the models of the catalogue and which of them are here
    List,
    /// Fetch a model of the catalogue into the cache
    Pull {
        /// Its name
        name: String,
        /// Take this file instead of fetching one
        #[arg(long, value_name = "FILE")]
        from: Option<PathBuf>,
    },
    /// Print where a model's file is
    Path {
        /// Its name
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
