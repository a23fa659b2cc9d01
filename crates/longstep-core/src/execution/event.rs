//! The events of an execution, one JSON object each.

use std::time::Duration;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::change::{Change, ChangeKind};
use super::monitor::Noticed;
use super::need::{Effect, StepOrder};
use super::written::written_outcome;
use super::{Aim, Approval, ProposalId, Settings, Trust, Unseen, Watch};
use longstep_model::environment::{Environment, Observation};
use longstep_model::model::{Fact, World};
use longstep_verify::plan::{Plan, Written, write_tree};
use longstep_verify::verify::VerifiedPlan;

/// The version of the log.
pub(super) const FORMAT: u32 = 3;

/// A plan in a log: its tree with all arguments, as in `task_tree` of a plan file.
pub type PlanText = Value;

/// An event of an execution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
#[non_exhaustive]
#[expect(clippy::large_enum_variant, reason = "events are written one by one and not kept")]
pub enum Event {
    /// The execution began: everything that is needed to take it up again.
    Began {
        /// The version of the log.
        format: u32,
        /// The name of the domain.
        domain: String,
        /// The environment in which the plan begins.
        environment: Environment,
        /// The plan.
        plan: PlanText,
        /// The goal; none for a plan without one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        goal: Option<String>,
        /// The constraints in force, in the goal language, with `true` for a standing one.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        constraints: Vec<(String, bool)>,
        /// When a person is asked.
        approval: Approval,
        /// The evidence that progress and the end need.
        trust: Trust,
        /// When the world is observed.
        watch: Watch,
        /// The number of changes after which the execution stops.
        changes: u32,
        /// The names of the predicates that observations list besides the states of entities.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        reports: Vec<String>,
        /// The skills file.
        #[serde(default, skip_serializing_if = "Value::is_null")]
        skills: Value,
        /// The levels of autonomy, and the limits, of the robot.
        #[serde(default, skip_serializing_if = "Value::is_null")]
        autonomy: Value,
    },
    /// A person approved what was proposed last.
    Approved {
        /// The proposal that the person saw.
        proposal: ProposalId,
    },
    /// A person refused what was proposed last.
    Refused,
    /// A step will be ordered after some seconds, unless the execution is stopped or paused.
    Announced {
        /// The number of the order.
        order: u64,
        /// The hand, arm or robot.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lane: Option<String>,
        /// The action with all its arguments.
        call: String,
        /// The step for a person.
        explanation: String,
        /// The seconds until then.
        seconds: f64,
    },
    /// A robot is about to perform a step.
    Ordered {
        /// The number of the order.
        order: u64,
        /// The number of the step in the plan in force, from 1.
        step: usize,
        /// The hand, arm or robot.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lane: Option<String>,
        /// The action with all its arguments.
        call: String,
        /// The step for a person.
        explanation: String,
    },
    /// The robot says that it did a step.
    Performed {
        /// The number of the order.
        order: u64,
        /// The outcome of a sensing step.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        outcome: Option<String>,
    },
    /// The robot says that it could not do a step.
    Failed {
        /// The number of the order.
        order: u64,
        /// The robot's reason.
        why: String,
    },
    /// The world was observed.
    Observed {
        /// The statements of the robot.
        statements: Observation,
    },
    /// A difference between the expected and the observed world, and what follows from it.
    Assessed {
        /// The effect on the rest of the plan.
        effect: Effect,
        /// The differing facts, as sentences.
        because: Vec<String>,
        /// The steps that are needless or repeated.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        steps: Vec<String>,
    },
    /// A change of the rest of the plan was found.
    Changed {
        /// How it was found.
        kind: ChangeKind,
        /// The new rest.
        plan: PlanText,
        /// Its steps, as sentences.
        steps: Vec<String>,
        /// The edits with their reasons.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        edits: Vec<String>,
    },
    /// The execution is paused: nothing is under way, and nothing is ordered.
    Paused,
    /// The pause is over. The world is observed before the next order.
    Continued,
    /// The program ended while the execution went on; orders that were under way are unknown.
    Interrupted {
        /// The numbers of these orders.
        under_way: Vec<u64>,
        /// When a person is asked from now on, if that is stricter than before.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        approval: Option<Approval>,
        /// The evidence that is needed from now on, if that is stricter than before.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        trust: Option<Trust>,
    },
    /// An observation shows that an interrupted order was done.
    Found {
        /// The number of the order.
        order: u64,
    },
    /// A person decided whether an interrupted order was done.
    Judged {
        /// The number of the order.
        order: u64,
        /// True if it was done.
        done: bool,
    },
    /// A person said whether something is so that no look has shown.
    Confirmed {
        /// The fact or number as a sentence.
        what: String,
        /// True if it is so.
        holds: bool,
    },
    /// Progress through the stages of the goal rests on promises.
    Trusted {
        /// The promises.
        unseen: Vec<Unseen>,
    },
    /// The execution stopped.
    Stopped {
        /// The reason.
        why: String,
        /// True if it follows from the observed world alone.
        proven: bool,
        /// The orders that were under way.
        under_way: Vec<u64>,
        /// The environment as far as it is known.
        environment: Environment,
    },
    /// The purpose is achieved in the observed world.
    Done {
        /// The environment.
        environment: Environment,
        /// The facts and numbers of the purpose that the looks of the end have not shown.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        unseen: Vec<Unseen>,
    },
}

impl Event {
    /// Returns the beginning of an execution in a world with the constraints in force, but without those that the limits
    /// add.
    pub(super) fn began(world: &World, plan: &VerifiedPlan, aim: &Aim, settings: &Settings) -> Self {
        let domain = world.domain();
        let constraints = world.prohibitions().iter();
        Self::Began {
            format: FORMAT,
            domain: domain.name.clone(),
            environment: world.environment().clone(),
            plan: plan_text(world, plan.plan()),
            goal: match aim {
                Aim::Goal(goal) => Some(goal.clone()),
                Aim::Endings => None,
            },
            constraints: constraints.map(|own| (own.written.clone(), own.standing)).collect(),
            approval: settings.approval,
            trust: settings.trust,
            watch: settings.watch,
            changes: settings.changes,
            reports: settings
                .reports
                .iter()
                .map(|predicate| domain.predicate(*predicate).name.clone())
                .collect(),
            skills: settings.skills.source().clone(),
            autonomy: settings.autonomy.to_value(domain),
        }
    }

    pub(super) fn announced(world: &World, order: &StepOrder, after: Duration) -> Self {
        Self::Announced {
            order: order.number,
            lane: order.lane.map(|lane| world.entity(lane).identifier.clone()),
            call: order.written(world),
            explanation: order.explanation.clone(),
            seconds: after.as_secs_f64(),
        }
    }

    pub(super) fn ordered(world: &World, order: &StepOrder) -> Self {
        Self::Ordered {
            order: order.number,
            step: order.step.index() + 1,
            lane: order.lane.map(|lane| world.entity(lane).identifier.clone()),
            call: order.written(world),
            explanation: order.explanation.clone(),
        }
    }

    pub(super) fn performed(world: &World, order: u64, outcome: Option<Fact>) -> Self {
        Self::Performed {
            order,
            outcome: outcome.map(|fact| written_outcome(world, fact)),
        }
    }

    pub(super) fn assessed(world: &World, effect: Effect, because: &[Noticed], steps: &[String]) -> Self {
        Self::Assessed {
            effect,
            because: sentences(world, because),
            steps: steps.to_vec(),
        }
    }

    pub(super) fn changed(world: &World, change: &Change) -> Self {
        let edit = |edit: &longstep_search::repair::Edit| format!("{}: {}", edit.description(change.steps), edit.why);
        Self::Changed {
            kind: change.kind,
            plan: plan_text(world, change.plan.plan()),
            steps: change
                .plan
                .steps()
                .iter()
                .map(|step| step.explanation.clone())
                .collect(),
            edits: change.edits.iter().map(edit).collect(),
        }
    }
}

/// Returns the differing facts as sentences, at most twenty.
pub(super) fn sentences(world: &World, differences: &[Noticed]) -> Vec<String> {
    let first = differences.iter().take(20);
    first.map(|own| own.sentence(world)).collect()
}

pub(super) fn plan_text(world: &World, plan: &Plan) -> PlanText {
    write_tree(&Written::of_plan(world, plan))
}
