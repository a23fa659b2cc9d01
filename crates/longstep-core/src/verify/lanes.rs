//! Parallel lanes: simulation of every interleaving of their steps.
//!
//! The walk visits each combination of positions in the lanes. Whichever lane goes first, its step must be applicable,
//! and interleavings that reach the same positions must be in the same state. Then the result does not depend on the
//! speed of the lanes.

use std::collections::BTreeMap;

use super::Violation;
use super::walk::{Walk, Way};
use crate::effort;
use crate::model::EntityId;
use crate::plan::{Lane, LaneItem, StepId};

impl Walk<'_> {
    /// Checks lanes without simulation: each lane has its own actor, who executes all its steps, and no step senses.
    pub(super) fn check_lanes(&mut self, lanes: &[Lane]) {
        for (number, lane) in lanes.iter().enumerate() {
            if lanes[..number].iter().any(|other| other.actor == lane.actor) {
                self.wrong(Violation::LaneTwice { actor: lane.actor }, Vec::new());
            }
            for step in lane.steps() {
                if self.plan.step(step).actor(self.domain) != Some(lane.actor) {
                    let (step, actor) = (step.index(), lane.actor);
                    self.wrong(Violation::WrongActor { step, actor }, Vec::new());
                }
                if !self.domain.action(self.plan.step(step).action).senses.is_empty() {
                    self.wrong(Violation::SensesInLane { step: step.index() }, Vec::new());
                }
            }
        }
    }

    /// Simulates all interleavings of the lanes; returns one path through them.
    pub(super) fn side_by_side(&mut self, lanes: &[Lane], way: Way) -> Way {
        let lanes: Vec<Vec<&LaneItem>> = lanes.iter().map(|lane| lane.acts().collect()).collect();
        // Ordered by the number of completed items, so that all paths to a combination arrive before it is expanded.
        let mut open: BTreeMap<(usize, Vec<usize>), Way> = BTreeMap::new();
        let mut last = way.clone();
        open.insert((0, vec![0; lanes.len()]), way);
        while let Some(((done, places), way)) = open.pop_first() {
            last = way.clone();
            let next: Vec<Option<&LaneItem>> = lanes
                .iter()
                .zip(&places)
                .map(|(lane, at)| lane.get(*at).copied())
                .collect();
            if next.iter().all(Option::is_none) || self.is_stopped() {
                break;
            }
            effort::spend(lanes.iter().map(Vec::len).sum());
            self.together(&next, &way);
            let mut moves: Vec<(Vec<usize>, Way)> = Vec::new();
            for (lane, item) in next.iter().enumerate() {
                match item {
                    Some(LaneItem::Step(step)) => {
                        let mut then = way.clone();
                        self.step(*step, &mut then);
                        moves.push((vec![lane], then));
                    }
                    Some(LaneItem::Sync(name)) => {
                        let waits = |item: &&LaneItem| matches!(item, LaneItem::Sync(other) if other == name);
                        let met: Vec<usize> = (0..lanes.len())
                            .filter(|lane| next[*lane].as_ref().is_some_and(waits))
                            .collect();
                        let all = (0..lanes.len()).filter(|lane| lanes[*lane][places[*lane]..].iter().any(waits));
                        if met[0] == lane && all.eq(met.iter().copied()) {
                            moves.push((met, way.clone()));
                        }
                    }
                    Some(LaneItem::Remark(_)) | None => {}
                }
            }
            if moves.is_empty() {
                let waiting = next.iter().flatten().find_map(|item| item.sync());
                self.wrong(
                    Violation::Deadlock {
                        sync: waiting.unwrap_or_default().to_owned(),
                    },
                    self.when(&way),
                );
                break;
            }
            for (moved, then) in moves {
                let mut to = places.clone();
                moved.iter().for_each(|lane| to[*lane] += 1);
                let key = (done + moved.len(), to);
                match open.get(&key) {
                    Some(other) => self.same_state(other.clone(), &then),
                    None => {
                        open.insert(key, then);
                    }
                }
            }
        }
        last
    }

    /// Reports objects that concurrent steps share.
    fn together(&mut self, next: &[Option<&LaneItem>], way: &Way) {
        let steps: Vec<StepId> = next.iter().flatten().filter_map(|item| item.step()).collect();
        for (number, first) in steps.iter().enumerate() {
            effort::spend(steps.len());
            for second in &steps[number + 1..] {
                for entity in self.shared(*first, *second) {
                    let (step, other) = (first.index(), second.index());
                    self.wrong(Violation::SharedObject { step, other, entity }, self.when(way));
                }
            }
        }
    }

    fn shared(&self, first: StepId, second: StepId) -> Vec<EntityId> {
        let others = &self.plan.step(second).arguments;
        let mut shared = self.plan.step(first).arguments.clone();
        shared
            .retain(|entity| others.contains(entity) && self.world.is_of_kind(*entity, self.domain.environment.object));
        shared.sort_unstable();
        shared.dedup();
        shared
    }

    /// Reports a race if two interleavings lead to different states.
    fn same_state(&mut self, one: Way, other: &Way) {
        if one.state == other.state {
            return;
        }
        let last = |way: &Way| self.history.back(way.here).next().map(|(step, _)| step.index());
        let differs = |one: &Way, other: &Way| one.state.iter().find(|fact| !other.state.holds(*fact));
        let fact = differs(&one, other).or_else(|| differs(other, &one));
        if let (Some(step), Some(second), Some(fact)) = (last(&one), last(other), fact) {
            let violation = Violation::Race {
                step: step.min(second),
                other: step.max(second),
                fact,
            };
            self.wrong(violation, self.when(&one));
        }
    }
}
