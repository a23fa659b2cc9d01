//! Approvals: one plan, from one world, on one robot, once, until a time.

use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use longstep_core::environment::World;
use serde::{Deserialize, Serialize};

use crate::audit::{Audit, Deed};
use crate::id::{ApprovalId, RunId, SessionId, hash};
use crate::problem::{Problem, ProblemKind};
use crate::store::{RecordKey, Store};

/// The time in which an approval is to be used, unless the person says another.
pub const APPROVAL_LIFETIME: Duration = Duration::from_secs(10 * 60);

/// The longest time in which an approval may be used.
const LONGEST: Duration = Duration::from_secs(24 * 60 * 60);

/// A person's consent to one plan, from one world, on one robot, once, until a time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Approval {
    /// Its id.
    pub id: ApprovalId,
    /// The session of the plan.
    pub session: SessionId,
    /// The hash of the plan and of the world before it, as the person saw it.
    pub plan: String,
    /// The hash of the world of the robot, with the rules in force.
    pub world: String,
    /// The robot, by its name on this server.
    pub robot: String,
    /// Who approved.
    pub by: String,
    /// The time of the approval.
    pub at: Timestamp,
    /// The time after which it no longer holds.
    pub expires: Timestamp,
}

/// Returns the hash of a world as an approval keeps it: of its environment, and of the rules in force.
pub fn world_hash(world: &World) -> String {
    let rules: Vec<&str> = world.prohibitions().iter().map(|rule| rule.written.as_str()).collect();
    hash(&serde_json::json!([world.environment(), rules]))
}

/// The approvals of a server.
#[derive(Clone)]
pub struct Approvals {
    store: Arc<dyn Store>,
    audit: Audit,
}

/// The subject of an approval: a plan, in the world of a robot.
#[derive(Debug, Clone, Copy)]
pub struct Approved<'a> {
    /// The session of the plan.
    pub session: &'a SessionId,
    /// The hash of the plan.
    pub plan: &'a str,
    /// The world of the robot.
    pub world: &'a World,
    /// The robot.
    pub robot: &'a str,
}

impl Approvals {
    /// Opens the approvals of a store.
    pub fn new(store: Arc<dyn Store>, audit: Audit) -> Self {
        Self { store, audit }
    }

    /// Keeps an approval. The caller has compared the hash that the person named with the plan's.
    ///
    /// # Errors
    ///
    /// A lifetime that is too long; an approval that cannot be kept.
    pub fn approve(&self, subject: &Approved<'_>, by: &str, lifetime: Duration) -> Result<Approval, Problem> {
        if lifetime > LONGEST || lifetime.is_zero() {
            return Err(Problem::unreadable("an approval holds for one second to one day"));
        }
        let at = Timestamp::now();
        let approval = Approval {
            id: ApprovalId::random()?,
            session: subject.session.clone(),
            plan: subject.plan.to_owned(),
            world: world_hash(subject.world),
            robot: subject.robot.to_owned(),
            by: by.to_owned(),
            at,
            expires: at.checked_add(lifetime).unwrap_or(at),
        };
        self.audit.add(
            by,
            Deed::Approved {
                approval: approval.id.clone(),
                session: approval.session.clone(),
                plan: approval.plan.clone(),
                robot: approval.robot.clone(),
            },
        )?;
        let record = serde_json::to_string(&approval).unwrap_or_default();
        self.store.insert(&RecordKey::Approval(approval.id.clone()), &record)?;
        Ok(approval)
    }

    /// Returns an approval.
    ///
    /// # Errors
    ///
    /// There is none with this id.
    pub fn find(&self, id: &ApprovalId) -> Result<Approval, Problem> {
        let record = self.store.record(&RecordKey::Approval(id.clone()))?;
        let approval = record.and_then(|record| serde_json::from_str(&record).ok());
        approval.ok_or_else(|| Problem::missing("approval", id))
    }

    /// Uses an approval for a run: once, for this plan, world and robot, before it expires. The use is on the disk when
    /// this returns.
    ///
    /// # Errors
    ///
    /// The reason why it does not hold, which is in the audit log too.
    pub fn consume(&self, approval: &Approval, subject: &Approved<'_>, run: &RunId, by: &str) -> Result<(), Problem> {
        let reason = self.reason_against(approval, subject);
        let reason = match reason {
            Some(reason) => Some(reason),
            None if self.store.insert(&RecordKey::Use(approval.id.clone()), run.as_str())? => None,
            None => Some("the approval was used before"),
        };
        let Some(why) = reason else {
            return self.audit.add(
                by,
                Deed::Started {
                    run: run.clone(),
                    approval: approval.id.clone(),
                    plan: approval.plan.clone(),
                    robot: approval.robot.clone(),
                },
            );
        };
        self.audit.refused(by, &approval.session, &approval.plan, why)?;
        Err(Problem::new(ProblemKind::Conflict, why).hint("look at the plan again, and approve it again"))
    }

    fn reason_against(&self, approval: &Approval, subject: &Approved<'_>) -> Option<&'static str> {
        if approval.session != *subject.session {
            Some("the approval is for another session")
        } else if approval.plan != subject.plan {
            Some("the approval is for another plan")
        } else if approval.robot != subject.robot {
            Some("the approval is for another robot")
        } else if approval.world != world_hash(subject.world) {
            Some("the world has changed since the approval")
        } else if Timestamp::now() >= approval.expires {
            Some("the approval has expired")
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::{FileStore, LogName};
    use longstep::Planner;

    fn world(place: &str) -> World {
        let environment = format!(
            r#"{{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"], "object_states": {{"<pen>": "on_something({place})"}}}}"#
        );
        Planner::shipped("household").unwrap().world(&environment).unwrap()
    }

    #[test]
    fn approval_holds_once_for_one_plan_world_and_robot() {
        let folder = tempfile::tempdir().unwrap();
        let store: Arc<dyn Store> = Arc::new(FileStore::open(&folder.path().join("sessions")).unwrap());
        let audit = Audit::open(Arc::clone(&store)).unwrap();
        let approvals = Approvals::new(Arc::clone(&store), audit.clone());
        let (session, other) = (SessionId::parse("s").unwrap(), SessionId::parse("t").unwrap());
        let (here, elsewhere) = (world("<desk>"), world("<shelf>"));
        let subject = Approved {
            session: &session,
            plan: "p",
            world: &here,
            robot: "sim",
        };
        let run = RunId::parse("r").unwrap();
        let approval = approvals.approve(&subject, "ada", APPROVAL_LIFETIME).unwrap();
        assert_eq!(approvals.find(&approval.id).unwrap(), approval);
        for (wrong, why) in [
            (
                Approved {
                    session: &other,
                    ..subject
                },
                "another session",
            ),
            (Approved { plan: "q", ..subject }, "another plan"),
            (
                Approved {
                    robot: "arm",
                    ..subject
                },
                "another robot",
            ),
            (
                Approved {
                    world: &elsewhere,
                    ..subject
                },
                "the world has changed",
            ),
        ] {
            let refused = approvals.consume(&approval, &wrong, &run, "ada").unwrap_err();
            assert!(refused.message.contains(why), "{refused}");
        }
        approvals.consume(&approval, &subject, &run, "ada").unwrap();
        let again = approvals.consume(&approval, &subject, &run, "ada").unwrap_err();
        assert!(again.message.contains("used before"));
        let short = approvals.approve(&subject, "ada", Duration::from_nanos(1)).unwrap();
        assert!(
            approvals
                .consume(&short, &subject, &run, "ada")
                .unwrap_err()
                .message
                .contains("expired")
        );
        assert!(approvals.approve(&subject, "ada", LONGEST * 2).is_err());
        // One line for each approval, refusal and start, and none is lost.
        let lines = store.read(&LogName::Audit).unwrap().unwrap();
        assert_eq!(lines.iter().filter(|byte| **byte == b'\n').count(), 2 + 6 + 1);
        assert_eq!(audit.last(3).unwrap().len(), 3);
    }
}
