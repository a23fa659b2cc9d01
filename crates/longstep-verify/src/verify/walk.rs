//! Simulation of every execution path of a plan.
//!
//! The walk keeps the set of states that are possible at a node. Sensing splits a state; paths that reach the same
//! state are merged. Loops are followed until no new state occurs.

use std::collections::hash_map::Entry;

use rustc_hash::{FxHashMap, FxHashSet};

use super::finding::{Finding, Findings, joined};
use super::history::{History, with_culprits};
use super::loop_states::{LoopStates, kept_units};
use super::path::{ExecutionPath, cost_of_periods, dearest, sum};
use super::stage_tracker::StageTracker;
use super::{Purpose, StepClaim, Violation, claims, unmet};
use crate::plan::{Node, Plan, StepId, Test, tree};
use longstep_model::effort;
use longstep_model::model::{
    Action, Bindings, ChangedLists, Domain, EntityId, Fact, Moment, Number, PredicateId, State, World, apply_onto,
    broken_bindings, ground, holds, rests_on,
};

/// Maximum number of states at one node; a plan that exceeds it is rejected.
pub const STATES: usize = 4_096;
/// Work units for a step, besides those for its conditions and effects.
const STEP: usize = 16;

/// State of the simulation: findings and scratch space.
pub(super) struct Walk<'a> {
    pub(super) domain: &'a Domain,
    pub(super) world: &'a World,
    pub(super) plan: &'a Plan,
    pub(super) history: History,
    pub(super) rested: FxHashSet<Fact>,
    /// Claims of the steps, sorted by step.
    claims: &'a [StepClaim],
    stages: StageTracker<'a>,
    found: Vec<Finding>,
    sensed: Vec<PredicateId>,
    reached: Vec<bool>,
    /// True if the state limit was exceeded.
    stopped: bool,
    bindings: Bindings,
    fired: Vec<(Fact, bool)>,
}

impl<'a> Walk<'a> {
    pub(super) fn new(world: &'a World, plan: &'a Plan, purpose: &'a Purpose) -> Self {
        let domain = world.domain();
        let sensed = domain.actions.iter().flat_map(|action| &action.senses);
        let mut sensed: Vec<PredicateId> = sensed.map(|atom| atom.predicate).collect();
        sensed.sort_unstable();
        sensed.dedup();
        Self {
            domain,
            world,
            plan,
            history: History::default(),
            rested: FxHashSet::default(),
            claims: &purpose.step_claims,
            stages: StageTracker::new(world, purpose),
            found: Vec::new(),
            sensed,
            reached: vec![false; plan.steps().len()],
            stopped: false,
            bindings: Vec::new(),
            fired: Vec::new(),
        }
    }

    /// Simulates the whole plan; returns the paths that reach its end, at least one.
    pub(super) fn run(&mut self) -> Vec<ExecutionPath> {
        let mut start = ExecutionPath {
            state: self.world.state.clone(),
            here: None,
            broken: self.broken_always(&self.world.state),
            cost: self.domain.has_costs().then_some(Number::ZERO),
        };
        self.progress(&mut start);
        let mut ends = self.nodes(self.plan.body(), vec![start.clone()]);
        if !self.is_stopped() {
            let steps = 0..self.plan.steps().len();
            // One warning for a run of unreached steps.
            let first = |step: &usize| !self.reached[*step] && (*step == 0 || self.reached[*step - 1]);
            for step in steps.filter(first).collect::<Vec<_>>() {
                self.odd(Violation::Unreached { step }, Vec::new());
            }
        }
        // A report has an ending, even if every path is stuck in a loop.
        if ends.is_empty() {
            ends.push(start);
        }
        ends.sort_by_cached_key(|path| self.when(path));
        ends
    }

    /// Returns the sensing outcomes of a path that are still known.
    pub(super) fn when(&self, path: &ExecutionPath) -> Vec<Fact> {
        let known = self
            .sensed
            .iter()
            .flat_map(|predicate| path.state.of_predicate(*predicate));
        known.copied().filter(|fact| !self.world.state.holds(*fact)).collect()
    }

    pub(super) fn wrong(&mut self, violation: Violation, when: Vec<Fact>) {
        self.found.push(Finding {
            violation,
            odd: false,
            when,
        });
    }

    pub(super) fn odd(&mut self, violation: Violation, when: Vec<Fact>) {
        self.found.push(Finding {
            violation,
            odd: true,
            when,
        });
    }

    /// Runs `done` on each path. A finding on all paths no longer depends on sensing outcomes.
    pub(super) fn each<T>(
        &mut self,
        paths: Vec<ExecutionPath>,
        mut done: impl FnMut(&mut Self, ExecutionPath) -> Vec<T>,
    ) -> Vec<T> {
        let (count, from) = (paths.len(), self.found.len());
        let mut all = Vec::with_capacity(count);
        for path in paths {
            let own = self.found.len();
            all.extend(done(self, path));
            // Interleavings of lanes repeat findings; each counts once per path.
            if count > 1 && self.found.len() > own + 1 {
                let together = joined(self.found.split_off(own), None);
                self.found.extend(together);
            }
        }
        if count > 1 && self.found.len() > from {
            let together = joined(self.found.split_off(from), Some(count));
            self.found.extend(together);
        }
        all
    }

    fn nodes(&mut self, nodes: &[Node], mut paths: Vec<ExecutionPath>) -> Vec<ExecutionPath> {
        for node in nodes {
            if self.is_stopped() || paths.is_empty() {
                return paths;
            }
            paths = match node {
                Node::Step(id) => self.steps(*id, paths),
                Node::If {
                    condition,
                    then,
                    otherwise,
                } => {
                    let (yes, no) = self.test(condition, paths, first_of(node));
                    let mut ends = self.nodes(then, yes);
                    ends.extend(self.nodes(otherwise, no));
                    self.merged(ends)
                }
                Node::While { condition, body } => self.repeated(condition, body, paths, first_of(node)),
                Node::Repeat { times, body } => self.counted(*times, body, paths),
                Node::Parallel { lanes } => {
                    self.check_lanes(lanes);
                    let ends = self.each(paths, |walk, path| walk.side_by_side(lanes, path));
                    self.merged(ends)
                }
                Node::Remark(_) => paths,
            };
            if paths.len() > STATES {
                self.stop(first_of(node), paths.len());
            }
            if self.is_stopped() {
                // A single path suffices to report the place.
                paths.truncate(1);
            }
        }
        paths
    }

    /// Stops the simulation because there are too many states.
    pub(super) fn stop(&mut self, step: Option<usize>, states: usize) {
        if !self.stopped {
            self.stopped = true;
            self.wrong(Violation::TooManyStates { step, states }, Vec::new());
        }
    }

    /// Returns true if the simulation stops: too many states, or no budget left.
    pub(super) fn is_stopped(&self) -> bool {
        self.stopped || effort::is_exhausted()
    }

    /// Returns the paths after a loop with a fixed number of iterations.
    ///
    /// The states after an iteration depend only on those before it. Once the states at the start of an iteration
    /// repeat, the loop is periodic, and only the remainder of the last period is simulated.
    fn counted(&mut self, times: u32, body: &[Node], mut paths: Vec<ExecutionPath>) -> Vec<ExecutionPath> {
        let mut rounds: FxHashMap<Vec<ChangedLists>, (u32, Option<Number>)> = FxHashMap::default();
        let (mut round, mut last) = (0, times);
        let mut findings = Findings::from(self.found.len());
        while round < last && !self.is_stopped() {
            // Once the period is known, only its remainder is left, and no state is compared any more.
            if last == times {
                let mut states: Vec<ChangedLists> = paths.iter().map(|path| self.changed(path)).collect();
                states.sort_unstable();
                effort::spend(states.iter().map(kept_units).sum());
                let cost = dearest(&paths);
                if let Some((first, cost_before)) = rounds.insert(states, (round, cost)) {
                    let period = round - first;
                    last = round + (times - round) % period;
                    let left_out = cost_of_periods(cost_before, cost, (times - last) / period);
                    for path in &mut paths {
                        path.cost = sum(path.cost, left_out);
                    }
                    if round == last {
                        break;
                    }
                }
            }
            let ends = self.nodes(body, paths);
            paths = self.merged(ends);
            findings.compact(&mut self.found);
            round += 1;
        }
        paths
    }

    /// Returns the fact lists in which the state of a path differs from the initial state.
    fn changed(&self, path: &ExecutionPath) -> ChangedLists {
        path.state.changed_lists(&self.world.state)
    }

    fn steps(&mut self, id: StepId, paths: Vec<ExecutionPath>) -> Vec<ExecutionPath> {
        let sensing = !self.domain.action(self.plan.step(id).action).senses.is_empty();
        self.each(paths, |walk, mut path| {
            walk.step(id, &mut path);
            let mut paths = if sensing { walk.outcomes(id, path) } else { vec![path] };
            paths.iter_mut().for_each(|path| walk.progress(path));
            paths
        })
    }

    /// Records what the state of a path achieves of the stages.
    pub(super) fn progress(&self, path: &mut ExecutionPath) {
        if !self.stages.is_empty() {
            self.stages.advance(self.world, &mut path.state);
        }
    }

    /// Removes the progress from the state of a path.
    pub(super) fn forget_progress(&self, path: &mut ExecutionPath) {
        self.stages.forget(&mut path.state);
    }

    /// Returns the progress in the state of a path.
    pub(super) fn progress_of<'p>(&self, path: &'p ExecutionPath) -> impl Iterator<Item = Fact> + use<'p> {
        path.state.iter_from(self.domain.predicates.len())
    }

    /// Returns the first goal that a path did not achieve in order, with `true` for one of the first stage.
    pub(super) fn unordered(&self, path: &ExecutionPath) -> Option<(usize, bool)> {
        self.stages.missing(&path.state)
    }

    /// Simulates one step.
    pub(super) fn step(&mut self, id: StepId, path: &mut ExecutionPath) {
        self.reached[id.index()] = true;
        effort::spend(STEP);
        let step = self.plan.step(id);
        let action = self.domain.action(step.action);
        if path.cost.is_some() {
            path.cost = sum(path.cost, self.cost_of(action, &step.arguments));
        }
        self.bindings.clear();
        self.bindings.extend_from_slice(&step.arguments);
        let moment = Moment {
            world: self.world,
            state: &path.state,
        };
        if holds(moment, &action.precondition, &mut self.bindings) {
            let (history, here) = (&self.history, path.here);
            rests_on(
                moment,
                &action.precondition,
                &mut self.bindings,
                // A fact that the plan itself changed is no assumption.
                &|fact| history.touched(here, fact),
                &mut self.rested,
            );
        } else {
            let missing = unmet(self.world, &path.state, &action.precondition, &mut self.bindings);
            let missing = with_culprits(missing, &self.history, path.here);
            let step = id.index();
            self.wrong(Violation::Precondition { step, missing }, self.when(path));
        }
        if let Some(prohibition) = self.world.forbids(step.action, &step.arguments) {
            let (prohibition, says) = (prohibition.written.clone(), prohibition.says.clone());
            let step = id.index();
            self.wrong(
                Violation::Prohibited {
                    step,
                    prohibition,
                    says,
                },
                self.when(path),
            );
        }
        // A copy of the state is costly, and only the events of stages need it.
        let before = self.stages.counts_events().then(|| path.state.clone());
        let (bindings, fired) = (&mut self.bindings, &mut self.fired);
        path.here = self.history.add(id, path.here, |changes| {
            apply_onto(self.world, &mut path.state, action, bindings, fired, changes);
        });
        if let Some(before) = before {
            let stages = &self.stages;
            stages.step(self.world, &before, action, &mut self.bindings, &mut path.state);
        }
        let has_effects = !action.effects.is_empty() || !action.numeric.is_empty();
        if !self.history.has_changed(path.here) && has_effects {
            self.odd(Violation::NoEffect { step: id.index() }, self.when(path));
        }
        for violation in claims::broken(self.claims, id.index(), &path.state) {
            self.odd(violation, self.when(path));
        }
        self.always(id, path);
    }

    /// Returns the cost of a step, which depends on what no step changes.
    fn cost_of(&self, action: &Action, arguments: &[EntityId]) -> Option<Number> {
        let moment = Moment {
            world: self.world,
            state: &self.world.state,
        };
        match &action.cost {
            Some(cost) => cost.value(moment, arguments),
            None => Some(Number::ZERO),
        }
    }

    /// Reports each `always` rule at the step that breaks it. A rule that is broken in the initial state becomes
    /// binding once it holds.
    fn always(&mut self, id: StepId, path: &mut ExecutionPath) {
        let now = self.broken_always(&path.state);
        for (rule, bindings) in now.iter().filter(|broken| !path.broken.contains(broken)) {
            let step = id.index();
            let violation = match self.world.prohibition(*rule) {
                Some(prohibition) => Violation::Prohibited {
                    step,
                    prohibition: prohibition.written.clone(),
                    says: prohibition.says.clone(),
                },
                None => Violation::Rule {
                    step: Some(step),
                    rule: *rule,
                    bindings: bindings.clone(),
                },
            };
            self.wrong(violation, self.when(path));
        }
        path.broken = now;
    }

    /// Returns the `always` rules that are broken in a state, with their bindings.
    fn broken_always(&self, state: &State) -> Vec<(usize, Bindings)> {
        self.world
            .always_rules()
            .flat_map(|(number, rule)| {
                let broken = broken_bindings(rule, self.world, state).into_iter();
                broken.map(move |bindings| (number, bindings))
            })
            .collect()
    }

    /// Splits a path after a sensing step into one path for each outcome, unless the outcome is already known.
    fn outcomes(&mut self, id: StepId, path: ExecutionPath) -> Vec<ExecutionPath> {
        let facts = self.senses(id);
        if facts.iter().any(|fact| path.state.holds(*fact)) {
            return vec![path];
        }
        // The entry of the step is replaced by one for each outcome, with the fact that it reveals.
        let before = self.history.before(path.here);
        let mut paths = Vec::with_capacity(facts.len());
        for fact in facts {
            let mut path = path.clone();
            path.state.set(fact, true);
            let change = super::Change { fact, holds: true };
            path.here = self.history.add(id, before, |changes| changes.facts.push(change));
            // A rule violation that sensing reveals is not caused by the plan.
            path.broken = self.broken_always(&path.state);
            paths.push(path);
        }
        paths
    }

    /// Returns the possible outcomes of a sensing step.
    fn senses(&self, id: StepId) -> Vec<Fact> {
        let step = self.plan.step(id);
        let outcomes = self.domain.action(step.action).senses.iter();
        outcomes.map(|atom| ground(atom, &step.arguments)).collect()
    }

    /// Splits paths into those on which a condition holds and those on which it does not. `before` is the step that
    /// findings name.
    ///
    /// Within a condition, paths with equal states are merged and limited, as between nodes.
    fn test(
        &mut self,
        condition: &Test,
        paths: Vec<ExecutionPath>,
        before: Option<usize>,
    ) -> (Vec<ExecutionPath>, Vec<ExecutionPath>) {
        match condition {
            Test::Sense(id) => {
                let paths = self.steps(*id, paths);
                // The test of a sensing step is true for its first outcome.
                let first = self.senses(*id).first().copied();
                paths
                    .into_iter()
                    .partition(|path| first.is_some_and(|fact| path.state.holds(fact)))
            }
            Test::Holds(fact) => {
                effort::spend(paths.len());
                let parts = self.each(paths, |walk, path| walk.value(*fact, path, before));
                let (yes, no): (Vec<_>, Vec<_>) = parts.into_iter().partition(|(_, holds)| *holds);
                let paths = |parts: Vec<(ExecutionPath, bool)>| parts.into_iter().map(|(path, _)| path).collect();
                (paths(yes), paths(no))
            }
            Test::Not(inner) => {
                let (yes, no) = self.test(inner, paths, before);
                (no, yes)
            }
            Test::All(parts) => {
                let (mut yes, mut no) = (paths, Vec::new());
                for part in parts {
                    let (holds, fails) = self.test(part, yes, before);
                    no.extend(fails);
                    (yes, no) = (self.counted_paths(holds, before), self.counted_paths(no, before));
                }
                (yes, no)
            }
            Test::Any(parts) => {
                let (mut yes, mut no) = (Vec::new(), paths);
                for part in parts {
                    let (holds, fails) = self.test(part, no, before);
                    yes.extend(holds);
                    (yes, no) = (self.counted_paths(yes, before), self.counted_paths(fails, before));
                }
                (yes, no)
            }
        }
    }

    /// Merges paths within a condition; stops if there are too many.
    fn counted_paths(&mut self, paths: Vec<ExecutionPath>, before: Option<usize>) -> Vec<ExecutionPath> {
        let mut paths = self.merged(paths);
        if paths.len() > STATES {
            self.stop(before, paths.len());
            paths.truncate(1);
        }
        paths
    }

    /// Evaluates a fact on a path. A fact of unknown value splits the path.
    fn value(&mut self, fact: Fact, path: ExecutionPath, before: Option<usize>) -> Vec<(ExecutionPath, bool)> {
        if path.state.holds(fact) {
            return vec![(path, true)];
        }
        let outcomes = self.domain.outcomes(fact);
        let known = outcomes.is_empty() || outcomes.iter().any(|outcome| path.state.holds(*outcome));
        if known {
            return vec![(path, false)];
        }
        // Both values are followed, so that errors on either side are found too.
        let step = before;
        self.wrong(Violation::Unsensed { step, fact }, self.when(&path));
        vec![(path.clone(), true), (path, false)]
    }

    /// Returns the paths after a loop with a condition.
    fn repeated(
        &mut self,
        condition: &Test,
        body: &[Node],
        paths: Vec<ExecutionPath>,
        before: Option<usize>,
    ) -> Vec<ExecutionPath> {
        let start = &self.world.state;
        let mut heads = LoopStates::default();
        for path in paths {
            // The number of iterations is not known.
            heads.meet(ExecutionPath { cost: None, ..path }, start);
        }
        let mut out = Vec::new();
        let mut findings = Findings::from(self.found.len());
        while let Some((number, path)) = heads.next() {
            let (yes, no) = self.test(condition, vec![path], before);
            heads.leaves[number] = !no.is_empty();
            out.extend(no);
            // Iterations repeat exits, so they are merged as they come.
            out = self.counted_paths(out, before);
            let ends = self.nodes(body, yes);
            effort::spend(ends.len());
            for end in ends {
                let next = heads.meet(end, start);
                heads.follows.push((number, next));
            }
            if heads.paths.len() > STATES {
                self.stop(before, heads.paths.len());
            }
            if self.is_stopped() {
                return self.merged(out);
            }
            findings.compact(&mut self.found);
        }
        // As in strong cyclic planning (Cimatti and others, 2003), an exit must be reachable from every state. Then the
        // loop ends if every outcome of sensing occurs at some time.
        if let Some(stuck) = heads.endless() {
            let when = self.when(&heads.paths[stuck]);
            self.wrong(Violation::EndlessLoop { step: before }, when);
        }
        self.merged(out)
    }

    /// Keeps the first path for each state.
    fn merged(&self, paths: Vec<ExecutionPath>) -> Vec<ExecutionPath> {
        if paths.len() < 2 {
            return paths;
        }
        // The rest of a path depends on its state alone, so one path for each state is enough.
        let mut places: FxHashMap<ChangedLists, usize> = FxHashMap::default();
        let mut kept: Vec<ExecutionPath> = Vec::new();
        for path in paths {
            let changed = self.changed(&path);
            // Lists are compared with the initial state's, hashed and stored.
            effort::spend(4 + self.world.domain().predicates.len() + kept_units(&changed) / 2);
            match places.entry(changed) {
                Entry::Occupied(place) => {
                    let known = &mut kept[*place.get()];
                    known.cost = known.cost.zip(path.cost).map(|(one, other)| one.max(other));
                }
                Entry::Vacant(place) => {
                    place.insert(kept.len());
                    kept.push(path);
                }
            }
        }
        kept
    }

    /// Returns the distinct violations and warnings.
    pub(super) fn findings(self) -> (Vec<Violation>, Vec<Violation>) {
        let (odd, wrong): (Vec<_>, Vec<_>) = joined(self.found, None).into_iter().partition(|found| found.odd);
        let violations = [wrong, odd].map(|found| {
            let found = found.into_iter();
            found.map(|found| found.violation.when(found.when)).collect()
        });
        violations.into()
    }
}

/// Returns the first step in a node, from 0; none if it has no steps.
fn first_of(node: &Node) -> Option<usize> {
    tree::steps(std::slice::from_ref(node)).next().map(StepId::index)
}
