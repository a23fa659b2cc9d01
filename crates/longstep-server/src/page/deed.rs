//! What the forms of the page do.

use std::sync::Arc;

use super::form::Fields;
use crate::approval::APPROVAL_LIFETIME;
use crate::hub::{Hub, NewSession};
use crate::id::{ApprovalId, RunId, SessionId};
use crate::problem::Problem;
use crate::talk::Said;
use crate::view::Snapshot;

/// Where the browser goes after a form.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Next {
    /// To a session.
    Session(SessionId),
    /// To a session that began in a scene.
    Begun(SessionId, String),
    /// To a session with an approval, which waits for its start.
    Approved(SessionId, ApprovalId),
    /// To a run.
    Run(RunId),
}

impl Next {
    /// Returns the path.
    pub(crate) fn path(&self) -> String {
        match self {
            Self::Session(id) => format!("/sessions/{id}"),
            Self::Begun(id, scene) => {
                let mut query = form_urlencoded::Serializer::new(String::new());
                format!("/sessions/{id}?{}", query.append_pair("scene", scene).finish())
            }
            Self::Approved(id, approval) => format!("/sessions/{id}?approval={approval}"),
            Self::Run(id) => format!("/runs/{id}"),
        }
    }
}

macro_rules! deeds {
    ($(#[$doc:meta])* $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(crate) enum $name { $($(#[$variant_doc])* $variant,)* }

        impl $name {
            /// Returns the deed with this name, which is the end of its path.
            pub(crate) fn named(name: &str) -> Option<Self> {
                match name {
                    $($text => Some(Self::$variant),)*
                    _ => None,
                }
            }

            /// Returns the name, which its form has too.
            pub(crate) fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)*
                }
            }
        }
    };
}

deeds!(
    /// What a form does with a session.
    SessionDeed {
        /// Gives an instruction.
        Instruct = "instruct",
        /// Answers the question.
        Answer = "answer",
        /// Says what is to be different.
        Feedback = "feedback",
        /// Cancels.
        Cancel = "cancel",
        /// Accepts the plan.
        Accept = "accept",
        /// Approves the plan for a robot, and accepts it first if it was not.
        Approve = "approve",
        /// Begins a run with an approval.
        Start = "start",
        /// Reverts the last accepted plan.
        Undo = "undo",
        /// Says how the last plan ended.
        Ended = "ended",
    }
);

deeds!(
    /// What a form does with a run, besides the stop.
    RunDeed {
        /// Answers its question.
        Decide = "decide",
        /// Pauses it.
        Pause = "pause",
        /// Lets it go on.
        Continue = "continue",
        /// Takes it up again.
        Resume = "resume",
    }
);

/// Begins a session in a scene.
///
/// # Errors
///
/// As for [`Hub::create`].
pub(crate) fn begin_session(hub: &Hub, fields: &Fields) -> Result<Next, Problem> {
    let scene = fields.require("scene")?;
    let created = hub.create(&NewSession::of_scene(scene))?;
    Ok(Next::Begun(created.view.id.clone(), scene.to_owned()))
}

/// Does with a session what a form says.
///
/// # Errors
///
/// Those of the hub; a field is missing.
pub(crate) fn act_on_session(
    hub: &Arc<Hub>,
    id: &SessionId,
    deed: SessionDeed,
    fields: &Fields,
    by: &str,
) -> Result<Next, Problem> {
    let text = || fields.get("text").unwrap_or_default().to_owned();
    match deed {
        SessionDeed::Instruct => say(hub, id, &Said::Instruction(text()))?,
        SessionDeed::Answer => say(hub, id, &Said::Answer(text()))?,
        SessionDeed::Feedback => say(hub, id, &Said::Feedback(text()))?,
        SessionDeed::Cancel => drop(hub.cancel(id)?),
        SessionDeed::Accept => drop(hub.accept(id, fields.require("plan")?, by)?),
        SessionDeed::Undo => drop(hub.undo(id)?),
        SessionDeed::Ended => {
            let ending = fields.require("ending")?.parse();
            let ending = ending.map_err(|_| Problem::unreadable("the ending is no number"))?;
            drop(hub.ended(id, ending)?);
        }
        SessionDeed::Approve => return approve(hub, id, fields, by),
        SessionDeed::Start => {
            let approval = fields.require("approval")?;
            let approval = ApprovalId::parse(approval).ok_or_else(|| Problem::missing("approval", approval))?;
            let run = hub.start(&approval, false, by)?;
            return Ok(Next::Run(run.record.id.clone()));
        }
    }
    Ok(Next::Session(id.clone()))
}

/// Leaves the model at work: the page follows it.
fn say(hub: &Arc<Hub>, id: &SessionId, said: &Said) -> Result<(), Problem> {
    hub.say(id, said).map(|waiting| drop(waiting.leave()))
}

/// Approves the plan that the form names, for the robot that it names. A plan that waits for its decision is accepted
/// first, if no earlier plan waits for a robot.
fn approve(hub: &Arc<Hub>, id: &SessionId, fields: &Fields, by: &str) -> Result<Next, Problem> {
    let (plan, robot) = (fields.require("plan")?, fields.require("robot")?);
    hub.robot(robot)?;
    if is_proposed(&*hub.session(id)?, plan) {
        hub.accept(id, plan, by)?;
    }
    let approval = hub.approve(id, plan, robot, by, APPROVAL_LIFETIME)?;
    Ok(Next::Approved(id.clone(), approval.id))
}

fn is_proposed(snapshot: &Snapshot, plan: &str) -> bool {
    let proposed = snapshot.view.proposal.as_ref().is_some_and(|own| own.plan == plan);
    proposed && snapshot.next.is_none()
}

/// Does with a run what a form says.
///
/// # Errors
///
/// Those of the hub; a field is missing.
pub(crate) fn act_on_run(hub: &Hub, id: &RunId, deed: RunDeed, fields: &Fields, by: &str) -> Result<Next, Problem> {
    let run = match deed {
        RunDeed::Decide => {
            let yes = match fields.require("answer")? {
                "yes" => true,
                "no" => false,
                _ => return Err(Problem::unreadable("the answer is neither yes nor no")),
            };
            hub.decide(id, fields.require("question")?, yes, by)?
        }
        RunDeed::Pause => hub.pause(id, by)?,
        RunDeed::Continue => hub.go_on(id, by)?,
        RunDeed::Resume => hub.resume(id, by)?,
    };
    Ok(Next::Run(run.record.id.clone()))
}
