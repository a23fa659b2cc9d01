//! Longstep behind a network: sessions, approvals that are bound to one plan, and runs, for the page, for HTTP and for
//! agents.
//!
//! Nothing moves a robot before a person has approved exactly that plan. Every face is thin over the [`Hub`]:
//!
//! - [`Hub::say`], [`Hub::accept`]: a session, as the library has it. A plan is named by its hash.
//! - [`Hub::approve`] and [`Hub::start`]: an [`Approval`] counts for one plan, from one world, on one robot, once, until a
//!   time. [`Audit`] has who did what.
//! - [`Hub::pause`], [`Hub::go_on`], [`Hub::stop`], [`Hub::decide`]: a run under way.
//! - [`Feed`]: the live stream. [`Hub::recording`]: a run as an MCAP file.
//!
//! [`Store`] is what outlives a server: files for one, a database for several. [`Models`] is the model that all sessions share.

// What unit tests share with the others names the crate as they do.
#[cfg(test)]
extern crate self as longstep_server;

#[cfg(test)]
#[path = "../tests/support/mod.rs"]
mod support;

mod approval;
mod audit;
mod desk;
mod domains;
mod feed;
mod history;
mod hosted;
pub mod http;
mod hub;
mod id;
mod lend;
#[cfg(feature = "mcp")]
pub mod mcp;
mod models;
mod operate;
mod page;
mod problem;
mod recording;
pub mod ros;
mod run;
mod session_locks;
mod shared;
mod store;
mod talk;
mod view;

pub use approval::{APPROVAL_LIFETIME, Approval, Approvals, Approved, world_hash};
pub use audit::{Audit, AuditEntry, Deed};
pub use desk::Planning;
pub use domains::{Domains, Scene};
pub use feed::{Feed, FeedEvent, Happening, Page};
pub use hub::{Configuration, Hub, NewSession};
pub use id::{ApprovalId, CampaignId, RunId, SessionId};
pub use models::{Models, OpenModel};
pub use problem::{Problem, ProblemKind};
pub use run::{Body, EndView, OpenRobot, QuestionView, RobotEntry, RunRecord, RunState, RunView};
pub use store::{
    Durability, FileStore, LONGEST_TAIL, LogName, LogState, OwnedLog, RecordKey, Store, StoreError, StoredRun, UnitKey,
};
#[cfg(feature = "postgres")]
pub use store::{PostgresOptions, PostgresStore};
pub use talk::{Said, Waiting};
pub use view::{AcceptedView, EndingView, FailureView, ProposalView, SessionView, Snapshot};
