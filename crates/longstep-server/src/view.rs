//! Sessions as a face shows them.

use longstep::report::Answer;
use longstep::session::{Accepted, Ended, Proposal, Response, Session};
use longstep_core::environment::{Environment, World};
use longstep_core::execution::plan_hash;
use serde::Serialize;

use crate::id::SessionId;

/// A session as a program or a page sees it.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct SessionView {
    /// Its id.
    pub id: SessionId,
    /// The number of its changes, which grows with each.
    pub version: u64,
    /// Its domain.
    pub domain: String,
    /// The model that answers.
    pub model: String,
    /// `ready`, `thinking`, `question`, `plan`, `consent`, `no_plan` or `endings`.
    pub state: &'static str,
    /// The instruction in progress.
    pub instruction: Option<String>,
    /// The question to the person, for `question` and `consent`.
    pub question: Option<String>,
    /// The plan that waits for a decision, for `plan` and `consent`.
    pub proposal: Option<ProposalView>,
    /// The reason, for `no_plan`.
    pub failure: Option<FailureView>,
    /// The possible endings of the last plan, for `endings`.
    pub endings: Vec<EndingView>,
    /// The accepted plans, in order.
    pub accepted: Vec<AcceptedView>,
    /// The rules in force, in the goal language.
    pub rules: Vec<String>,
    /// The world before the next instruction.
    pub environment: Environment,
}

/// A plan that waits for a decision.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ProposalView {
    /// The hash that a person names to accept or approve it.
    pub plan: String,
    /// The reasons why the last feedback changed nothing, or not all of it.
    pub refused: Vec<String>,
    /// True if accepting it puts a standing rule in force, and nothing else.
    pub offers_rule: bool,
    /// The plan, as `longstep plan --json` prints it.
    pub answer: Answer,
}

/// The reason why an instruction led to no plan.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct FailureView {
    /// The reason in one line.
    pub message: String,
    /// The findings about plans, if the instruction was understood.
    pub answer: Option<Answer>,
}

/// A possible ending of a plan.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct EndingView {
    /// The outcomes that distinguish it from the others.
    pub when: Vec<String>,
    /// The world after it.
    pub environment: Environment,
}

/// An accepted plan.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct AcceptedView {
    /// Its number, from 0.
    pub number: usize,
    /// The hash that a person names to approve it.
    pub plan: String,
    /// The instruction.
    pub instruction: String,
    /// The goal, with identifiers of the environment.
    pub goal: Vec<String>,
    /// Its steps as sentences.
    pub steps: Vec<String>,
    /// The words of the instruction that the plan does not say.
    pub not_in_plan: Vec<String>,
    /// True if no robot has carried it out yet.
    pub pending: bool,
}

/// A session at a moment: what is shown of it, and what pictures and runs are made of.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Snapshot {
    /// The session as data.
    pub view: SessionView,
    /// The world before the next instruction.
    pub world: World,
    /// The world in which the robot is.
    pub robot_world: World,
    /// The plan that waits for a decision.
    pub proposal: Option<Box<Proposal>>,
    /// The next plan that waits for a robot.
    pub next: Option<Box<Accepted>>,
}

/// Returns the goal of an accepted plan in the goal language.
pub(crate) fn goal_of(accepted: &Accepted) -> Vec<String> {
    accepted
        .goal
        .iter()
        .flat_map(|goal| goal.exact(&accepted.before))
        .collect()
}

/// Returns the hash of an accepted plan.
pub(crate) fn accepted_hash(accepted: &Accepted) -> String {
    plan_hash(&accepted.plan, &goal_of(accepted))
}

/// Returns the hash of a proposed plan.
pub(crate) fn proposal_hash(proposal: &Proposal) -> String {
    plan_hash(&proposal.plan, &proposal.answer.goal)
}

impl AcceptedView {
    fn of(number: usize, accepted: &Accepted, pending: bool) -> Self {
        let steps = accepted.plan.steps().iter();
        Self {
            number,
            plan: accepted_hash(accepted),
            instruction: accepted.instruction.clone(),
            goal: goal_of(accepted),
            steps: steps.map(|step| step.explanation.clone()).collect(),
            not_in_plan: accepted.not_in_plan.clone(),
            pending,
        }
    }
}

impl Snapshot {
    /// Takes a snapshot. `before` has the accepted plans of the last one: a plan does not change, and one change of a session
    /// either accepts plans or reverts the last one, so the plans with the same numbers are the same.
    pub(crate) fn of(id: &SessionId, version: u64, session: &Session, before: &[AcceptedView]) -> Self {
        let response = session.response();
        let state = match &response {
            Response::Ready => "ready",
            Response::Waiting => "thinking",
            Response::Plan(_) => "plan",
            Response::Consent(_) => "consent",
            Response::Question(_) => "question",
            Response::NoPlan(_) => "no_plan",
            Response::Endings(_) => "endings",
            _ => "unknown",
        };
        let question = match &response {
            Response::Question(question) => Some((*question).to_owned()),
            Response::Consent(proposal) => proposal.question.clone(),
            _ => None,
        };
        let proposal = session.proposal();
        let pending = session.pending();
        let accepted = session.accepted().iter().enumerate().map(|(number, accepted)| {
            let pending = pending.contains(&number);
            match before.get(number) {
                Some(known) => AcceptedView {
                    pending,
                    ..known.clone()
                },
                None => AcceptedView::of(number, accepted, pending),
            }
        });
        let endings = session.endings().into_iter().map(|ended: Ended| EndingView {
            when: ended.when,
            environment: ended.environment,
        });
        let failure = session.failure().map(|failure| FailureView {
            message: failure.to_string(),
            answer: failure.answer().cloned(),
        });
        let next = pending.start;
        let next = session.accepted().get(next).filter(|_| pending.contains(&next));
        Self {
            view: SessionView {
                id: id.clone(),
                version,
                domain: session.domain().name.clone(),
                model: session.model().name.clone(),
                state,
                instruction: session.instruction().map(str::to_owned),
                question,
                proposal: proposal.map(|proposal| ProposalView {
                    plan: proposal_hash(proposal),
                    refused: proposal.refused.iter().map(ToString::to_string).collect(),
                    offers_rule: proposal.offers_rule(),
                    answer: proposal.answer.clone(),
                }),
                failure,
                endings: endings.collect(),
                accepted: accepted.collect(),
                rules: session.rules().iter().map(|rule| rule.written.clone()).collect(),
                environment: session.world().environment().clone(),
            },
            world: session.world().clone(),
            robot_world: session.robot_world().clone(),
            proposal: proposal.cloned().map(Box::new),
            next: next.cloned().map(Box::new),
        }
    }
}
