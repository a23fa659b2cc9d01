//! The audit log: who approved, refused, started and stopped what.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::id::{ApprovalId, RunId, SessionId};
use crate::problem::Problem;
use crate::store::{Durability, LogName, OwnedLog, Store};

/// A line of the audit log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct AuditEntry {
    /// The time, in UTC.
    pub at: String,
    /// Who did it: the name that the face gives, such as `page` or `mcp:claude-code`.
    pub by: String,
    /// The deed.
    #[serde(flatten)]
    pub deed: Deed,
}

/// A deed of a person or of the server.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "deed", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Deed {
    /// A plan was accepted: the session goes on in its final world. Nothing may move for that.
    Accepted {
        /// The session.
        session: SessionId,
        /// The hash of the plan.
        plan: String,
    },
    /// A plan was approved for a robot.
    Approved {
        /// The approval.
        approval: ApprovalId,
        /// The session.
        session: SessionId,
        /// The hash of the plan, which was seen.
        plan: String,
        /// The robot.
        robot: String,
    },
    /// Something was not approved, or an approval did not hold.
    Refused {
        /// The session.
        session: SessionId,
        /// The hash that was named.
        plan: String,
        /// The reason.
        why: String,
    },
    /// A run was begun with an approval.
    Started {
        /// The run.
        run: RunId,
        /// The approval.
        approval: ApprovalId,
        /// The hash of the plan.
        plan: String,
        /// The robot.
        robot: String,
    },
    /// A change or a step of a run was decided.
    Decided {
        /// The run.
        run: RunId,
        /// The hash of what was proposed; none for a question about the world.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        proposal: Option<String>,
        /// True if it was approved, or answered with yes.
        yes: bool,
    },
    /// A run was paused.
    Paused {
        /// The run.
        run: RunId,
    },
    /// A paused run goes on.
    Continued {
        /// The run.
        run: RunId,
    },
    /// A run was asked to stop.
    Stopped {
        /// The run; none for all robots.
        run: Option<RunId>,
    },
    /// A run ended.
    Ended {
        /// The run.
        run: RunId,
        /// `done`, or the reason of the stop.
        end: String,
    },
}

/// The audit log of a server. Its lines are on the disk before what they say takes effect.
#[derive(Clone)]
pub struct Audit {
    store: Arc<dyn Store>,
    log: Arc<dyn OwnedLog>,
}

impl Audit {
    /// Opens the audit log of a store.
    ///
    /// # Errors
    ///
    /// Another server has it, and the store is not shared.
    pub fn open(store: Arc<dyn Store>) -> Result<Self, Problem> {
        let log = store.own(&LogName::Audit)?.into();
        Ok(Self { store, log })
    }

    /// Adds a line.
    ///
    /// # Errors
    ///
    /// When it cannot be kept; then the deed must not be done.
    pub fn add(&self, by: &str, deed: Deed) -> Result<(), Problem> {
        let entry = AuditEntry {
            at: jiff::Timestamp::now().to_string(),
            by: by.to_owned(),
            deed,
        };
        // Plain data with string keys is always written.
        let line = serde_json::to_string(&entry).unwrap_or_default() + "\n";
        Ok(self.log.append(&line, Durability::Now)?)
    }

    /// Adds the line that a plan was not accepted or not approved, or that an approval did not hold.
    ///
    /// # Errors
    ///
    /// When it cannot be kept.
    pub fn refused(&self, by: &str, session: &SessionId, plan: &str, why: &str) -> Result<(), Problem> {
        self.add(
            by,
            Deed::Refused {
                session: session.clone(),
                plan: plan.to_owned(),
                why: why.to_owned(),
            },
        )
    }

    /// Returns the last lines, the newest first: at most `limit`, and at most [`LONGEST_TAIL`](crate::LONGEST_TAIL). The
    /// rest of the log is not read. A line that a newer program wrote, and this one does not know, is left out.
    ///
    /// # Errors
    ///
    /// When the log cannot be read.
    pub fn last(&self, limit: usize) -> Result<Vec<AuditEntry>, Problem> {
        let lines = self.store.tail(&LogName::Audit, limit)?;
        let entries = lines.iter().rev().filter_map(|line| serde_json::from_str(line).ok());
        Ok(entries.collect())
    }
}
