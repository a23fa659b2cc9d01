//! The tools that make a plan: `describe_world`, `plan`, `answer`, `revise` and `discard`.

use std::sync::Arc;
use std::time::Duration;

use longstep::dialogue;
use longstep_core::environment::{Environment, World};
use serde::Serialize;

use super::call::{InSession, Words};
use super::caller::Caller;
use super::face::{Face, Shared};
use super::offer::Offer;
use super::reply::{Reply, section};
use super::text;
use crate::approval::world_hash;
use crate::feed::{Happening, Page};
use crate::hub::Hub;
use crate::id::SessionId;
use crate::problem::{Problem, ProblemKind};
use crate::talk::{Said, Waiting};
use crate::view::{SessionView, Snapshot};

/// The longest time between two reports of progress: many clients give up after a minute without one.
const PULSE: Duration = Duration::from_secs(10);

/// A session, with the id under which its plan can be carried out.
#[derive(Debug, Serialize)]
struct Shown<'s> {
    /// What `execute_plan` names; none without a plan.
    plan_id: Option<String>,
    /// The hash of the plan that it names.
    hash: Option<String>,
    #[serde(flatten)]
    view: &'s SessionView,
}

/// The world in which an instruction begins.
#[derive(Debug, Serialize)]
struct Described {
    /// The session; none if it has not begun.
    session: Option<SessionId>,
    domain: String,
    environment: Environment,
    /// The rules in force, in the goal language.
    rules: Vec<String>,
    /// The actions of the robot, as a plan calls them.
    actions: Vec<ActionView>,
    /// The robots that `execute_plan` takes.
    robots: Vec<String>,
}

#[derive(Debug, Serialize)]
struct ActionView {
    call: String,
    means: String,
}

impl Described {
    fn of(hub: &Hub, session: Option<SessionId>, world: &World) -> Self {
        let domain = world.domain();
        let actions = domain.actions.iter().map(|action| {
            let parameters = action
                .explicit
                .iter()
                .map(|index| action.parameters[*index].name.as_str());
            ActionView {
                call: format!("{}({})", action.call, parameters.collect::<Vec<_>>().join(", ")),
                means: action.means.clone(),
            }
        });
        Self {
            session,
            domain: domain.name.clone(),
            environment: world.environment().clone(),
            rules: world.prohibitions().iter().map(|rule| rule.written.clone()).collect(),
            actions: actions.collect(),
            robots: hub.robots().iter().map(|robot| robot.name.clone()).collect(),
        }
    }
}

/// Returns the progress of a model's work for a session.
fn progress(happening: &Happening, id: &SessionId) -> Option<String> {
    match happening {
        Happening::Progress { session, text } if session == id => Some(text.clone()),
        _ => None,
    }
}

impl Shared {
    /// Returns the plan of a session that can be carried out next: the one that waits for a decision, or else the next that
    /// waits for a robot.
    pub(super) fn offer(&self, snapshot: &Snapshot) -> Result<Option<(String, Offer)>, Problem> {
        let view = &snapshot.view;
        let plan = match &view.proposal {
            Some(proposal) => Some(proposal.plan.clone()),
            None => view.accepted.iter().find(|own| own.pending).map(|own| own.plan.clone()),
        };
        let Some(plan) = plan else { return Ok(None) };
        let offer = Offer {
            session: view.id.clone(),
            plan,
            world: world_hash(&snapshot.robot_world),
        };
        Ok(Some((self.offers.add(offer.clone())?, offer)))
    }

    /// Returns a session as the result of a tool.
    pub(super) fn show(&self, snapshot: &Snapshot) -> Result<Reply, Problem> {
        let (plan_id, hash) = self.offer(snapshot)?.map(|(id, offer)| (id, offer.plan)).unzip();
        let text = text::session(&snapshot.view, plan_id.as_deref());
        Reply::new(
            text,
            &Shown {
                plan_id,
                hash,
                view: &snapshot.view,
            },
        )
    }

    /// Says something to a session. A new instruction takes the place of one without a decision.
    fn say(&self, id: &SessionId, said: &Said) -> Result<Waiting, Problem> {
        let hinted = |problem: Problem| self.hinted(id, problem);
        if matches!(said, Said::Instruction(_)) {
            self.drop_undecided(id)?;
        }
        self.hub.say(id, said).map_err(hinted)
    }

    /// Cancels the question or the plan that waits for a decision. A plan that was revised is there again after the first
    /// time.
    fn drop_undecided(&self, id: &SessionId) -> Result<bool, Problem> {
        let mut is_dropped = false;
        for _ in 0..2 {
            let snapshot = self.hub.session(id)?;
            if !matches!(snapshot.view.state, "plan" | "consent" | "question") {
                break;
            }
            self.hub.cancel(id)?;
            is_dropped = true;
        }
        Ok(is_dropped)
    }

    /// Adds the next step to a problem without one.
    fn hinted(&self, id: &SessionId, problem: Problem) -> Problem {
        if problem.hint.is_some() || problem.kind != ProblemKind::Conflict {
            return problem;
        }
        let snapshot = self.hub.session(id).ok();
        let next = snapshot.and_then(|snapshot| text::next_step(snapshot.view.state));
        problem.hint(next.unwrap_or("call `plan` with an instruction"))
    }
}

impl Face {
    /// Shows the world of a session, or the one in which a session begins.
    pub(super) async fn describe_world(&self, asked: InSession) -> Result<Reply, Problem> {
        let session = self.session(asked.session.as_deref())?;
        self.work(move |shared| {
            let hub = &shared.hub;
            let world = match &session {
                Some(id) => hub.session(id)?.world.clone(),
                None => hub.place(&shared.options.start)?.1,
            };
            let described = Described::of(hub, session, &world);
            let actions = described
                .actions
                .iter()
                .map(|action| format!("{}: {}", action.call, action.means));
            let text = format!(
                "{}{}{}{}",
                dialogue::scene(&world),
                section("Actions of the robot", actions),
                section("Rules in force", &described.rules),
                section("Robots", &described.robots),
            );
            Reply::new(text, &described)
        })
        .await
    }

    /// Makes a plan for an instruction, in the named session, in that of the connection, or in a new one.
    pub(super) async fn plan(&self, caller: &Caller, asked: Words) -> Result<Reply, Problem> {
        let session = self.session(asked.session.as_deref())?;
        let begin = |shared: &Shared| Ok(shared.hub.create(&shared.options.start)?.view.id.clone());
        let id = match session {
            Some(id) => id,
            None => self.work(begin).await?,
        };
        self.keep_session(id.clone());
        self.say(caller, id, Said::Instruction(asked.text)).await
    }

    /// Answers the question of a session.
    pub(super) async fn answer(&self, caller: &Caller, asked: Words) -> Result<Reply, Problem> {
        let id = self.known_session(asked.session.as_deref())?;
        self.say(caller, id, Said::Answer(asked.text)).await
    }

    /// Changes the plan of a session.
    pub(super) async fn revise(&self, caller: &Caller, asked: Words) -> Result<Reply, Problem> {
        let id = self.known_session(asked.session.as_deref())?;
        self.say(caller, id, Said::Feedback(asked.text)).await
    }

    /// Says something and waits for the turn of the person. A call that is taken back cancels the work.
    async fn say(&self, caller: &Caller, id: SessionId, said: Said) -> Result<Reply, Problem> {
        let own = id.clone();
        let waiting = self.work(move |shared| shared.say(&own, &said)).await?;
        let snapshot = tokio::select! {
            snapshot = waiting.turn() => snapshot,
            () = self.report_progress(caller, &id) => {
                return Err(Problem::conflict("the call was cancelled").hint("call `plan` again"));
            }
        };
        self.shared.show(&snapshot)
    }

    /// Reports the work for a session until the call is taken back.
    async fn report_progress(&self, caller: &Caller, id: &SessionId) {
        let feed = self.shared.hub.feed();
        let mut news = feed.newest();
        let mut last = *news.borrow_and_update();
        let mut pulse = tokio::time::interval(PULSE);
        let (mut number, mut text) = (0, "thinking".to_owned());
        loop {
            let is_due = tokio::select! {
                () = caller.cancelled.cancelled() => return,
                _ = pulse.tick() => true,
                Ok(()) = news.changed() => false,
            };
            let newest = *news.borrow_and_update();
            let said = match feed.after(last, usize::MAX) {
                Page::Events(events) => events.iter().rev().find_map(|event| progress(&event.happening, id)),
                Page::Gone(_) => None,
            };
            last = newest;
            if said.is_some() || is_due {
                text = said.unwrap_or(text);
                number += 1;
                caller.report(number, &text).await;
            }
        }
    }

    /// Drops the plan that waits: for a decision, or for a robot.
    pub(super) async fn discard(&self, asked: InSession) -> Result<Reply, Problem> {
        let id = self.known_session(asked.session.as_deref())?;
        let snapshot = self
            .work(move |shared| {
                let hub = &shared.hub;
                let view = hub.session(&id)?;
                if view.view.state == "thinking" {
                    return hub.cancel(&id);
                }
                if shared.drop_undecided(&id)? {
                    return hub.session(&id);
                }
                match view.view.accepted.last() {
                    Some(last) if last.pending => hub.undo(&id),
                    _ => Err(Problem::conflict("no plan waits").hint("call `plan` with an instruction")),
                }
            })
            .await?;
        let snapshot: Arc<Snapshot> = snapshot;
        self.shared.show(&snapshot)
    }
}
