//! The arguments for the way from an instruction to a plan.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use longstep::Effort;
use longstep::session::{RepairPolicy, Settings, Strategy};

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
        Settings::default()
            .with_strategy(match self.strategy {
                StrategyArgument::Goal => Strategy::Goal,
                StrategyArgument::Direct => Strategy::Direct,
            })
            .with_repair(match (self.no_repair, self.feedback_first) {
                (true, _) => RepairPolicy::Never,
                (false, true) => RepairPolicy::AfterFeedback,
                (false, false) => RepairPolicy::First,
            })
            .with_rounds(self.rounds)
            .with_effort(self.effort)
            .with_partial(self.accept_partial)
    }
}
