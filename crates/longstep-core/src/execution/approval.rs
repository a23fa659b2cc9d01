//! Proposals, and the decisions of a person about them.

use std::fmt;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::change::Change;
use super::event::plan_text;
use super::{Event, Execution, ExecutionError, Phase, StepOrder, Stop};
use crate::plan::{Written, write_tree};
use crate::verify::VerifiedPlan;

/// The number of bytes of an id.
const ID_LENGTH: usize = 16;

/// Returns the first bytes of a hash as hexadecimal digits.
fn digits(hash: &[u8]) -> String {
    hash[..ID_LENGTH].iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Returns the hash of a plan: of its steps with all arguments, of the world before it with the rules in force, and of its
/// goal, with identifiers of the environment. An approval before a run names it.
///
/// ```
/// # use longstep_core::{domain, environment, execution::plan_hash, plan, verify::check_file};
/// # let household = domain::shipped("household").unwrap().unwrap();
/// # let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// # let world = environment::parse(&household, "env.json", text).unwrap();
/// # let draft = plan::read(r#"{"task_sequence": ["move_hand()"], "object_name": "<pen>"}"#).unwrap();
/// # let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
/// assert_eq!(plan_hash(&plan, &[]).len(), 32);
/// assert_ne!(plan_hash(&plan, &[]), plan_hash(&plan, &["put(<pen>, <desk>)".to_owned()]));
/// ```
pub fn plan_hash(plan: &VerifiedPlan, goal: &[String]) -> String {
    let world = plan.world();
    let rules: Vec<&str> = world.prohibitions().iter().map(|rule| rule.written.as_str()).collect();
    let tree = write_tree(&Written::of_plan(world, plan.plan()));
    let content = serde_json::json!([world.environment(), rules, goal, tree]);
    digits(&Sha256::digest(content.to_string()))
}

/// A matter that a person decides.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Proposal {
    /// The id, which [`Execution::approve`] takes.
    pub id: ProposalId,
    /// The subject.
    pub subject: Subject,
}

/// The subject of a proposal.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Subject {
    /// The plan, before its first step.
    Plan,
    /// A change of the rest of the plan.
    Change(Box<Change>),
    /// One step, before it is performed.
    Step(StepOrder),
}

/// A hash of a proposal: of the steps, of the observed world, and of its place in the run.
///
/// An approval names the proposal that the person saw. So it never approves another one, which may have taken its place
/// because the world has changed in the meantime.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ProposalId(String);

impl fmt::Display for ProposalId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl Execution {
    /// Waits for a decision about a subject.
    pub(super) fn propose(&mut self, subject: Subject) {
        let id = self.proposal_id(&subject);
        self.phase = Phase::Approving(Proposal { id, subject });
    }

    fn proposal_id(&self, subject: &Subject) -> ProposalId {
        let content = match subject {
            Subject::Plan => serde_json::json!({ "plan": plan_text(&self.world, self.plan().plan()) }),
            Subject::Change(change) => serde_json::json!({ "change": Event::changed(&self.world, change) }),
            Subject::Step(order) => serde_json::json!({
                "step": Event::ordered(&self.world, order),
                "skills": order.skills,
                "plan": plan_text(&self.world, self.plan().plan()),
            }),
        };
        // Equal proposals at two places of a run are two decisions.
        let place = (self.changes, self.orders);
        let mut hash = Sha256::new();
        hash.update(serde_json::json!([place, self.environment(), content]).to_string());
        ProposalId(digits(&hash.finalize()))
    }

    /// Approves what was proposed, and nothing else.
    ///
    /// ```
    /// # use longstep_core::environment::{self, Observation};
    /// # use longstep_core::execution::{Aim, Approval, Execution, ExecutionError, Need, Resumed, Settings, Stop};
    /// # use longstep_core::{domain, plan, verify::check_file};
    /// # let household = domain::shipped("household").unwrap().unwrap();
    /// # let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
    /// # let world = environment::parse(&household, "env.json", text).unwrap();
    /// # let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
    /// # let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
    /// # let seen: Observation = serde_json::from_str(r#"{"states": {"<pen>": "on_something(<desk>)"}}"#).unwrap();
    /// let mut execution = Execution::new(&plan, &Aim::Endings, Settings::default()).unwrap();
    /// let Need::Approve(proposal) = execution.next_need() else { panic!() };
    /// assert_eq!(execution.approve(&proposal.id), Ok(()));
    /// assert_eq!(execution.approve(&proposal.id), Err(ExecutionError::NothingProposed));
    ///
    /// let mut execution = Execution::new(&plan, &Aim::Endings, Settings::default()).unwrap();
    /// assert_eq!(execution.refuse(), Ok(()));
    /// assert!(matches!(execution.next_need(), Need::Stopped(Stop::Refused)));
    /// ```
    ///
    /// # Errors
    ///
    /// If nothing waits for a decision, or another proposal does. Nothing is approved then.
    pub fn approve(&mut self, id: &ProposalId) -> Result<(), ExecutionError> {
        let Phase::Approving(proposal) = &self.phase else {
            return Err(ExecutionError::NothingProposed);
        };
        if proposal.id != *id {
            return Err(ExecutionError::AnotherProposal);
        }
        let Proposal { id, subject } = proposal.clone();
        self.phase = Phase::Active;
        self.events.push(Event::Approved { proposal: id });
        match subject {
            Subject::Plan => {}
            Subject::Step(order) => self.approved = Some(order),
            Subject::Change(change) => {
                self.unapproved = false;
                self.install(&change.plan, None);
            }
        }
        Ok(())
    }

    /// Refuses what was proposed: the execution stops. A refusal needs no id, for nothing moves because of it. See the
    /// example of [`Execution::approve`].
    ///
    /// # Errors
    ///
    /// If nothing waits for a decision.
    pub fn refuse(&mut self) -> Result<(), ExecutionError> {
        let Phase::Approving(_) = self.phase else {
            return Err(ExecutionError::NothingProposed);
        };
        self.events.push(Event::Refused);
        self.end(Stop::Refused);
        Ok(())
    }

    /// Withdraws a change, a step or a question about a fact that waits for a decision, and the approval of a step, because the world is not as it was. A plan stays: it is
    /// to be approved before its first step in any world.
    pub(super) fn withdraw(&mut self) {
        let is_out_of_date = match &self.phase {
            Phase::Approving(proposal) => !matches!(proposal.subject, Subject::Plan),
            phase => matches!(phase, Phase::Confirming(..)),
        };
        if is_out_of_date {
            self.phase = Phase::Active;
        }
        self.approved = None;
        self.announcement = None;
    }
}
