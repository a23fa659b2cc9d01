//! Every way through a plan.
//!
//! The walk carries all states in which a way can be at a node. Sensing splits a state, and ways that come to the same
//! state are one from there on. Loops are followed until no new state comes up.

use rustc_hash::{FxHashMap, FxHashSet};

use super::history::{Here, History, with_culprits};
use super::{StepClaim, Violation, claims, unmet};
use crate::effort;
use crate::model::{
    Bindings, ChangedLists, Domain, Fact, Moment, PredicateId, RuleTime, State, World, apply_onto, broken_bindings,
    ground, holds, rests_on,
};
use crate::plan::{Node, Plan, StepId, Test, tree};

/// States that a plan may be in at one node; a plan that can be in more is refused rather than followed.
pub const STATES: usize = 4_096;
/// Units of effort that are charged for a step, besides what its conditions and effects take.
const STEP: usize = 16;

/// One way through a plan, as far as it has come.
#[derive(Debug, Clone)]
pub(super) struct Way {
    pub(super) state: State,
    pub(super) here: Here,
    /// The `always` rules that are broken in the state, so that each is reported where it begins to be. A function of the
    /// state, so ways with the same state are the same.
    broken: Vec<(usize, Bindings)>,
}

/// What is wrong or odd on one or more ways.
#[derive(Debug, Clone)]
struct Found {
    violation: Violation,
    /// Whether it is only odd.
    odd: bool,
    /// What sensing told on the ways where it is so; nothing if it is so on all of them.
    when: Vec<Fact>,
}

/// What is found on the way, and room to work in.
pub(super) struct Walk<'a> {
    pub(super) domain: &'a Domain,
    pub(super) world: &'a World,
    pub(super) plan: &'a Plan,
    pub(super) history: History,
    pub(super) rested: FxHashSet<Fact>,
    /// What the steps claim, in their order.
    claims: &'a [StepClaim],
    found: Vec<Found>,
    sensed: Vec<PredicateId>,
    reached: Vec<bool>,
    /// Whether there were too many states to go on.
    stopped: bool,
    bindings: Bindings,
    fired: Vec<(Fact, bool)>,
}

impl<'a> Walk<'a> {
    pub(super) fn new(domain: &'a Domain, world: &'a World, plan: &'a Plan, claims: &'a [StepClaim]) -> Self {
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
            claims,
            found: Vec::new(),
            sensed,
            reached: vec![false; plan.steps().len()],
            stopped: false,
            bindings: Vec::new(),
            fired: Vec::new(),
        }
    }

    /// Follows the whole plan; returns the ways that come to its end, of which there is at least one.
    pub(super) fn run(&mut self) -> Vec<Way> {
        let start = Way {
            state: self.world.state.clone(),
            here: None,
            broken: self.broken_always(&self.world.state),
        };
        let mut ends = self.nodes(self.plan.body(), vec![start.clone()]);
        if !self.is_stopped() {
            let steps = 0..self.plan.steps().len();
            let first = |step: &usize| !self.reached[*step] && (*step == 0 || self.reached[*step - 1]);
            for step in steps.filter(first).collect::<Vec<_>>() {
                self.odd(Violation::Unreached { step }, Vec::new());
            }
        }
        if ends.is_empty() {
            ends.push(start);
        }
        ends.sort_by_cached_key(|way| self.when(way));
        ends
    }

    /// What sensing told on a way, as far as it is known still.
    pub(super) fn when(&self, way: &Way) -> Vec<Fact> {
        let known = self
            .sensed
            .iter()
            .flat_map(|predicate| way.state.of_predicate(*predicate));
        known.copied().filter(|fact| !self.world.state.holds(*fact)).collect()
    }

    pub(super) fn wrong(&mut self, violation: Violation, when: Vec<Fact>) {
        self.found.push(Found {
            violation,
            odd: false,
            when,
        });
    }

    pub(super) fn odd(&mut self, violation: Violation, when: Vec<Fact>) {
        self.found.push(Found {
            violation,
            odd: true,
            when,
        });
    }

    /// Does something with each way; what is found on all of them is found whatever sensing told.
    pub(super) fn each<T>(&mut self, ways: Vec<Way>, mut done: impl FnMut(&mut Self, Way) -> Vec<T>) -> Vec<T> {
        let (count, from) = (ways.len(), self.found.len());
        let mut all = Vec::with_capacity(count);
        for way in ways {
            let own = self.found.len();
            all.extend(done(self, way));
            // Lanes find the same in many orders, and a way counts once.
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

    fn nodes(&mut self, nodes: &[Node], mut ways: Vec<Way>) -> Vec<Way> {
        for node in nodes {
            if self.is_stopped() || ways.is_empty() {
                return ways;
            }
            ways = match node {
                Node::Step(id) => self.steps(*id, ways),
                Node::If {
                    condition,
                    then,
                    otherwise,
                } => {
                    let (yes, no) = self.test(condition, ways, first_of(node));
                    let mut ends = self.nodes(then, yes);
                    ends.extend(self.nodes(otherwise, no));
                    self.merged(ends)
                }
                Node::While { condition, body } => self.repeated(condition, body, ways, first_of(node)),
                Node::Repeat { times, body } => self.counted(*times, body, ways),
                Node::Parallel { lanes } => {
                    self.check_lanes(lanes);
                    let ends = self.each(ways, |walk, way| vec![walk.side_by_side(lanes, way)]);
                    self.merged(ends)
                }
                Node::Remark(_) => ways,
            };
            if ways.len() > STATES {
                self.stop(first_of(node), ways.len());
            }
            if self.is_stopped() {
                // One of them is enough to show where it was given up.
                ways.truncate(1);
            }
        }
        ways
    }

    /// Gives up: there are too many states to follow.
    fn stop(&mut self, step: Option<usize>, states: usize) {
        if !self.stopped {
            self.stopped = true;
            self.wrong(Violation::TooManyStates { step, states }, Vec::new());
        }
    }

    /// Returns whether the plan is not followed any further: there are too many states, or the budget is spent.
    pub(super) fn is_stopped(&self) -> bool {
        self.stopped || effort::is_exhausted()
    }

    /// The ways out of a loop that is done a number of times.
    ///
    /// The states after one round depend on those before it alone. So once a round begins with states that a round
    /// began with before, the rounds repeat, and only the remainder of the last period is followed.
    fn counted(&mut self, times: u32, body: &[Node], mut ways: Vec<Way>) -> Vec<Way> {
        let mut rounds: FxHashMap<Vec<ChangedLists>, u32> = FxHashMap::default();
        let (mut round, mut last) = (0, times);
        let mut findings = Findings::from(self.found.len());
        while round < last && !self.is_stopped() {
            if last == times {
                let mut states: Vec<ChangedLists> = ways.iter().map(|way| self.changed(way)).collect();
                states.sort_unstable();
                effort::spend(states.iter().map(kept_units).sum());
                if let Some(first) = rounds.insert(states, round) {
                    last = round + (times - round) % (round - first);
                    if round == last {
                        break;
                    }
                }
            }
            let ends = self.nodes(body, ways);
            ways = self.merged(ends);
            findings.compact(&mut self.found);
            round += 1;
        }
        ways
    }

    /// The lists of facts in which the state of a way differs from the first state.
    fn changed(&self, way: &Way) -> ChangedLists {
        way.state.changed_lists(&self.world.state)
    }

    fn steps(&mut self, id: StepId, ways: Vec<Way>) -> Vec<Way> {
        let sensing = !self.domain.action(self.plan.step(id).action).senses.is_empty();
        self.each(ways, |walk, mut way| {
            walk.step(id, &mut way);
            if sensing { walk.outcomes(id, way) } else { vec![way] }
        })
    }

    /// Simulates one step.
    pub(super) fn step(&mut self, id: StepId, way: &mut Way) {
        self.reached[id.index()] = true;
        effort::spend(STEP);
        let step = self.plan.step(id);
        let action = self.domain.action(step.action);
        self.bindings.clear();
        self.bindings.extend_from_slice(&step.arguments);
        let moment = Moment {
            world: self.world,
            state: &way.state,
        };
        if holds(moment, &action.precondition, &mut self.bindings) {
            let (history, here) = (&self.history, way.here);
            rests_on(
                moment,
                &action.precondition,
                &mut self.bindings,
                &|fact| history.touched(here, fact),
                &mut self.rested,
            );
        } else {
            let missing = unmet(self.world, &way.state, &action.precondition, &mut self.bindings);
            let missing = with_culprits(missing, &self.history, way.here);
            let step = id.index();
            self.wrong(Violation::Precondition { step, missing }, self.when(way));
        }
        let (bindings, fired) = (&mut self.bindings, &mut self.fired);
        way.here = self.history.add(id, way.here, |changes| {
            apply_onto(self.world, &mut way.state, action, bindings, fired, changes);
        });
        let changed = self
            .history
            .back(way.here)
            .next()
            .is_some_and(|(_, changes)| !changes.is_empty());
        if !changed && !action.effects.is_empty() {
            self.odd(Violation::NoEffect { step: id.index() }, self.when(way));
        }
        for violation in claims::broken(self.claims, id.index(), &way.state) {
            self.odd(violation, self.when(way));
        }
        self.always(id, way);
    }

    /// Reports rules for every state after the step that breaks them. One that is broken already in the first state is
    /// no fault of the plan: it binds from where it is first kept.
    fn always(&mut self, id: StepId, way: &mut Way) {
        let now = self.broken_always(&way.state);
        for (rule, bindings) in now.iter().filter(|broken| !way.broken.contains(broken)) {
            let violation = Violation::Rule {
                step: Some(id.index()),
                rule: *rule,
                bindings: bindings.clone(),
            };
            self.wrong(violation, self.when(way));
        }
        way.broken = now;
    }

    /// The rules for every state that are broken in one, with the bindings for which they are.
    fn broken_always(&self, state: &State) -> Vec<(usize, Bindings)> {
        let rules = self.domain.rules.iter().enumerate();
        let always = rules.filter(|(_, rule)| rule.time == RuleTime::Always);
        always
            .flat_map(|(number, rule)| {
                let broken = broken_bindings(rule, self.world, state).into_iter();
                broken.map(move |bindings| (number, bindings))
            })
            .collect()
    }

    /// The ways on from a sensing step that was just done: one for each outcome, unless it is known already.
    fn outcomes(&mut self, id: StepId, way: Way) -> Vec<Way> {
        let facts = self.senses(id);
        if facts.iter().any(|fact| way.state.holds(*fact)) {
            return vec![way];
        }
        let before = self.history.before(way.here);
        let told = |fact: &Fact| {
            let mut way = way.clone();
            way.here = self.history.add(id, before, |changes| {
                way.state.set(*fact, true);
                changes.push(super::Change {
                    fact: *fact,
                    holds: true,
                });
            });
            // What sensing reveals is no fault of the plan.
            way.broken = self.broken_always(&way.state);
            way
        };
        facts.iter().map(told).collect()
    }

    /// What a sensing step can tell.
    fn senses(&self, id: StepId) -> Vec<Fact> {
        let step = self.plan.step(id);
        let outcomes = self.domain.action(step.action).senses.iter();
        outcomes.map(|atom| ground(atom, &step.arguments)).collect()
    }

    /// The ways on which a condition holds, and those on which it does not. `before` is a step that follows it.
    ///
    /// Ways that come to the same state inside a condition are one, and are counted, as those between nodes are.
    fn test(&mut self, condition: &Test, ways: Vec<Way>, before: Option<usize>) -> (Vec<Way>, Vec<Way>) {
        match condition {
            Test::Sense(id) => {
                let ways = self.steps(*id, ways);
                let first = self.senses(*id).first().copied();
                ways.into_iter()
                    .partition(|way| first.is_some_and(|fact| way.state.holds(fact)))
            }
            Test::Holds(fact) => {
                effort::spend(ways.len());
                let parts = self.each(ways, |walk, way| walk.asked(*fact, way, before));
                let (yes, no): (Vec<_>, Vec<_>) = parts.into_iter().partition(|(_, holds)| *holds);
                let ways = |parts: Vec<(Way, bool)>| parts.into_iter().map(|(way, _)| way).collect();
                (ways(yes), ways(no))
            }
            Test::Not(inner) => {
                let (yes, no) = self.test(inner, ways, before);
                (no, yes)
            }
            Test::All(parts) => {
                let (mut yes, mut no) = (ways, Vec::new());
                for part in parts {
                    let (holds, fails) = self.test(part, yes, before);
                    no.extend(fails);
                    (yes, no) = (self.counted_ways(holds, before), self.counted_ways(no, before));
                }
                (yes, no)
            }
            Test::Any(parts) => {
                let (mut yes, mut no) = (Vec::new(), ways);
                for part in parts {
                    let (holds, fails) = self.test(part, no, before);
                    yes.extend(holds);
                    (yes, no) = (self.counted_ways(yes, before), self.counted_ways(fails, before));
                }
                (yes, no)
            }
        }
    }

    /// Ways at one place inside a condition, those with the same state as one; gives up where there are too many.
    fn counted_ways(&mut self, ways: Vec<Way>, before: Option<usize>) -> Vec<Way> {
        let mut ways = self.merged(ways);
        if ways.len() > STATES {
            self.stop(before, ways.len());
            ways.truncate(1);
        }
        ways
    }

    /// A way on which a fact is asked, and whether it holds there. What nobody knows may be either.
    fn asked(&mut self, fact: Fact, way: Way, before: Option<usize>) -> Vec<(Way, bool)> {
        if way.state.holds(fact) {
            return vec![(way, true)];
        }
        let outcomes = self.domain.outcomes(fact);
        let known = outcomes.is_empty() || outcomes.iter().any(|outcome| way.state.holds(*outcome));
        if known {
            return vec![(way, false)];
        }
        let step = before;
        self.wrong(Violation::Unsensed { step, fact }, self.when(&way));
        vec![(way.clone(), true), (way, false)]
    }

    /// The ways out of a loop that goes on as long as a condition holds.
    fn repeated(&mut self, condition: &Test, body: &[Node], ways: Vec<Way>, before: Option<usize>) -> Vec<Way> {
        let start = &self.world.state;
        let mut heads = Heads::default();
        for way in ways {
            heads.meet(way, start);
        }
        let mut out = Vec::new();
        let mut findings = Findings::from(self.found.len());
        while let Some((number, way)) = heads.next() {
            let (yes, no) = self.test(condition, vec![way], before);
            heads.leaves[number] = !no.is_empty();
            out.extend(no);
            out = self.counted_ways(out, before);
            let ends = self.nodes(body, yes);
            effort::spend(ends.len());
            for end in ends {
                let next = heads.meet(end, start);
                heads.follows.push((number, next));
            }
            if heads.ways.len() > STATES {
                self.stop(before, heads.ways.len());
            }
            if self.is_stopped() {
                return self.merged(out);
            }
            findings.compact(&mut self.found);
        }
        if let Some(stuck) = heads.endless() {
            let when = self.when(&heads.ways[stuck]);
            self.wrong(Violation::EndlessLoop { step: before }, when);
        }
        self.merged(out)
    }

    /// Ways that came to the same state are one: the first of them.
    fn merged(&self, ways: Vec<Way>) -> Vec<Way> {
        if ways.len() < 2 {
            return ways;
        }
        let mut seen = FxHashSet::default();
        let new = |way: &Way| {
            let changed = self.changed(way);
            // Lists are compared with the first state's, hashed and kept.
            effort::spend(4 + kept_units(&changed) / 2);
            seen.insert(changed)
        };
        ways.into_iter().filter(new).collect()
    }

    /// What was found, what is wrong and what is odd, each once.
    pub(super) fn findings(self) -> (Vec<Violation>, Vec<Violation>) {
        let (odd, wrong): (Vec<_>, Vec<_>) = joined(self.found, None).into_iter().partition(|found| found.odd);
        let told = |found: Vec<Found>| {
            found
                .into_iter()
                .map(|found| found.violation.when(found.when))
                .collect()
        };
        (told(wrong), told(odd))
    }
}

/// The states at the head of a loop.
#[derive(Default)]
struct Heads {
    numbers: FxHashMap<ChangedLists, usize>,
    ways: Vec<Way>,
    /// How many of them have been followed.
    followed: usize,
    /// Whether the loop can end at each.
    leaves: Vec<bool>,
    /// Which can come after which.
    follows: Vec<(usize, usize)>,
}

impl Heads {
    fn meet(&mut self, way: Way, start: &State) -> usize {
        let state = way.state.changed_lists(start);
        if let Some(number) = self.numbers.get(&state) {
            return *number;
        }
        effort::spend(kept_units(&state));
        self.numbers.insert(state, self.ways.len());
        self.ways.push(way);
        self.leaves.push(false);
        self.ways.len() - 1
    }

    fn next(&mut self) -> Option<(usize, Way)> {
        let way = self.ways.get(self.followed)?.clone();
        self.followed += 1;
        Some((self.followed - 1, way))
    }

    /// One from which the loop can never end.
    fn endless(&self) -> Option<usize> {
        let mut before: Vec<Vec<usize>> = vec![Vec::new(); self.ways.len()];
        for (from, to) in &self.follows {
            before[*to].push(*from);
        }
        let mut ends = self.leaves.clone();
        let mut open: Vec<usize> = (0..ends.len()).filter(|number| ends[*number]).collect();
        while let Some(number) = open.pop() {
            for from in &before[number] {
                if !std::mem::replace(&mut ends[*from], true) {
                    open.push(*from);
                }
            }
        }
        ends.iter().position(|ends| !ends)
    }
}

/// The first step of a node, from 0; none if there is none in it.
fn first_of(node: &Node) -> Option<usize> {
    tree::steps(std::slice::from_ref(node)).first().map(|step| step.index())
}

/// The units that are charged for a state that is kept: what of it is not shared with the first state.
fn kept_units(state: &ChangedLists) -> usize {
    state.iter().map(|(_, facts)| 2 * facts.len() + 1).sum()
}

/// What a loop finds, merged whenever it has doubled: rounds find the same again and again.
struct Findings {
    from: usize,
    most: usize,
}

impl Findings {
    fn from(from: usize) -> Self {
        Self { from, most: 256 }
    }

    fn compact(&mut self, found: &mut Vec<Found>) {
        if found.len() - self.from > self.most {
            let together = joined(found.split_off(self.from), None);
            self.most = 2 * together.len().max(128);
            found.extend(together);
        }
    }
}

/// Each finding once. One that `count` of them share, or that somewhere is so whatever sensing told, is so in any
/// case; else what they all know counts.
fn joined(found: Vec<Found>, count: Option<usize>) -> Vec<Found> {
    let mut together: Vec<(Found, usize)> = Vec::with_capacity(found.len());
    let mut numbers: FxHashMap<(Violation, bool), usize> = FxHashMap::default();
    effort::spend(found.len());
    for next in found {
        let number = *numbers
            .entry((next.violation.clone(), next.odd))
            .or_insert(together.len());
        let Some((known, times)) = together.get_mut(number) else {
            together.push((next, 1));
            continue;
        };
        if !known.when.is_empty() {
            effort::spend(known.when.len());
            let common: Vec<Fact> = known
                .when
                .iter()
                .filter(|fact| next.when.contains(fact))
                .copied()
                .collect();
            if !common.is_empty() || next.when.is_empty() {
                known.when = common;
            }
        }
        *times += 1;
    }
    let plain = |(mut found, times): (Found, usize)| {
        if count == Some(times) {
            found.when.clear();
        }
        found
    };
    together.into_iter().map(plain).collect()
}
