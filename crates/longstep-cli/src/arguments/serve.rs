//! The arguments of `longstep serve` and `longstep mcp`.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;

use super::model::ModelArguments;
use super::run::ExecutionArguments;
use super::strategy::StrategyArguments;

/// A server behind HTTP.
#[derive(Debug, Args)]
pub(crate) struct ServeArguments {
    /// Address to listen at; one that other machines reach needs TLS in front, see docs/guide/server.md
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8765")]
    pub(crate) listen: SocketAddr,
    /// Robot file with the bridge to ROS 2 on which plans and progress are shown and requests taken (repeatable)
    #[arg(long, value_name = "ROBOT.toml")]
    pub(crate) ros2: Vec<PathBuf>,
    /// Database that several servers share, in place of files: postgres://user@host/database; the password may be in
    /// `PGPASSWORD` or ~/.pgpass
    #[arg(long, value_name = "ADDRESS", env = "LONGSTEP_STORE", hide_env_values = true)]
    pub(crate) store: Option<String>,
    #[command(flatten)]
    pub(crate) access: AccessArguments,
    #[command(flatten)]
    pub(crate) hub: HubArguments,
}

/// A server for one agent, on standard input and output.
#[derive(Debug, Args)]
pub(crate) struct McpArguments {
    /// Address of a page on which a person can approve, for agents that cannot show a form; without it there is no page
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub(crate) listen: Option<SocketAddr>,
    #[command(flatten)]
    pub(crate) access: AccessArguments,
    #[command(flatten)]
    pub(crate) hub: HubArguments,
}

/// Who may talk to a server.
#[derive(Debug, Args)]
pub(crate) struct AccessArguments {
    /// Name by which browsers reach the server besides its address, with the port (repeatable): robot.lab:443
    #[arg(long, value_name = "HOST:PORT")]
    pub(crate) name: Vec<String>,
    /// File with the token; it is made if it does not exist [default: a file beside the sessions]
    #[arg(long, value_name = "FILE")]
    pub(crate) token_file: Option<PathBuf>,
}

/// The worlds, robots and model of a server.
#[derive(Debug, Args)]
pub(crate) struct HubArguments {
    /// Environment file that sessions can begin in, by its name without `.json` (repeatable); demo scenes are shipped
    #[arg(long, value_name = "ENV.json")]
    pub(crate) env: Vec<PathBuf>,
    /// Domain of these environments: the name of a shipped domain, or a folder [default: household]
    #[arg(long, value_name = "DOMAIN")]
    pub(crate) domain: Option<String>,
    /// Robot, `NAME=ROBOT` or `ROBOT` (repeatable) [default: sim]
    #[arg(long, value_name = "[NAME=]ROBOT")]
    pub(crate) robot: Vec<String>,
    #[command(flatten)]
    pub(crate) execution: ExecutionArguments,
    #[command(flatten)]
    pub(crate) model: ModelArguments,
    /// Serve without a model: plans are verified, repaired and found, and no instruction is understood
    #[arg(long, conflicts_with = "model")]
    pub(crate) no_model: bool,
    /// Models that are opened at a time; one for an embedded model, more for a model on a server
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=64))]
    pub(crate) models: u16,
    /// Requests that may wait for the model
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    pub(crate) queue: u16,
    #[command(flatten)]
    pub(crate) strategy: StrategyArguments,
}
