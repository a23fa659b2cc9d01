//! The tools that a person decides on: `execute_plan` and `decide`.

use std::sync::Arc;

use longstep_core::plan::outline;
use longstep_core::verify::VerifiedPlan;

use super::call::{Decide, Execute};
use super::caller::Caller;
use super::consent::{Asked, Decision, Form, Input, changed};
use super::face::{Face, Shared};
use super::offer::Offer;
use super::reply::{Reply, section};
use super::text;
use crate::approval::world_hash;
use crate::id::{RunId, SessionId};
use crate::problem::{Problem, ProblemKind};
use crate::run::RunView;
use crate::view::{Snapshot, goal_of};

/// A plan that is ready to be carried out if a person approves.
struct Ready {
    offer: Offer,
    robot: String,
    /// True if accepting it puts a rule in force, and no robot moves.
    is_rule: bool,
    form: Form,
}

impl Shared {
    /// Checks a request, and makes the form for it.
    ///
    /// # Errors
    ///
    /// The plan id or the hash does not fit, the plan is not the next, its world has changed, or a robot is busy with the
    /// session.
    fn ready(&self, asked: &Execute, by: &str) -> Result<Ready, Problem> {
        let offer = self.offers.find(&asked.plan_id)?;
        let ready = self.checked(asked, offer.clone());
        ready.inspect_err(|problem| self.refused(by, &offer.session, &asked.hash, &problem.message))
    }

    fn checked(&self, asked: &Execute, offer: Offer) -> Result<Ready, Problem> {
        if offer.plan != asked.hash {
            return Err(Problem::conflict("the hash is not that of the plan").hint(
                "pass the hash that was returned with the plan_id; if the plan looks different, call `explain`",
            ));
        }
        let robot = self.robot_of(asked)?;
        self.hub.refuse_during_run(&offer.session)?;
        let snapshot = self.hub.session(&offer.session)?;
        let plan = self.plan_in(&snapshot, &offer)?;
        let world = world_hash(&snapshot.robot_world);
        if world != offer.world && world != world_hash(plan.world()) {
            return Err(Problem::conflict("the world has changed since the plan was shown").hint(
                "call `explain` to look at the plan again; if it still fits, use the new plan_id, or `discard` it and call `plan`",
            ));
        }
        let proposal = snapshot.view.proposal.as_ref().filter(|own| own.plan == offer.plan);
        let is_rule = proposal.is_some_and(|own| own.offers_rule);
        Ok(Ready {
            form: Form {
                message: message(&snapshot, plan, &offer.plan, &robot, is_rule),
                yes: "Approve",
                hash: offer.plan.clone(),
                binding: vec![asked.plan_id.clone(), offer.plan.clone(), robot.clone(), world],
            },
            offer,
            robot,
            is_rule,
        })
    }

    /// Returns the plan of an offer if it is the next of its session.
    fn plan_in<'s>(&self, snapshot: &'s Snapshot, offer: &Offer) -> Result<&'s VerifiedPlan, Problem> {
        let view = &snapshot.view;
        if let (Some(shown), Some(proposal)) = (&view.proposal, &snapshot.proposal)
            && shown.plan == offer.plan
        {
            return match view.accepted.iter().find(|own| own.pending) {
                Some(first) if !shown.offers_rule => Err(Problem::conflict(format!(
                    "the plan for `{}` waits for the robot before this one",
                    first.instruction
                ))
                .hint("a person approves that plan first; or `discard` this plan, then that one")),
                _ => Ok(&proposal.plan),
            };
        }
        let next = view.accepted.iter().find(|own| own.pending);
        match (&snapshot.next, next) {
            (Some(accepted), Some(next)) if next.plan == offer.plan => Ok(&accepted.plan),
            _ => Err(
                Problem::conflict("the plan is not the next one of its session any more")
                    .hint("call `explain` for the plan that is, or `plan` for a new one"),
            ),
        }
    }

    fn robot_of(&self, asked: &Execute) -> Result<String, Problem> {
        let robots = self.hub.robots();
        let named = asked.robot.as_deref().or(self.options.robot.as_deref());
        match (named, robots) {
            (Some(name), _) => Ok(self.hub.robot(name)?.name.clone()),
            (None, [only]) => Ok(only.name.clone()),
            (None, []) => Err(Problem::conflict("this server has no robot")
                .hint("a person starts the server with `--robot`; the plan can only be shown")),
            (None, robots) => {
                let names: Vec<&str> = robots.iter().map(|robot| robot.name.as_str()).collect();
                Err(Problem::conflict("there are several robots").hint(format!("pass `robot`: {}", names.join(", "))))
            }
        }
    }

    /// Notes in the audit log that something was not approved. The refusal counts even if it cannot be noted.
    pub(super) fn refused(&self, by: &str, session: &SessionId, plan: &str, why: &str) {
        let _ = self.hub.audit().refused(by, session, plan, why);
    }

    /// Accepts the plan of an offer, unless it was accepted before.
    fn accept(&self, offer: &Offer, by: &str) -> Result<Arc<Snapshot>, Problem> {
        let snapshot = self.hub.session(&offer.session)?;
        match &snapshot.view.proposal {
            Some(proposal) if proposal.plan == offer.plan => self.hub.accept(&offer.session, &offer.plan, by),
            _ => Ok(snapshot),
        }
    }

    /// Carries out a plan that a person approved. Everything is checked again: the person took some time.
    fn approved(&self, asked: &Execute, before: &Ready, by: &str) -> Result<Reply, Problem> {
        let now = self.ready(asked, by)?;
        if now.form.binding != before.form.binding {
            return Err(changed());
        }
        self.offers.take(&asked.plan_id)?;
        self.started(&now, by)
            .inspect_err(|_| self.offers.give_back(&asked.plan_id))
    }

    fn started(&self, ready: &Ready, by: &str) -> Result<Reply, Problem> {
        let offer = &ready.offer;
        let snapshot = self.accept(offer, by)?;
        if ready.is_rule {
            return self.show(&snapshot);
        }
        let lifetime = self.options.approval_lifetime;
        let approval = self
            .hub
            .approve(&offer.session, &offer.plan, &ready.robot, by, lifetime)?;
        let run = self.hub.start(&approval.id, false, by)?;
        self.add_begun(run.record.id.clone());
        self.show_run(&run)
    }

    /// Leaves a plan for the page, as no person was asked.
    fn left_for_page(&self, ready: &Ready, why: &str, by: &str) -> Result<Reply, Problem> {
        let offer = &ready.offer;
        self.refused(by, &offer.session, &offer.plan, &format!("nobody was asked: {why}"));
        if !ready.is_rule {
            self.accept(offer, by)?;
        }
        let how = match self.page(&offer.session) {
            Some(page) => format!(
                "ask the person to open {page}, to compare the plan with the hash {}, and to approve it there for the robot \
                 `{}` in session {}; then call `run_status` with this session",
                offer.plan, ready.robot, offer.session
            ),
            None => {
                "ask the person to use a client that shows forms (elicitation), or to start this server with a page \
                 (`longstep mcp --listen 127.0.0.1:8765`); the plan can be carried out from there"
                    .to_owned()
            }
        };
        let waits = if ready.is_rule {
            ""
        } else {
            " The plan is accepted and waits."
        };
        Err(Problem::new(
            ProblemKind::Forbidden,
            format!("Nobody was asked: {why}. Nothing has moved.{waits}"),
        )
        .hint(how))
    }

    /// Returns the address of the page for a session.
    pub(super) fn page(&self, session: &SessionId) -> Option<String> {
        let page = self.options.page.as_deref()?;
        Some(page.replace("{session}", session.as_str()))
    }

    /// Returns a run with its page, as the result of a tool.
    pub(super) fn show_run(&self, run: &RunView) -> Result<Reply, Problem> {
        let page = self.page(&run.record.session);
        let page = page.map_or(String::new(), |page| format!(", or let the person decide on {page}"));
        Reply::new(text::run(run, &page), run)
    }
}

/// Returns the text of the form: all that the person decides on.
fn message(snapshot: &Snapshot, plan: &VerifiedPlan, hash: &str, robot: &str, is_rule: bool) -> String {
    let proposal = snapshot.view.proposal.as_ref().filter(|own| own.plan == hash);
    let (instruction, remarks) = match (proposal, &snapshot.next) {
        (Some(proposal), _) => {
            let question = snapshot.view.question.iter();
            let instruction = snapshot.view.instruction.clone().unwrap_or_default();
            (
                instruction,
                format!("{}{}", section("Question", question), text::remarks(&proposal.answer)),
            )
        }
        (None, Some(accepted)) => {
            let assumptions = assumptions(plan);
            let remarks = [
                section("Goal", goal_of(accepted)),
                section("Assumed", assumptions),
                section(
                    "Words of the instruction that the plan does not say",
                    &accepted.not_in_plan,
                ),
            ];
            (accepted.instruction.clone(), remarks.concat())
        }
        (None, None) => (String::new(), String::new()),
    };
    let head = if is_rule {
        "Put this rule in force? Nothing moves.".to_owned()
    } else {
        format!("Let the robot `{robot}` do this?")
    };
    let steps = text::steps(&outline(plan.world(), plan.plan()));
    format!("{head}\nInstruction: {instruction}{steps}{remarks}\nRobot: {robot}\nHash: {hash}")
}

/// Returns the assumptions of a verified plan as sentences.
pub(super) fn assumptions(plan: &VerifiedPlan) -> Vec<String> {
    let report = plan.report();
    report.assumptions.iter().map(|own| own.message(plan.world())).collect()
}

impl Face {
    /// Asks the person, and carries the plan out after a yes.
    pub(super) async fn execute_plan(&self, caller: &Caller, asked: Execute, input: Input) -> Result<Reply, Problem> {
        let asked = Arc::new(asked);
        let (own, by) = (Arc::clone(&asked), caller.by.clone());
        let ready = self.work(move |shared| shared.ready(&own, &by)).await?;
        let decision = self.shared.consent.ask(caller, &ready.form, &input).await;
        let by = caller.by.clone();
        self.work(move |shared| {
            let offer = &ready.offer;
            let decision =
                decision.inspect_err(|problem| shared.refused(&by, &offer.session, &offer.plan, &problem.message))?;
            match decision {
                Asked::Later(later) => Ok(Reply::Asked(later)),
                Asked::Decided(Decision::Approved) => shared.approved(&asked, &ready, &by),
                Asked::Decided(Decision::NobodyAsked(why)) => shared.left_for_page(&ready, why, &by),
                Asked::Decided(Decision::Declined(why) | Decision::Void(why)) => {
                    shared.refused(&by, &offer.session, &offer.plan, why);
                    Err(not_approved(why))
                }
            }
        })
        .await
    }

    /// Asks the person the question of a run, and passes the answer on.
    pub(super) async fn decide(&self, caller: &Caller, asked: Decide, input: Input) -> Result<Reply, Problem> {
        let run = self.named_run(&asked.run)?;
        let view = self.shared.hub.run(&run)?;
        let form = question_form(&run, &view, &asked.question)?;
        let decision = match self.shared.consent.ask(caller, &form, &input).await? {
            Asked::Later(later) => return Ok(Reply::Asked(later)),
            Asked::Decided(decision) => decision,
        };
        let is_yes = match decision {
            Decision::Approved => true,
            Decision::Declined(_) => false,
            Decision::Void(why) => return Err(not_approved(why)),
            Decision::NobodyAsked(why) => {
                let page = self.shared.page(&view.record.session);
                let page = page.unwrap_or_else(|| "a client that shows forms (elicitation)".to_owned());
                let hint = format!("ask the person to decide with {page}; `stop` ends the run");
                let message = format!("Nobody was asked: {why}. The run waits.");
                return Err(Problem::new(ProblemKind::Forbidden, message).hint(hint));
            }
        };
        let (by, question) = (caller.by.clone(), asked.question);
        self.work(move |shared| shared.show_run(&*shared.hub.decide(&run, &question, is_yes, &by)?))
            .await
    }
}

fn not_approved(why: &str) -> Problem {
    Problem::new(
        ProblemKind::Forbidden,
        format!("Not approved: {why}. Nothing has moved for this."),
    )
    .hint("ask the person what is to be different; `revise` changes the plan, `discard` drops it")
}

/// Returns the form for the question of a run.
fn question_form(run: &RunId, view: &RunView, id: &str) -> Result<Form, Problem> {
    let question = view.question.as_ref().filter(|question| question.id == id);
    let question = question.ok_or_else(|| {
        Problem::conflict("the run asks something else, or nothing").hint("call `run_status` for its question")
    })?;
    let message = format!(
        "{}{}{}\nInstruction: {}\nRobot: {}\nHash: {}",
        question.text,
        section("Steps", &question.steps),
        section("Edits", &question.edits),
        view.record.instruction,
        view.record.robot,
        question.id
    );
    Ok(Form {
        message,
        yes: "Yes",
        hash: question.id.clone(),
        binding: vec![run.to_string(), question.id.clone()],
    })
}
