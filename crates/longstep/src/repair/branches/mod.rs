//! Repair of a plan that branches.
//!
//! The steps behind a branch are first written into both of its sides. Then every way through the plan is a plain list
//! of steps that begins like the ones before it: each is repaired like any other draft, and what earlier ways settled
//! is kept. What both sides of a branch end with stands behind it again afterwards, and the whole is verified as one
//! plan. So every way is mended at the least cost, but not all of them together.

mod draft;
mod sensing;
mod settle;
#[cfg(test)]
mod tests;
mod way;

use draft::Draft;
use sensing::{behind_sensing, with_outcomes};
use way::Order;

use super::{Edit, EditKind, Outcome, Repaired, repair_within};
use crate::domain::Domain;
use crate::plan::{Plan, Resolved, Step, StepId};
use crate::verify::{Purpose, bind_tree, check};
use crate::world::World;

/// Ways through a plan that are repaired; a plan with more is given up.
const WAYS: usize = 64;

pub(super) fn repair_branches(
    limit: usize,
    domain: &Domain,
    world: &World,
    resolved: &Resolved,
    purpose: &Purpose,
) -> Outcome {
    let gave_up = |why: &str| Outcome::GaveUp {
        why: why.to_owned(),
        expanded: 0,
    };
    let Some((plan, _)) = bind_tree(domain, world, resolved, purpose.claim.as_ref()) else {
        return Outcome::Unclear {
            why: "its words mean nothing here, and which way of the plan they are on is not clear".to_owned(),
        };
    };
    let report = match check(domain, world, plan, purpose).into_verified() {
        Ok(plan) => return Outcome::Valid(plan),
        Err(report) => report,
    };
    let mut draft = Draft::of(domain, world, resolved, &report.plan);
    draft.sense(domain, world, &report.violations);
    if !draft.unfold(0) {
        return gave_up("the plan has too many branches one after the other");
    }
    // What the first way settles, the others have to live with: if they cannot, another one goes first.
    let first = way_by_way(
        limit,
        domain,
        world,
        resolved,
        purpose,
        draft.clone(),
        Order::FirstOutcome,
    );
    match first {
        Outcome::Repaired(_) => first,
        _ => match way_by_way(limit, domain, world, resolved, purpose, draft, Order::LastOutcome) {
            other @ Outcome::Repaired(_) => other,
            _ => first,
        },
    }
}

/// Repairs one way after the other.
fn way_by_way(
    limit: usize,
    domain: &Domain,
    world: &World,
    resolved: &Resolved,
    purpose: &Purpose,
    mut draft: Draft,
    order: Order,
) -> Outcome {
    // What the draft claims is the world of one ending; each way has its own.
    let each = Purpose {
        claim: None,
        step_claims: Vec::new(),
        ..purpose.clone()
    };
    let (mut decisions, mut expanded, mut cost) = (Vec::new(), 0, 0);
    for _ in 0..WAYS {
        let way = draft.way(domain, world, &decisions, order);
        let told = with_outcomes(domain, &way.told.iter().map(|(_, fact)| *fact).collect::<Vec<_>>());
        let (linear, pins) = draft.linear(resolved, &way);
        match repair_within(limit, &told, world, &linear, &each, &pins) {
            Outcome::Valid(plan) => draft.settle(&way, plan.steps(), &[]),
            Outcome::Repaired(repaired) => {
                expanded += repaired.expanded;
                cost += repaired.cost;
                let (steps, edits) = behind_sensing(domain, &told, world, *repaired, &each, &way.looped);
                draft.settle(&way, &steps, &edits);
            }
            other => return other,
        }
        decisions = way.decisions;
        while decisions.last().is_some_and(|(taken, of)| taken + 1 == *of) {
            decisions.pop();
        }
        match decisions.last_mut() {
            Some((taken, _)) => *taken += 1,
            None => {
                draft.fold(0);
                return draft.whole(domain, world, resolved, purpose, cost, expanded);
            }
        }
    }
    Outcome::GaveUp {
        why: "the plan has too many ways through it".to_owned(),
        expanded,
    }
}

impl Draft {
    /// The repaired plan, if it is valid as a whole.
    fn whole(
        &self,
        domain: &Domain,
        world: &World,
        resolved: &Resolved,
        purpose: &Purpose,
        cost: u32,
        expanded: usize,
    ) -> Outcome {
        let mut order = Vec::new();
        let body = self.nodes(0, &mut order);
        let step = |number: &usize| {
            let draft = &self.items[*number].step;
            let arguments = draft.arguments.iter().flatten().copied().collect();
            let mut step = Step::explained(domain, world, draft.action, arguments);
            if !draft.explanation.is_empty() {
                step.explanation.clone_from(&draft.explanation);
            }
            step
        };
        let plan = Plan::tree(order.iter().map(step).collect(), body);
        let verified = plan.and_then(|plan| check(domain, world, plan, purpose).into_verified().ok());
        let Some(plan) = verified else {
            return Outcome::GaveUp {
                why: "each way through the plan could be repaired, and together they are no valid plan".to_owned(),
                expanded,
            };
        };
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
                after: Some(step.call(domain, world).to_string()),
                about: domain
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
            // A step behind a branch was left out of both of its sides.
            if !edits
                .iter()
                .any(|known| known.kind == EditKind::Drop && known.step == *from)
            {
                edits.push(edit);
            }
        }
        edits.sort_by_key(|edit| (edit.at, edit.kind != EditKind::Drop));
        Outcome::Repaired(Box::new(Repaired {
            plan,
            edits,
            cost,
            cheapest: false,
            given_up: Vec::new(),
            expanded,
        }))
    }
}
