//! Changes of a plan that no longer fits the world: repair of its rest, or a new plan.

use serde::{Deserialize, Serialize};

use super::monitor::Noticed;
use super::need::Stop;
use super::{Approval, Event, Execution, Subject, ground};
use longstep_model::model::World;
use longstep_search::repair::{Edit, RepairOutcome, repair};
use longstep_search::schedule::compact;
use longstep_search::search::{Limits, Outcome, solve, why_not};
use longstep_verify::plan::{DraftStep, Node, Plan, Resolved, lanes};
use longstep_verify::verify::{Purpose, VerifiedPlan, check};

/// Maximum number of steps that the robot cannot do; each one that is found costs a search.
const FORBIDDEN: usize = 200;

/// How a change was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChangeKind {
    /// The rest of the plan was repaired.
    Repaired,
    /// A new plan for the purpose.
    Replanned,
}

/// A change of the rest of a plan.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Change {
    /// How it was found.
    pub kind: ChangeKind,
    /// The new rest, verified from the observed world.
    pub plan: VerifiedPlan,
    /// The edits of a repair with their reasons; empty for a new plan.
    pub edits: Vec<Edit>,
    /// The number of steps of the old rest.
    pub steps: usize,
    /// The facts that differ from those that were expected.
    pub because: Vec<Noticed>,
}

/// The end of an attempt to change a plan.
enum Attempt {
    Found(Box<Change>),
    NoPlan,
    GaveUp(String),
}

impl Execution {
    /// Changes the rest of the plan, so that it achieves the purpose from the observed world.
    pub(super) fn change(&mut self, here: &World, purpose: &Purpose, because: Vec<Noticed>) {
        let draft = self.draft();
        let steps = draft.steps().iter().map(ground).collect();
        let situation = (here.state.clone(), steps, self.forbidden.len());
        // What did not help once may have met a second mishap: a new plan is tried then, and nothing after that.
        let before = self.visited.iter().filter(|own| **own == situation).count();
        if before >= 2 {
            return self.end(Stop::Repeated);
        }
        if self.changes >= self.settings.changes {
            return self.end(Stop::TooManyChanges(self.changes));
        }
        if self.forbidden.len() > FORBIDDEN {
            return self.no_plan(|failed| Stop::GaveUp {
                why: format!("more than {FORBIDDEN} steps cannot be done"),
                failed: failed.into_iter().take(3).collect(),
            });
        }
        self.visited.push(situation);
        let attempt = self.attempt(here, purpose, (&draft, before > 0), because.clone());
        if let Attempt::Found(change) = &attempt
            && self.forbid_unfit(&change.plan)
        {
            let here = self.here(here.state.clone());
            return self.change(&here, purpose, because);
        }
        match attempt {
            Attempt::Found(change) => {
                self.changes += 1;
                self.events.push(Event::changed(here, &change));
                match self.settings.approval {
                    Approval::Never => self.install(&change.plan, None),
                    Approval::Changes | Approval::EachStep => self.propose(Subject::Change(change)),
                }
            }
            Attempt::NoPlan if self.leaves_out_what_worked() => self.no_plan(|failed| Stop::GaveUp {
                why: "nothing else leads to the goal".to_owned(),
                failed,
            }),
            Attempt::NoPlan => {
                let why = why_not(here, purpose, &Limits::default());
                self.no_plan(|failed| Stop::NoPlan { why, failed });
            }
            Attempt::GaveUp(why) => self.no_plan(|failed| Stop::GaveUp { why, failed }),
        }
    }

    /// Forbids the steps of a plan that nobody taught, or whose values are outside of the limits; returns true if there are
    /// any.
    fn forbid_unfit(&mut self, plan: &VerifiedPlan) -> bool {
        let mut found = false;
        for step in plan.steps().iter().map(ground) {
            let why = self.unfit(None, &step);
            if let Some(why) = why.filter(|_| !self.is_forbidden(&step)) {
                self.forbidden.push((step, why));
                found = true;
            }
        }
        found
    }

    /// Looks for a change by repair of the draft, unless that was tried before, then by search.
    fn attempt(
        &self,
        here: &World,
        purpose: &Purpose,
        (draft, tried): (&Plan, bool),
        because: Vec<Noticed>,
    ) -> Attempt {
        let resolved = resolved(here, draft);
        let steps = resolved.steps.len();
        let change = |kind, plan, edits| {
            Attempt::Found(Box::new(Change {
                kind,
                plan: self.in_lanes(here, purpose, plan),
                edits,
                steps,
                because: because.clone(),
            }))
        };
        if steps > 0 && !tried {
            match repair(here, &resolved, purpose) {
                RepairOutcome::Valid(plan) => return change(ChangeKind::Repaired, plan, Vec::new()),
                RepairOutcome::Repaired(repaired) => {
                    return change(ChangeKind::Repaired, repaired.plan, repaired.edits);
                }
                _ => {}
            }
        }
        match solve(here, purpose, &Limits::default()) {
            Outcome::Solved { plan, .. } => match check(here, plan, purpose).into_verified() {
                Ok(plan) => change(ChangeKind::Replanned, plan, Vec::new()),
                Err(_) => Attempt::GaveUp("the plan that was found is not valid in the whole world".to_owned()),
            },
            Outcome::ProvenUnsolvable { .. } => Attempt::NoPlan,
            Outcome::GaveUp { why, .. } => Attempt::GaveUp(why),
        }
    }

    /// Lets the actors work at the same time again if the plan did so.
    fn in_lanes(&self, here: &World, purpose: &Purpose, plan: VerifiedPlan) -> VerifiedPlan {
        if !self.has_lanes {
            return plan;
        }
        match compact(here, &plan, purpose) {
            Some(compacted) => compacted.plan,
            None => plan,
        }
    }
}

/// Returns a plan as a draft for repair; steps of lanes become a sequence.
fn resolved(world: &World, plan: &Plan) -> Resolved {
    let domain = world.domain();
    let has_lanes = plan.body().iter().any(|node| matches!(node, Node::Parallel { .. }));
    let flat = plan
        .body()
        .iter()
        .all(|node| matches!(node, Node::Step(_) | Node::Parallel { .. } | Node::Remark(_)));
    let plan = if has_lanes && flat {
        in_sequence(plan)
    } else {
        plan.clone()
    };
    Resolved {
        steps: plan.steps().iter().map(|step| Some(DraftStep::from(step))).collect(),
        written: plan.steps().iter().map(|step| step.call(world).to_string()).collect(),
        objects: plan.steps().iter().filter_map(|step| step.object(domain)).collect(),
        body: plan.body().to_vec(),
        ..Resolved::default()
    }
}

fn in_sequence(plan: &Plan) -> Plan {
    let steps = plan.body().iter().flat_map(|node| match node {
        Node::Step(step) => vec![*step],
        Node::Parallel { lanes } => lanes::sequence(lanes),
        _ => Vec::new(),
    });
    steps.map(|step| plan.step(step).clone()).collect()
}
