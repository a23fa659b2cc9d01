//! The arguments of `longstep domain`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::model::ModelArguments;

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
    /// Print a robot with a function for each leaf of a behavior tree, to be filled in
    Nodes {
        /// Name of a shipped domain, or a folder
        domain: String,
        /// Programming language
        #[arg(long, value_enum)]
        language: NodesLanguage,
    },
    /// Create the folder of a new domain: from answers to a few questions, from a PDDL file, or a commented example
    New(NewDomainArguments),
    /// Make five instructions from a domain's own sentences, and show what a model understands
    Try(TryArguments),
}

/// A programming language with nodes for behavior trees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum NodesLanguage {
    /// A header in C++17 for BehaviorTree.CPP 4
    Cpp,
    /// A module for behaviortreepy
    Python,
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
