//! The tools that judge and explain plans: `verify`, `repair` and `explain`.

use longstep::report::Answer;
use longstep::session::why;
use longstep_core::plan::StepId;
use longstep_core::verify::Purpose;
use serde::Serialize;
use serde_json::Value;

use super::call::{Draft, InSession};
use super::execute::assumptions;
use super::face::{Face, Shared};
use super::reply::{Reply, section};
use super::text;
use crate::hub::NewSession;
use crate::id::SessionId;
use crate::problem::Problem;
use crate::view::{Snapshot, goal_of};

/// The most steps that are explained: each is verified twice.
const EXPLAINED: usize = 100;

/// A plan with the reasons for its steps.
#[derive(Debug, Serialize)]
struct Explained {
    session: SessionId,
    /// What `execute_plan` names.
    plan_id: String,
    /// The hash of the plan.
    hash: String,
    instruction: String,
    /// The goal, with identifiers of the environment.
    goal: Vec<String>,
    steps: Vec<ExplainedStep>,
    /// Assumptions on which the plan rests.
    assumptions: Vec<String>,
    /// The words and parts of the instruction that the plan does not say.
    not_in_plan: Vec<String>,
    /// The rules in force.
    rules: Vec<String>,
}

/// A step with its reason.
#[derive(Debug, Serialize)]
struct ExplainedStep {
    /// From 1, as in texts.
    number: usize,
    text: String,
    /// What the step makes true or false.
    brings_about: Vec<String>,
    /// What would be wrong without it.
    without_it: Vec<String>,
}

impl Shared {
    /// Returns the world of a plan in a text: that of a session, or the one in which a session begins.
    fn place(&self, session: Option<&SessionId>) -> Result<NewSession, Problem> {
        let Some(id) = session else {
            return Ok(self.options.start.clone());
        };
        let view = &self.hub.session(id)?.view;
        let environment = serde_json::to_string(&view.environment).unwrap_or_default();
        Ok(NewSession::of_environment(&view.domain, &environment).with_rules(view.rules.clone()))
    }

    fn explain(&self, snapshot: &Snapshot) -> Result<Reply, Problem> {
        let nothing = || Problem::conflict("the session has no plan").hint("call `plan` with an instruction");
        let (plan_id, offer) = self.offer(snapshot)?.ok_or_else(nothing)?;
        let steps = explained_steps(snapshot);
        let rules = snapshot.view.rules.clone();
        let session = snapshot.view.id.clone();
        let explained = match (&snapshot.proposal, &snapshot.next) {
            (Some(proposal), _) => {
                let answer = &proposal.answer;
                let gaps = answer.not_represented.iter().map(|gap| gap.text.clone());
                Explained {
                    instruction: snapshot.view.instruction.clone().unwrap_or_default(),
                    goal: answer.goal.clone(),
                    assumptions: answer.assumptions.clone(),
                    not_in_plan: answer.plan.not_in_plan.iter().cloned().chain(gaps).collect(),
                    session,
                    plan_id,
                    hash: offer.plan,
                    steps,
                    rules,
                }
            }
            (None, Some(accepted)) => Explained {
                instruction: accepted.instruction.clone(),
                goal: goal_of(accepted),
                assumptions: assumptions(&accepted.plan),
                not_in_plan: accepted.not_in_plan.clone(),
                session,
                plan_id,
                hash: offer.plan,
                steps,
                rules,
            },
            (None, None) => return Err(nothing()),
        };
        Reply::new(explanation(&explained), &explained)
    }
}

fn explained_steps(snapshot: &Snapshot) -> Vec<ExplainedStep> {
    let (plan, purpose, goal) = match (&snapshot.proposal, &snapshot.next) {
        (Some(proposal), _) => (&proposal.plan, proposal.purpose.clone(), proposal.goal.as_ref()),
        (None, Some(accepted)) => {
            let goal = accepted.goal.as_ref();
            let purpose = goal.map_or_else(Purpose::default, |goal| goal.purpose(&accepted.before));
            (&accepted.plan, purpose, goal)
        }
        (None, None) => return Vec::new(),
    };
    let numbered = plan.steps().iter().enumerate().take(EXPLAINED);
    numbered
        .map(|(index, step)| {
            let reason = why(plan.world(), plan.plan(), &purpose, goal, StepId::new(index));
            ExplainedStep {
                number: index + 1,
                text: step.explanation.clone(),
                brings_about: reason.brings_about,
                without_it: reason.without_it,
            }
        })
        .collect()
}

fn explanation(explained: &Explained) -> String {
    let steps = explained.steps.iter().map(|step| {
        let needed = match step.without_it.first() {
            Some(first) => format!(" Without it: {first}."),
            None => " The plan would be valid without it.".to_owned(),
        };
        let achieved = step.brings_about.join(", ");
        format!("\n{}. {} Achieves: {achieved}.{needed}", step.number, step.text)
    });
    let steps: String = steps.collect();
    format!(
        "The plan for `{}`:{steps}{}{}{}{}\nplan_id: {}\nhash: {}\nsession: {}",
        explained.instruction,
        section("Goal", &explained.goal),
        section("Assumed", &explained.assumptions),
        section("Not in the plan", &explained.not_in_plan),
        section("Rules in force", &explained.rules),
        explained.plan_id,
        explained.hash,
        explained.session,
    )
}

/// Returns the text of a plan that a model passes as text or as JSON.
fn plan_text(plan: &Value) -> String {
    plan.as_str().map_or_else(|| plan.to_string(), str::to_owned)
}

impl Face {
    /// Verifies a written plan.
    pub(super) async fn verify(&self, draft: Draft) -> Result<Reply, Problem> {
        self.assess(draft, |shared, place, text, goal| shared.hub.verify(place, text, goal))
            .await
    }

    /// Repairs a written plan.
    pub(super) async fn repair(&self, draft: Draft) -> Result<Reply, Problem> {
        self.assess(draft, |shared, place, text, goal| shared.hub.repair(place, text, goal))
            .await
    }

    async fn assess(
        &self,
        draft: Draft,
        assess: fn(&Shared, &NewSession, &str, Option<&str>) -> Result<Answer, Problem>,
    ) -> Result<Reply, Problem> {
        let session = self.session(draft.session.as_deref())?;
        self.work(move |shared| {
            let place = shared.place(session.as_ref())?;
            let answer = assess(shared, &place, &plan_text(&draft.plan), draft.goal.as_deref())?;
            Reply::new(text::verdict(&answer), &answer)
        })
        .await
    }

    /// Explains the plan that waits for a decision, or for a robot.
    pub(super) async fn explain(&self, asked: InSession) -> Result<Reply, Problem> {
        let id = self.known_session(asked.session.as_deref())?;
        self.work(move |shared| {
            let snapshot = shared.hub.session(&id)?;
            shared.explain(&snapshot)
        })
        .await
    }
}
