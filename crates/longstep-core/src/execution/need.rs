//! The next need of an execution, and its end.

use serde::{Deserialize, Serialize};

use super::monitor::Noticed;
use super::{Proposal, Unseen};
use crate::autonomy::Refusal;
use longstep_model::model::{ActionId, EntityId, Fact, World, ground};
use longstep_search::search::WhyNot;
use longstep_verify::plan::StepId;
use longstep_verify::skill::Skills;
use longstep_verify::verify::VerifiedPlan;

/// The beginning of the sentence for [`Stop::Robot`].
pub(super) const ROBOT_FAILED: &str = "the robot failed: ";

/// Maximum number of facts in the sentence of a stop.
const LISTED: usize = 5;

/// The next input that an [`Execution`](super::Execution) needs.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Need {
    /// A robot performs the step; then [`performed`](super::Execution::performed) or
    /// [`failed`](super::Execution::failed).
    Perform(StepOrder),
    /// As [`Need::Perform`], for a step that reveals one of its [`StepOrder::outcomes`].
    Sense(StepOrder),
    /// An observation; then [`observed`](super::Execution::observed).
    Observe,
    /// A decision of a person; then [`approve`](super::Execution::approve) or [`refuse`](super::Execution::refuse).
    Approve(Proposal),
    /// A person who knows whether a step that was under way at a crash was done; then
    /// [`judged`](super::Execution::judged).
    Judge(StepOrder),
    /// A person who knows whether something is so that no look has shown; then
    /// [`confirmed`](super::Execution::confirmed).
    Confirm(Unseen),
    /// The time of [`Autonomy::announcement`](crate::autonomy::Autonomy::announcement), in which a person may stop or pause the
    /// execution; then [`announced`](super::Execution::announced). Orders under way may end meanwhile.
    Announce(StepOrder),
    /// Nothing: the steps that are under way have to end first.
    Wait,
    /// Nothing: the execution is paused, and no step is under way; [`go_on`](super::Execution::go_on) ends the pause.
    Paused,
    /// Nothing: the purpose is achieved in the observed world.
    Done,
    /// Nothing: the execution has stopped.
    Stopped(Stop),
}

/// A step that a robot is to perform.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct StepOrder {
    /// The number of the order in the execution, from 1.
    pub number: u64,
    /// The step of the plan in force.
    pub step: StepId,
    /// The hand, arm or robot; none if the action has no actor.
    pub lane: Option<EntityId>,
    /// The action.
    pub action: ActionId,
    /// One entity for each parameter.
    pub arguments: Vec<EntityId>,
    /// The step for a person.
    pub explanation: String,
    /// The possible outcomes of a sensing step, of which exactly one holds; empty for other steps.
    pub outcomes: Vec<Fact>,
    /// The values of the skill parameters, by name.
    pub skills: serde_json::Map<String, serde_json::Value>,
}

impl StepOrder {
    /// Returns the order for a step of a plan, as an execution gives it if nothing interferes: its number is that of the
    /// step. For a look at the orders before anything moves.
    ///
    /// # Panics
    ///
    /// If the plan has no such step.
    pub fn of_step(plan: &VerifiedPlan, id: StepId, skills: &Skills) -> Self {
        let (world, step) = (plan.world(), plan.plan().step(id));
        let senses = &world.domain().action(step.action).senses;
        Self {
            number: id.index() as u64 + 1,
            step: id,
            lane: step.actor(world.domain()),
            action: step.action,
            outcomes: senses.iter().map(|atom| ground(atom, &step.arguments)).collect(),
            skills: skills.values(world, Some(id), step.action, &step.arguments),
            arguments: step.arguments.clone(),
            explanation: step.explanation.clone(),
        }
    }

    /// Writes the action with all its arguments: `attach(<cup>, <shelf>)`.
    pub fn written(&self, world: &World) -> String {
        super::written::written_step(world, self.action, &self.arguments)
    }
}

/// The reason of a stop.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Stop {
    /// A person or the program asked for it.
    Requested(String),
    /// A person refused the plan, a change or a step.
    Refused,
    /// No plan achieves the purpose from the observed world: proven.
    NoPlan {
        /// The reasons.
        why: WhyNot,
        /// The steps that the robot cannot perform, and that no plan may contain, with the robot's reasons.
        failed: Vec<String>,
    },
    /// No plan was found within the limits; one may exist.
    GaveUp {
        /// The limit.
        why: String,
        /// As in [`Stop::NoPlan`].
        failed: Vec<String>,
    },
    /// The plan was changed as often as the settings allow.
    TooManyChanges(u32),
    /// One world came about twice with one rest of the plan: another change would not help.
    Repeated,
    /// A constraint of the instruction, or a rule of the domain for every state, is broken in the observed world.
    Broken {
        /// The constraint as a sentence, or the name of the rule.
        constraint: String,
        /// The facts that differ from those that were expected.
        because: Vec<Noticed>,
    },
    /// The purpose may be achieved, or a stage of it, but that rests on facts that were not observed.
    Unseen {
        /// These facts; at least one.
        unseen: Vec<Unseen>,
        /// True if a person said that it is not so.
        denied: bool,
    },
    /// The levels and limits of the robot refuse a step, which was not ordered.
    OutOfLimits {
        /// The action with all its arguments.
        step: String,
        /// The reason.
        refusal: Refusal,
    },
    /// The robot failed, not one of its steps.
    Robot(String),
}

impl Stop {
    /// Returns true if the stop follows from the observed world alone: no plan exists, or a constraint is broken.
    pub fn is_proven(&self) -> bool {
        matches!(self, Self::NoPlan { .. } | Self::Broken { .. })
    }

    /// Returns true if the execution can be resumed from its log: a stop at a request, a failure of the robot, or a fact that
    /// nobody has seen says nothing about the plan.
    pub fn is_resumable(&self) -> bool {
        matches!(self, Self::Requested(_) | Self::Robot(_) | Self::Unseen { .. })
    }

    /// The reason as a sentence.
    pub fn sentence(&self, world: &World) -> String {
        match self {
            Self::Requested(why) => why.clone(),
            Self::Refused => "a person did not approve it".to_owned(),
            Self::NoPlan { why, failed } => {
                let mut reasons = failed.clone();
                // A step that cannot be done is among the prohibitions too.
                let is_new = |own: &&String| {
                    let call = own.strip_prefix("never ").unwrap_or(own);
                    !failed.iter().any(|failed| failed.contains(call))
                };
                let prohibitions = why.prohibitions.iter().filter(is_new);
                reasons.extend(prohibitions.map(|own| format!("`{own}` prevents a plan")));
                reasons.extend(why.missing.as_ref().map(|missing| missing.sentence(world)));
                let reasons = if reasons.is_empty() {
                    String::new()
                } else {
                    format!(": {}", reasons.join("; "))
                };
                format!("no plan achieves the goal from here{reasons}")
            }
            Self::GaveUp { why, failed } => {
                let failed: String = failed.iter().map(|own| format!("; {own}")).collect();
                format!("no plan was found from here ({why}){failed}")
            }
            Self::TooManyChanges(changes) => format!("the plan was changed {changes} times already"),
            Self::Repeated => "the same world came about again with the same rest of the plan".to_owned(),
            Self::Broken { constraint, because } => {
                let because: Vec<String> = because.iter().map(|own| own.sentence(world)).collect();
                format!("a constraint no longer holds ({constraint}): {}", because.join(", "))
            }
            Self::Unseen { unseen, denied } => {
                let sentence = |own: &Unseen| if *denied { own.what.clone() } else { own.sentence() };
                let facts: Vec<String> = unseen.iter().take(LISTED).map(sentence).collect();
                let more = match unseen.len().saturating_sub(LISTED) {
                    0 => String::new(),
                    more => format!("; and {more} more"),
                };
                let said = if *denied {
                    "a person says that this is not so"
                } else {
                    "not observed"
                };
                format!("{said}: {}{more}", facts.join("; "))
            }
            Self::OutOfLimits { step, refusal } => format!("`{step}` is outside of the limits of the robot: {refusal}"),
            Self::Robot(why) => format!("{ROBOT_FAILED}{why}"),
        }
    }
}

/// How a difference between the expected and the observed world affects the rest of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effect {
    /// The rest is valid from the observed world and achieves its purpose.
    Harmless,
    /// The first steps of the rest have become needless.
    Helpful,
    /// The last steps had no effect, and are repeated.
    Undone,
    /// The rest does not achieve its purpose from the observed world.
    Harmful,
}
