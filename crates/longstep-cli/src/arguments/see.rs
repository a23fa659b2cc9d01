//! The arguments of `longstep see`.

use std::path::PathBuf;

use clap::Args;

use super::model::ModelArguments;

/// A source of an environment, and where the environment goes.
#[derive(Debug, Args)]
pub(crate) struct SeeArguments {
    /// A scene file with named boxes and poses (JSON), or pictures (PNG, JPEG, WebP)
    #[arg(value_name = "FILE", required_unless_present = "words")]
    pub(crate) files: Vec<PathBuf>,
    /// A description in words, or further words about the pictures
    #[arg(long, value_name = "TEXT")]
    pub(crate) words: Option<String>,
    /// Projector (mmproj, a .gguf file) of an embedded `--model`, with which it sees pictures; needs a build with the feature
    /// `vision`
    #[arg(long, value_name = "FILE")]
    pub(crate) vision: Option<PathBuf>,
    /// Domain (the robot's actions): the name of a shipped domain, or a folder [default: household, or the session's]
    #[arg(long, value_name = "DOMAIN", conflicts_with = "update")]
    pub(crate) domain: Option<String>,
    /// Write the environment to a file
    #[arg(long, short, value_name = "ENV.json", conflicts_with = "update")]
    pub(crate) output: Option<PathBuf>,
    /// Compare with the world of a session, and store what changed in it: its name or its folder
    #[arg(long, value_name = "SESSION")]
    pub(crate) update: Option<String>,
    /// Correct what a model wrote down, in words; can be given several times
    #[arg(long, value_name = "TEXT")]
    pub(crate) correct: Vec<String>,
    /// Save without confirmation; what contradicts the domain is never saved
    #[arg(long, short)]
    pub(crate) yes: bool,
    /// Print one JSON object, and ask nothing
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) model: ModelArguments,
}
