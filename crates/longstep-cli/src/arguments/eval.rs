//! The arguments of `longstep eval`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::model::ModelArguments;
use super::strategy::StrategyArguments;

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
    /// Share the run with other machines: run the same command on each with a database for the queue, as
    /// postgres://user@host/database; the password may be in `PGPASSWORD` or ~/.pgpass
    #[arg(long, value_name = "ADDRESS")]
    pub(crate) queue: Option<String>,
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
    #[arg(long, conflicts_with_all = ["replies", "recorded", "queue"])]
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
