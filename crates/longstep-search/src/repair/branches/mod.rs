//! Repair of branching plans.
//!
//! First, the steps after a branch are copied into both of its sides. Then each execution path is a sequential draft
//! that shares a prefix with earlier paths. Each path is repaired on its own, and keeps the steps that earlier paths
//! have settled. Finally, the common end of both sides is moved after the branch again, and the whole plan is verified.
//! So the cost is minimal for each path, but not for all together.

mod draft;
mod path;
mod sensing;
mod settle;
#[cfg(test)]
mod tests;

use draft::Draft;
use path::OutcomeOrder;
use sensing::{behind_sensing, with_outcomes};

use super::{Edit, EditKind, Pins, RepairOutcome, Repaired, repair_within};
use longstep_model::model::{Fact, World};
use longstep_verify::plan::{Plan, Resolved, Step, StepId};
use longstep_verify::verify::{Purpose, VerifiedPlan, bind_tree, binding_claims, check};

/// Maximum number of paths; repair gives up on plans with more.
const WAYS: usize = 64;

pub(super) fn repair_branches(
    limit: usize,
    world: &World,
    resolved: &Resolved,
    purpose: &Purpose,
    pins: &Pins,
) -> RepairOutcome {
    let plan = match bind_tree(world, resolved, purpose.claim.as_ref()) {
        Ok((plan, _)) => plan,
        Err(issues) => {
            let messages: Vec<String> = issues.iter().map(|issue| issue.message(world, &[], None)).collect();
            return RepairOutcome::Unclear {
                why: messages.join("; "),
            };
        }
    };
    let report = match check(world, plan, purpose).into_verified() {
        Ok(plan) => return RepairOutcome::Valid(plan),
        Err(report) => report,
    };
    let mut draft = Draft::of(world, resolved, &report.plan);
    draft.sense(world, &report.violations, pins);
    if !draft.unfold(0) {
        return RepairOutcome::GaveUp {
            why: "the plan has too many branches one after the other".to_owned(),
            expanded: 0,
        };
    }
    let task = BranchTask {
        limit,
        world,
        resolved,
        purpose,
        pins,
    };
    // Later paths must keep the steps that the first path settles. If that fails, another path goes first.
    let first = task.path_by_path(draft.clone(), OutcomeOrder::FirstOutcome);
    match first {
        RepairOutcome::Repaired(_) => first,
        _ => match task.path_by_path(draft, OutcomeOrder::LastOutcome) {
            other @ RepairOutcome::Repaired(_) => other,
            _ => first,
        },
    }
}

/// A branching draft and the constraints of its repair.
struct BranchTask<'a> {
    limit: usize,
    world: &'a World,
    resolved: &'a Resolved,
    purpose: &'a Purpose,
    pins: &'a Pins,
}

impl BranchTask<'_> {
    /// Repairs one path after the other.
    fn path_by_path(&self, mut draft: Draft, order: OutcomeOrder) -> RepairOutcome {
        let world = self.world;
        // The claim describes one ending, but each path has its own.
        let each = Purpose {
            claim: None,
            step_claims: Vec::new(),
            ..self.purpose.clone()
        };
        let (mut decisions, mut expanded, mut cost) = (Vec::new(), 0, 0);
        for _ in 0..WAYS {
            let path = draft.path(world, &decisions, order);
            let observed = with_outcomes(world, &path.outcomes.iter().map(|(_, fact)| *fact).collect::<Vec<_>>());
            let (linear, pins) = draft.linear(self.resolved, &path, self.pins);
            match repair_within(self.limit, &observed, &linear, &each, &pins) {
                RepairOutcome::Valid(plan) => draft.settle(&path, plan.steps(), &[]),
                RepairOutcome::Repaired(repaired) => {
                    expanded += repaired.expanded;
                    cost += repaired.cost;
                    let (steps, edits) = behind_sensing(world, &observed, *repaired, &each, &path.looped, &pins);
                    draft.settle(&path, &steps, &edits);
                }
                other => return other,
            }
            decisions = path.decisions;
            // Decisions count up like digits, so each path shares the longest prefix with the one before it.
            while decisions.last().is_some_and(|(taken, of)| taken + 1 == *of) {
                decisions.pop();
            }
            match decisions.last_mut() {
                Some((taken, _)) => *taken += 1,
                None => {
                    draft.fold(0);
                    return self.whole(&draft, cost, expanded);
                }
            }
        }
        RepairOutcome::GaveUp {
            why: "the plan has too many paths through it".to_owned(),
            expanded,
        }
    }

    /// Returns the repaired plan if it is valid as a whole.
    fn whole(&self, draft: &Draft, cost: u32, expanded: usize) -> RepairOutcome {
        let world = self.world;
        let mut order = Vec::new();
        let body = draft.nodes(0, &mut order);
        let mut steps = Vec::with_capacity(order.len());
        for number in &order {
            let item = &draft.items[*number];
            let mut step = Step::explained(world, item.step.action, item.arguments());
            if !item.step.explanation.is_empty() {
                step.explanation.clone_from(&item.step.explanation);
            }
            steps.push(step);
        }
        let plan = Plan::tree(steps, body);
        let Some((plan, given_up)) = plan.and_then(|plan| self.verified(plan)) else {
            return RepairOutcome::GaveUp {
                why: "each path through the plan could be repaired, and together they are no valid plan".to_owned(),
                expanded,
            };
        };
        RepairOutcome::Repaired(Box::new(Repaired {
            edits: draft.edits(world, self.resolved, &order, &plan),
            plan,
            cost,
            // Each path is repaired at the least cost, but the sum need not be the least.
            cheapest: false,
            given_up,
            expanded,
        }))
    }

    /// Returns the plan if it is valid, with the claims that the ending closest to the claim breaks.
    fn verified(&self, plan: Plan) -> Option<(VerifiedPlan, Vec<Fact>)> {
        let world = self.world;
        let report = match check(world, plan, self.purpose).into_verified() {
            Ok(plan) => return Some((plan, Vec::new())),
            Err(report) => report,
        };
        let claim = self.purpose.claim.as_ref()?;
        let binding = binding_claims(world, &report.plan, claim);
        let broken = report.endings.iter().map(|ending| {
            let broken = binding.iter().filter(|fact| !ending.after.holds(**fact));
            broken.copied().collect::<Vec<Fact>>()
        });
        let given_up = broken.min_by_key(Vec::len)?;
        let purpose = Purpose {
            claim: Some(claim.clone().without(&given_up)),
            ..self.purpose.clone()
        };
        let plan = check(world, report.plan, &purpose).into_verified().ok()?;
        Some((plan, given_up))
    }
}

impl Draft {
    /// Returns the edits, in plan order.
    fn edits(&self, world: &World, resolved: &Resolved, order: &[usize], plan: &VerifiedPlan) -> Vec<Edit> {
        let mut edits: Vec<Edit> = Vec::new();
        for (at, number) in order.iter().enumerate() {
            let item = &self.items[*number];
            let Some((kind, why)) = &item.edit else { continue };
            let step = plan.plan().step(StepId::new(at));
            edits.push(Edit {
                kind: *kind,
                at,
                step: item.from,
                before: (*kind != EditKind::Insert).then(|| resolved.written[item.from].clone()),
                after: Some(step.call(world).to_string()),
                about: world
                    .domain()
                    .action(step.action)
                    .implicit()
                    .next()
                    .map(|_| step.explanation.clone()),
                why: why.clone(),
            });
        }
        for (from, written, why, next) in &self.dropped {
            let at = next.and_then(|next| order.iter().position(|number| *number == next));
            let edit = Edit {
                kind: EditKind::Drop,
                at: at.unwrap_or(order.len()),
                step: *from,
                before: Some(written.clone()),
                after: None,
                about: None,
                why: why.clone(),
            };
            // A step after a branch may have been dropped from both sides.
            if !edits
                .iter()
                .any(|known| known.kind == EditKind::Drop && known.step == *from)
            {
                edits.push(edit);
            }
        }
        edits.sort_by_key(|edit| (edit.at, edit.kind != EditKind::Drop));
        edits
    }
}
