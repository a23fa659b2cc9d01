//! Who does what, where the goal leaves it open.

use super::compact::{Compacted, arranged, compact};
use super::makespan;
use crate::effort;
use crate::model::{Domain, EntityId, Moment, World, holds};
use crate::plan::{Plan, Step};
use crate::verify::{Purpose, VerifiedPlan, apply, check};

/// Plans with more steps than this keep their actors: what is tried grows with the square of the steps.
const LONGEST: usize = 60;

/// Gives stretches of work to other actors as long as that makes the plan shorter in time and no longer in steps.
///
/// A stretch is any number of steps that one actor does in turn, as it picks something up, carries it and puts it
/// down; another actor takes all of it or nothing. What comes out is a plain list of steps again, verified for the same
/// purpose: a hand that the goal names stays. Of equally good choices the first is taken, so the answer is always the
/// same.
pub fn spread(domain: &Domain, world: &World, plan: &VerifiedPlan, purpose: &Purpose) -> VerifiedPlan {
    let spent = effort::within(effort::OPERATION, || spread_within(domain, world, plan, purpose));
    match spent.exhausted {
        true => plan.clone(),
        false => spent.result,
    }
}

fn spread_within(domain: &Domain, world: &World, plan: &VerifiedPlan, purpose: &Purpose) -> VerifiedPlan {
    let mut best = plan.clone();
    if !plan.plan().is_sequence() || plan.steps().len() > LONGEST {
        return best;
    }
    let mut time = time_of(domain, world, best.steps());
    loop {
        let mut better: Option<(u64, VerifiedPlan)> = None;
        for candidate in handed_on(domain, world, best.steps()) {
            let takes = time_of(domain, world, &candidate);
            if takes >= better.as_ref().map_or(time, |(least, _)| *least) {
                continue;
            }
            if let Ok(plan) = check(domain, world, Plan::sequence(candidate), purpose).into_verified() {
                better = Some((takes, plan));
            }
        }
        match better {
            Some((takes, plan)) => (time, best) = (takes, plan),
            None => return best,
        }
    }
}

/// The work of a plan shared out between its actors and done side by side: [`spread`], then [`compact`].
///
/// None if that gains no time.
pub fn share(domain: &Domain, world: &World, plan: &VerifiedPlan, purpose: &Purpose) -> Option<Compacted> {
    compact(domain, world, &spread(domain, world, plan, purpose), purpose)
}

/// How long the steps take when their actors work side by side.
fn time_of(domain: &Domain, world: &World, steps: &[Step]) -> u64 {
    arranged(domain, world, steps).map_or(steps.len() as u64, |plan| makespan(&plan).units())
}

/// The steps with each stretch of one actor's work done by another, where that can be done.
fn handed_on(domain: &Domain, world: &World, steps: &[Step]) -> Vec<Vec<Step>> {
    let mut all = Vec::new();
    for first in 0..steps.len() {
        let Some(actor) = steps[first].actor(domain) else {
            continue;
        };
        for other in others(domain, world, &steps[first], actor) {
            let mut candidate = steps.to_vec();
            for last in first..steps.len() {
                if steps[last].actor(domain) != Some(actor) {
                    continue;
                }
                candidate[last] = done_by(domain, world, &steps[last], other);
                if is_possible(domain, world, &candidate) {
                    all.push(candidate.clone());
                }
            }
        }
    }
    all
}

/// Who else could do the step, by its type.
fn others(domain: &Domain, world: &World, step: &Step, actor: EntityId) -> Vec<EntityId> {
    let action = domain.action(step.action);
    let kinds = action.actor.map(|parameter| action.parameters[parameter].kind);
    let all = kinds.into_iter().flat_map(|kind| world.of_kind(kind));
    all.copied().filter(|other| *other != actor).collect()
}

/// The step done by another actor, with the explanation that the domain gives it.
fn done_by(domain: &Domain, world: &World, step: &Step, actor: EntityId) -> Step {
    let mut arguments = step.arguments.clone();
    if let Some(parameter) = domain.action(step.action).actor {
        arguments[parameter] = actor;
    }
    Step::explained(domain, world, step.action, arguments)
}

fn is_possible(domain: &Domain, world: &World, steps: &[Step]) -> bool {
    let mut state = world.state.clone();
    steps.iter().all(|step| {
        let action = domain.action(step.action);
        let moment = Moment { world, state: &state };
        let possible = holds(moment, &action.precondition, &mut step.arguments.clone());
        apply(world, &mut state, action, &step.arguments);
        possible
    })
}
