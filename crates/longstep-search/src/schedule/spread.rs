//! Assignment of steps to actors, where the goal leaves it open.

use super::compact::{Compacted, arranged, compact};
use super::makespan;
use longstep_model::effort;
use longstep_model::model::{EntityId, Moment, World, holds};
use longstep_verify::plan::{Plan, Step};
use longstep_verify::verify::{Purpose, VerifiedPlan, apply, check};

/// The maximal number of steps; the number of candidates grows with its square.
const LONGEST: usize = 60;

/// Assigns stretches of work to other actors as long as that shortens the makespan without additional steps.
///
/// A stretch is a number of consecutive steps of one actor, for example to pick up, carry and put down an object; it is
/// reassigned as a whole. The result is a sequence of steps again, verified for the same purpose, so an actor that the
/// goal names stays. Among equal candidates the first is chosen, so the result is deterministic. A plan that is not a
/// sequence is returned unchanged, as it is when the budget is exhausted.
pub fn spread(world: &World, plan: &VerifiedPlan, purpose: &Purpose) -> VerifiedPlan {
    let spent = effort::within(effort::OPERATION, || spread_within(world, plan, purpose));
    if spent.exhausted { plan.clone() } else { spent.result }
}

fn spread_within(world: &World, plan: &VerifiedPlan, purpose: &Purpose) -> VerifiedPlan {
    let mut best = plan.clone();
    if !plan.plan().is_sequence() || plan.steps().len() > LONGEST {
        return best;
    }
    let mut time = time_of(world, best.steps());
    // Steepest descent: the makespan falls in each round, so the loop ends.
    loop {
        let mut better: Option<(u64, VerifiedPlan)> = None;
        for candidate in handed_on(world, best.steps()) {
            let takes = time_of(world, &candidate);
            // Verification takes longer than a timetable, so only candidates that gain time get it.
            if takes >= better.as_ref().map_or(time, |(least, _)| *least) {
                continue;
            }
            if let Ok(plan) = check(world, Plan::sequence(candidate), purpose).into_verified() {
                better = Some((takes, plan));
            }
        }
        match better {
            Some((takes, plan)) => (time, best) = (takes, plan),
            None => return best,
        }
    }
}

/// Assigns the steps of a plan to its actors and runs them in parallel: [`spread`], then [`compact`].
///
/// None if that gains no time.
pub fn share(world: &World, plan: &VerifiedPlan, purpose: &Purpose) -> Option<Compacted> {
    compact(world, &spread(world, plan, purpose), purpose)
}

/// Returns the makespan of the steps with parallel actors.
fn time_of(world: &World, steps: &[Step]) -> u64 {
    arranged(world, steps).map_or(steps.len() as u64, |plan| makespan(&plan).units())
}

/// Returns the plans in which a stretch of one actor's work is done by another, as far as they are executable.
fn handed_on(world: &World, steps: &[Step]) -> Vec<Vec<Step>> {
    let domain = world.domain();
    let mut all = Vec::new();
    for first in 0..steps.len() {
        let Some(actor) = steps[first].actor(domain) else {
            continue;
        };
        for other in others(world, &steps[first], actor) {
            // A part of the work on an object cannot change hands alone, so stretches of every length are tried.
            let mut candidate = steps.to_vec();
            for last in first..steps.len() {
                if steps[last].actor(domain) != Some(actor) {
                    continue;
                }
                candidate[last] = done_by(world, &steps[last], other);
                if is_possible(world, &candidate) {
                    all.push(candidate.clone());
                }
            }
        }
    }
    all
}

/// Returns the other actors with the right type for the step.
fn others(world: &World, step: &Step, actor: EntityId) -> Vec<EntityId> {
    let action = world.domain().action(step.action);
    let kinds = action.actor.map(|parameter| action.parameters[parameter].kind);
    let all = kinds.into_iter().flat_map(|kind| world.of_kind(kind));
    all.copied().filter(|other| *other != actor).collect()
}

/// Returns the step with another actor and the domain's explanation.
fn done_by(world: &World, step: &Step, actor: EntityId) -> Step {
    let mut arguments = step.arguments.clone();
    if let Some(parameter) = world.domain().action(step.action).actor {
        arguments[parameter] = actor;
    }
    Step::explained(world, step.action, arguments)
}

fn is_possible(world: &World, steps: &[Step]) -> bool {
    let mut state = world.state.clone();
    steps.iter().all(|step| {
        let action = world.domain().action(step.action);
        let moment = Moment { world, state: &state };
        let possible = holds(moment, &action.precondition, &mut step.arguments.clone());
        apply(world, &mut state, action, &step.arguments);
        possible
    })
}
