//! Parallel lanes: simulation of every interleaving of their steps.
//!
//! The walk visits each combination of positions in the lanes. Whichever lane goes first, its step must be applicable,
//! and interleavings that reach the same positions must be in the same state. Then the result does not depend on the
//! speed of the lanes.

use std::collections::BTreeMap;

use super::Violation;
use super::path::ExecutionPath;
use super::walk::{STATES, Walk};
use crate::plan::{Lane, LaneItem, StepId};
use longstep_model::effort;
use longstep_model::model::{EntityId, Fact, Fluent, Number, State};

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
                // An actor does not know what another one senses; to act on it, their lanes must end first.
                if !self.domain.action(self.plan.step(step).action).senses.is_empty() {
                    self.wrong(Violation::SensesInLane { step: step.index() }, Vec::new());
                }
            }
        }
    }

    /// Simulates all interleavings of the lanes; returns one path through them for each progress through the stages.
    pub(super) fn side_by_side(&mut self, lanes: &[Lane], path: ExecutionPath) -> Vec<ExecutionPath> {
        let lanes: Vec<Vec<&LaneItem>> = lanes.iter().map(|lane| lane.acts().collect()).collect();
        // Ordered by the number of completed items, so that all paths to a combination arrive before it is expanded.
        let mut open: BTreeMap<(usize, Vec<usize>), Vec<ExecutionPath>> = BTreeMap::new();
        open.insert((0, vec![0; lanes.len()]), vec![path]);
        while let Some(((done, places), paths)) = open.pop_first() {
            let next: Vec<Option<&LaneItem>> = lanes
                .iter()
                .zip(&places)
                .map(|(lane, at)| lane.get(*at).copied())
                .collect();
            if next.iter().all(Option::is_none) || self.is_stopped() {
                return paths;
            }
            effort::spend(lanes.iter().map(Vec::len).sum());
            self.together(&next, &paths[0]);
            let moves = moves(&lanes, &places, &next);
            if moves.is_empty() {
                let waiting = next.iter().flatten().find_map(|item| item.sync());
                let sync = waiting.unwrap_or_default().to_owned();
                self.wrong(Violation::Deadlock { sync }, self.when(&paths[0]));
                return paths;
            }
            for moved in moves {
                let step = next[moved[0]].and_then(LaneItem::step);
                let mut to = places.clone();
                moved.iter().for_each(|lane| to[*lane] += 1);
                let known = open.entry((done + moved.len(), to)).or_default();
                for path in &paths {
                    let mut then = path.clone();
                    if let Some(step) = step {
                        self.step(step, &mut then);
                        self.progress(&mut then);
                    }
                    self.meet(known, then);
                }
            }
        }
        Vec::new()
    }

    /// Adds a path to those that reached the same positions, unless one of them has made equal progress.
    fn meet(&mut self, known: &mut Vec<ExecutionPath>, path: ExecutionPath) {
        let Some(first) = known.first() else {
            return known.push(path);
        };
        self.same_state(first.clone(), &path);
        effort::spend(known.len());
        let is_equal = |known: &ExecutionPath| self.progress_of(known).eq(self.progress_of(&path));
        if known.iter().any(is_equal) {
            return;
        }
        // A path that is neither followed nor refused would be one that nobody has checked.
        if known.len() == STATES {
            let last = self.history.back(path.here).next().map(|(step, _)| step.index());
            self.stop(last, STATES + 1);
            return;
        }
        known.push(path);
    }

    /// Reports objects that concurrent steps share.
    fn together(&mut self, next: &[Option<&LaneItem>], path: &ExecutionPath) {
        let steps: Vec<StepId> = next.iter().flatten().filter_map(|item| item.step()).collect();
        for (number, first) in steps.iter().enumerate() {
            effort::spend(steps.len());
            for second in &steps[number + 1..] {
                for entity in self.shared(*first, *second) {
                    let (step, other) = (first.index(), second.index());
                    self.wrong(Violation::SharedObject { step, other, entity }, self.when(path));
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
    fn same_state(&mut self, mut one: ExecutionPath, other: &ExecutionPath) {
        let mut other = other.clone();
        // Orders of steps may achieve different stages, which is no race.
        self.forget_progress(&mut one);
        self.forget_progress(&mut other);
        if one.state == other.state {
            return;
        }
        let last = |path: &ExecutionPath| self.history.back(path.here).next().map(|(step, _)| step.index());
        let fact = fact_only_in(&one.state, &other.state).or_else(|| fact_only_in(&other.state, &one.state));
        let (Some(step), Some(second)) = (last(&one), last(&other)) else {
            return;
        };
        let (first, second) = (step.min(second), step.max(second));
        if let Some(fluent) = different_number(&one.state, &other.state).filter(|_| fact.is_none()) {
            let violation = Violation::NumberRace {
                step: first,
                other: second,
                fluent,
            };
            return self.wrong(violation, self.when(&one));
        }
        if let Some(fact) = fact {
            let violation = Violation::Race {
                step: first,
                other: second,
                fact,
            };
            self.wrong(violation, self.when(&one));
        }
    }
}

/// Returns the first fact that holds in one state and not in the other one.
fn fact_only_in(one: &State, other: &State) -> Option<Fact> {
    one.iter().find(|fact| !other.holds(*fact))
}

/// Returns the first fluent with different numbers in two states.
fn different_number(one: &State, other: &State) -> Option<Fluent> {
    number_only_in(one, other).or_else(|| number_only_in(other, one))
}

/// Returns the first fluent with a number in one state that it does not have in the other one.
fn number_only_in(one: &State, other: &State) -> Option<Fluent> {
    let differs = |(fluent, number): &&(Fluent, Number)| other.number(*fluent) != Some(*number);
    one.numbers().iter().find(differs).map(|(fluent, _)| *fluent)
}

/// Returns the lanes that can go on from these positions: each lane with a step alone, lanes that meet at a
/// synchronization point together.
fn moves(lanes: &[Vec<&LaneItem>], places: &[usize], next: &[Option<&LaneItem>]) -> Vec<Vec<usize>> {
    let mut moves = Vec::new();
    for (lane, item) in next.iter().enumerate() {
        match item {
            Some(LaneItem::Step(_)) => moves.push(vec![lane]),
            Some(LaneItem::Sync(name)) => {
                let waits = |item: &&LaneItem| matches!(item, LaneItem::Sync(other) if other == name);
                let met: Vec<usize> = (0..lanes.len())
                    .filter(|lane| next[*lane].as_ref().is_some_and(waits))
                    .collect();
                let all = (0..lanes.len()).filter(|lane| lanes[*lane][places[*lane]..].iter().any(waits));
                // The first lane that waits stands for all, so a meeting is one move.
                if met[0] == lane && all.eq(met.iter().copied()) {
                    moves.push(met);
                }
            }
            Some(LaneItem::Remark(_)) | None => {}
        }
    }
    moves
}
