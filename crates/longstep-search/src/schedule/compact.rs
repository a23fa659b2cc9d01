//! Compaction: from a sequence of steps to parallel lanes.

use std::collections::BTreeMap;

use super::footprint::{Contended, Footprint, Grounded};
use super::{Makespan, actors, makespan};
use longstep_model::effort;
use longstep_model::model::{Domain, EntityId, State, World};
use longstep_verify::plan::{Lane, LaneItem, Node, Plan, Step, StepId};
use longstep_verify::verify::{Purpose, VerifiedPlan, apply, check};

/// A plan with parallel lanes.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Compacted {
    /// The plan.
    pub plan: VerifiedPlan,
    /// The makespan as a sequence.
    pub before: Makespan,
    /// The makespan with lanes.
    pub after: Makespan,
}

/// Runs the actors of a sequence of steps in parallel, each step as early as possible: after the earlier steps of its
/// actor, and after every earlier step from which it is not independent. Where it waits for another lane, both lanes
/// get a synchronisation point. A step without a single actor separates the steps before it from those after it.
///
/// None if the plan is not a sequence, has only one actor, gains no time, or would have another final state: the result
/// is verified in all interleavings of the lanes.
pub fn compact(world: &World, plan: &VerifiedPlan, purpose: &Purpose) -> Option<Compacted> {
    let spent = effort::within(effort::OPERATION, || compact_within(world, plan, purpose));
    spent.result.filter(|_| !spent.exhausted)
}

fn compact_within(world: &World, plan: &VerifiedPlan, purpose: &Purpose) -> Option<Compacted> {
    if !plan.plan().is_sequence() {
        return None;
    }
    let (before, tree) = (makespan(plan.plan()), arranged(world, plan.steps())?);
    let after = makespan(&tree);
    if after.units() >= before.units() {
        return None;
    }
    let compacted = check(world, tree, purpose).into_verified().ok()?;
    let same_end = compacted
        .endings()
        .iter()
        .all(|ending| ending.after == plan.ending().after);
    same_end.then_some(Compacted {
        plan: compacted,
        before,
        after,
    })
}

/// Arranges the steps as lanes; none if there are fewer than two actors.
pub(super) fn arranged(world: &World, steps: &[Step]) -> Option<Plan> {
    let domain = world.domain();
    if actors(domain, steps).len() < 2 {
        return None;
    }
    let prints = footprints(world, steps);
    let mut tree = Tree::default();
    let mut from = 0;
    for to in 0..=steps.len() {
        let together = steps.get(to).filter(|step| step.actor(domain).is_none());
        if to == steps.len() || together.is_some() {
            tree.side_by_side(&timed(domain, &steps[from..to], &prints[from..to]));
            together.into_iter().for_each(|step| tree.one(step));
            from = to + 1;
        }
    }
    Plan::tree(tree.steps, tree.body)
}

/// A step of one actor with its earliest start time.
struct Timed<'a> {
    step: &'a Step,
    actor: EntityId,
    start: usize,
    /// The latest end among the steps for which this one waits, by the actor of their lane.
    awaits: BTreeMap<EntityId, usize>,
}

/// Computes the earliest start time of each step.
fn timed<'a>(domain: &Domain, steps: &'a [Step], prints: &[Footprint]) -> Vec<Timed<'a>> {
    let mut timed: Vec<Timed<'a>> = Vec::with_capacity(steps.len());
    for (step, own) in steps.iter().zip(prints) {
        let Some(actor) = step.actor(domain) else { continue };
        let (mut start, mut awaits) = (0, BTreeMap::new());
        // With given predecessors, the earliest start of each step gives the least makespan.
        for (before, print) in timed.iter().zip(prints) {
            let end = before.start + 1;
            effort::spend(1);
            if before.actor == actor {
                start = start.max(end);
            } else if print.is_needed_before(own) {
                start = start.max(end);
                let last = awaits.entry(before.actor).or_insert(end);
                *last = end.max(*last);
            }
        }
        timed.push(Timed {
            step,
            actor,
            start,
            awaits,
        });
    }
    timed
}

/// Returns the footprint of each step in the state in which it is executed.
fn footprints(world: &World, steps: &[Step]) -> Vec<Footprint> {
    let domain = world.domain();
    let mut state: State = world.state.clone();
    let mut grounded = Vec::with_capacity(steps.len());
    for step in steps {
        grounded.push(Grounded::of(world, &state, step));
        apply(world, &mut state, domain.action(step.action), &step.arguments);
    }
    let writers: Vec<Option<EntityId>> = steps.iter().map(|step| step.actor(domain)).collect();
    let mut written: Vec<(Option<EntityId>, Contended)> = Vec::new();
    for (writer, step) in writers.iter().zip(&grounded) {
        match written.iter_mut().find(|(actor, _)| actor == writer) {
            Some((_, all)) => all.extend(step.contends()),
            None => written.push((*writer, step.contends().collect())),
        }
    }
    let footprint = |(actor, step): (&Option<EntityId>, &Grounded)| {
        let others = written.iter().filter(|(writer, _)| writer != actor);
        step.footprint(&others.flat_map(|(_, values)| values).copied().collect())
    };
    writers.iter().zip(&grounded).map(footprint).collect()
}

/// A plan under construction.
#[derive(Default)]
struct Tree {
    steps: Vec<Step>,
    body: Vec<Node>,
    /// The number of synchronisation points.
    syncs: usize,
}

impl Tree {
    fn add(&mut self, step: &Step) -> StepId {
        self.steps.push(step.clone());
        StepId::new(self.steps.len() - 1)
    }

    fn one(&mut self, step: &Step) {
        let step = self.add(step);
        self.body.push(Node::Step(step));
    }

    /// Adds steps with one actor each as lanes, or as a sequence if nothing overlaps.
    fn side_by_side(&mut self, timed: &[Timed<'_>]) {
        let mut actors: Vec<EntityId> = timed.iter().map(|timed| timed.actor).collect();
        actors.sort_unstable();
        actors.dedup();
        // Without overlap, a sequence is equivalent.
        let end = timed.iter().map(|timed| timed.start + 1).max();
        if end.is_none_or(|end| end == timed.len()) {
            timed.iter().for_each(|timed| self.one(timed.step));
            return;
        }
        let meetings = meetings(timed);
        let name = |at: usize| format!("sync {}", self.syncs + at + 1);
        let names: Vec<String> = (0..meetings.len()).map(name).collect();
        self.syncs += meetings.len();
        let mut lanes = Vec::with_capacity(actors.len());
        for actor in actors {
            let mut own = meetings
                .iter()
                .zip(&names)
                .filter(|(met, _)| met.lanes.contains(&actor))
                .peekable();
            let mut items = Vec::new();
            for timed in timed.iter().filter(|timed| timed.actor == actor) {
                while let Some((_, name)) = own.next_if(|(met, _)| met.time <= timed.start) {
                    items.push(LaneItem::Sync(name.clone()));
                }
                items.push(LaneItem::Step(self.add(timed.step)));
            }
            items.extend(own.map(|(_, name)| LaneItem::Sync(name.clone())));
            lanes.push(Lane { actor, items });
        }
        self.body.push(Node::Parallel { lanes });
    }
}

/// A time at which lanes wait for each other.
struct Meeting {
    time: usize,
    lanes: Vec<EntityId>,
}

/// Returns the fewest synchronisation points that keep every step after those for which it waits, in order of time.
fn meetings(timed: &[Timed<'_>]) -> Vec<Meeting> {
    let mut by_start: Vec<&Timed<'_>> = timed.iter().collect();
    // A wait is an interval of times. Points at the right ends, taken from left to right, cover all intervals with
    // the fewest points.
    by_start.sort_by_key(|timed| timed.start);
    let mut meetings: Vec<Meeting> = Vec::new();
    for timed in by_start {
        for (other, end) in &timed.awaits {
            let between = |met: &Meeting| (*end..=timed.start).contains(&met.time);
            let both = |met: &Meeting| met.lanes.contains(&timed.actor) && met.lanes.contains(other);
            if meetings.iter().any(|met| between(met) && both(met)) {
                continue;
            }
            let lanes = [timed.actor, *other];
            match meetings.last_mut().filter(|met| met.time == timed.start) {
                Some(met) => met.lanes.extend(lanes),
                None => meetings.push(Meeting {
                    time: timed.start,
                    lanes: lanes.to_vec(),
                }),
            }
        }
    }
    meetings
}
