//! The requests `say` and `execute`, done on the hub.

use std::sync::Arc;
use std::time::Duration;

use serde_json::{Map, Value, json};

use super::publication::plan_of;
use super::request::{self, Execute, Role, Say, approval_id, session_id};
use super::topic::Asked;
use super::{RosOptions, Shared};
use crate::approval::{APPROVAL_LIFETIME, Approval};
use crate::audit::Deed;
use crate::hub::{Hub, NewSession};
use crate::id::{ApprovalId, SessionId};
use crate::problem::{Problem, ProblemKind};
use crate::talk::Waiting;
use crate::view::Snapshot;

/// The longest wait for a model.
const LONGEST_ANSWER: Duration = Duration::from_secs(600);

/// The time between two looks whether the server has ended.
const LOOK: Duration = Duration::from_millis(50);

/// The lines of the audit log in which the approval of a plan is looked for.
const AUDIT: usize = 10_000;

/// The fields of an answer.
type Fields = Map<String, Value>;

/// Does what a request asks for, and waits for the end.
pub(super) fn done(
    hub: &Arc<Hub>,
    options: &RosOptions,
    shared: &Shared,
    asked: Asked,
    text: &str,
) -> Result<Fields, Problem> {
    match asked {
        Asked::Say => say(hub, shared, request::read(text)?),
        Asked::Execute => execute(hub, options, &request::read(text)?),
    }
}

/// Says something to a session, and waits until it is the person's turn.
fn say(hub: &Arc<Hub>, shared: &Shared, say: Say) -> Result<Fields, Problem> {
    let id = match &say.session {
        Some(session) => session_id(session)?,
        None => hub.create(&place(hub, say.scene.as_deref())?)?.view.id.clone(),
    };
    let role = match say.role {
        Some(role) => role,
        None => Role::of_state(hub.session(&id)?.view.state),
    };
    let waiting = hub.say(&id, &role.said(say.text))?;
    let snapshot = turn(shared, waiting)?;
    Ok(plan_of(&snapshot))
}

/// Returns where a session begins that no request names.
fn place(hub: &Hub, scene: Option<&str>) -> Result<NewSession, Problem> {
    let name = match scene {
        Some(name) => name,
        None => hub
            .domains()
            .scenes()
            .first()
            .map(|scene| scene.name.as_str())
            .ok_or_else(|| {
                Problem::conflict("this server has no scene").hint("start it with `longstep serve --env ENV.json`")
            })?,
    };
    Ok(NewSession::of_scene(name))
}

/// Waits for the person's turn. The work of the model is cancelled when the face ends, or after too long a time.
fn turn(shared: &Shared, waiting: Waiting) -> Result<Arc<Snapshot>, Problem> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build();
    let runtime = runtime.map_err(|error| Problem::new(ProblemKind::Internal, error.to_string()))?;
    runtime.block_on(async {
        tokio::select! {
            snapshot = waiting.turn() => Ok(snapshot),
            problem = given_up(shared) => Err(problem),
        }
    })
}

async fn given_up(shared: &Shared) -> Problem {
    let deadline = tokio::time::Instant::now() + LONGEST_ANSWER;
    loop {
        tokio::time::sleep(LOOK).await;
        if shared.is_ended() {
            return Problem::conflict("the server has ended");
        }
        if tokio::time::Instant::now() >= deadline {
            let message = format!("the model gave no answer in {} s", LONGEST_ANSWER.as_secs());
            return Problem::new(ProblemKind::Failed, message);
        }
    }
}

/// Begins a run of the plan with a hash.
fn execute(hub: &Arc<Hub>, options: &RosOptions, execute: &Execute) -> Result<Fields, Problem> {
    let plan = execute.hash()?;
    let session = execute.session.as_deref().map(session_id).transpose()?;
    let by = execute.by();
    let approval = match &execute.approval {
        Some(named) => named_approval(hub, &approval_id(named)?, plan, session.as_ref(), &by)?,
        None if options.serving.approve => approved_by_caller(hub, options, execute, session.as_ref())?,
        None => last_approval(hub, plan, session.as_ref(), &by)?,
    };
    let run = hub.start(&approval, false, &by)?;
    let mut fields = Fields::new();
    fields.insert("run".to_owned(), json!(run.record.id));
    fields.insert("session".to_owned(), json!(run.record.session));
    fields.insert("plan".to_owned(), json!(run.record.plan));
    fields.insert("robot".to_owned(), json!(run.record.robot));
    fields.insert("state".to_owned(), json!(run.state));
    Ok(fields)
}

/// Returns an approval that the caller names, if it is one of this plan.
fn named_approval(
    hub: &Hub,
    id: &ApprovalId,
    plan: &str,
    session: Option<&SessionId>,
    by: &str,
) -> Result<ApprovalId, Problem> {
    let approval: Approval = hub.approvals.find(id)?;
    if approval.plan != plan || session.is_some_and(|session| *session != approval.session) {
        let why = "the approval is for another plan";
        hub.audit().refused(by, &approval.session, plan, why)?;
        return Err(Problem::conflict(why).hint("name the hash of the plan that was approved"));
    }
    Ok(approval.id)
}

/// Returns the last approval of a plan that was not used, or else the last one, which will be refused with its reason.
fn last_approval(hub: &Hub, plan: &str, session: Option<&SessionId>, by: &str) -> Result<ApprovalId, Problem> {
    let mut used = Vec::new();
    let mut last = None;
    for entry in hub.audit().last(AUDIT)? {
        match entry.deed {
            Deed::Started { approval, .. } => used.push(approval),
            Deed::Approved {
                approval,
                session: own,
                plan: approved,
                ..
            } if approved == plan && session.is_none_or(|session| *session == own) => {
                if !used.contains(&approval) {
                    return Ok(approval);
                }
                last = last.or(Some(approval));
            }
            _ => {}
        }
    }
    last.ok_or_else(|| {
        let problem = Problem::conflict("nobody has approved this plan")
            .hint("a person approves it on the page of the server, or over HTTP; then ask again");
        match session.map(|session| hub.audit().refused(by, session, plan, &problem.message)) {
            Some(Err(failed)) => failed,
            _ => problem,
        }
    })
}

/// Accepts and approves a plan in the name of the caller.
fn approved_by_caller(
    hub: &Arc<Hub>,
    options: &RosOptions,
    execute: &Execute,
    session: Option<&SessionId>,
) -> Result<ApprovalId, Problem> {
    if execute.name().is_none() {
        return Err(Problem::unreadable("an approval needs the name of who approves").hint("name it with `caller`"));
    }
    let session = session.ok_or_else(|| {
        Problem::unreadable("an approval needs the session of the plan").hint("name it with `session`")
    })?;
    let (plan, by) = (execute.hash()?, execute.by());
    let robot = robot_of(hub, options, execute)?;
    let snapshot = hub.session(session)?;
    if snapshot
        .view
        .proposal
        .as_ref()
        .is_some_and(|proposal| proposal.plan == plan)
    {
        hub.accept(session, plan, &by)?;
    }
    Ok(hub.approve(session, plan, &robot, &by, APPROVAL_LIFETIME)?.id)
}

fn robot_of(hub: &Hub, options: &RosOptions, execute: &Execute) -> Result<String, Problem> {
    match (execute.robot.as_ref().or(options.robot.as_ref()), hub.robots()) {
        (Some(name), _) => Ok(hub.robot(name)?.name.clone()),
        (None, [only]) => Ok(only.name.clone()),
        (None, robots) => {
            let names: Vec<&str> = robots.iter().map(|robot| robot.name.as_str()).collect();
            Err(Problem::conflict("the robot is not named").hint(format!("pass `robot`: {}", names.join(", "))))
        }
    }
}
