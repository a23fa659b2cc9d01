//! A walk along the paths through a verified plan, which visits every step.
//!
//! Verification has followed all paths and found no violation; this walk repeats the simulation for those who want to look at
//! the states on the way. Both sides of a branch are followed, each outcome of sensing, and a loop until no new state
//! occurs; paths that reach the same state are joined. Lanes are followed in one of their orders, since they end in the same
//! state in all of them.

use std::collections::VecDeque;
use std::rc::Rc;

use longstep_core::model::{ChangedLists, Changes, Fact, State, World, apply, ground};
use longstep_core::plan::{Node, Plan, Step, StepId, Test, lanes};
use rustc_hash::{FxHashMap, FxHashSet};

/// Maximum number of states that are followed at one node; further ones are left out.
const STATES: usize = 256;
/// Maximum number of visits of steps. The walk stops there, as it may in nested loops.
const VISITS: usize = 100_000;

/// Looks at the steps of a walk. `Memory` is kept along each path.
pub(crate) trait Follower {
    /// The memory of a path.
    type Memory: Clone + Default;

    /// Looks at a step on a path.
    fn visit(&mut self, visit: &Visit<'_>, memory: &mut Self::Memory);

    /// Looks at a condition before its value decides the path.
    fn test(&mut self, _fact: Fact, _state: &State, _memory: &Self::Memory) {}

    /// Joins the memory of a path that reaches the same state.
    fn join(&mut self, memory: &mut Self::Memory, other: Self::Memory);
}

/// A step on a path.
pub(crate) struct Visit<'a> {
    pub(crate) step: StepId,
    pub(crate) before: &'a State,
    pub(crate) after: &'a State,
    /// The changes of the step, the outcome of sensing included.
    pub(crate) changes: &'a Changes,
    /// The outcome of sensing; none for a step that does not sense.
    pub(crate) outcome: Option<Fact>,
    /// Outcomes of sensing on the path before the step.
    pub(crate) way: &'a Way,
}

/// The outcomes on a path, the last one first; paths share what they have in common.
pub(crate) type Way = Option<Rc<Outcome>>;

/// An outcome of sensing on a path.
#[derive(Debug)]
pub(crate) struct Outcome {
    fact: Fact,
    before: Way,
}

/// Returns the outcomes of a path, in order.
pub(crate) fn outcomes(way: &Way) -> Vec<Fact> {
    let links = std::iter::successors(way.as_deref(), |link| link.before.as_deref());
    let mut facts: Vec<Fact> = links.map(|link| link.fact).collect();
    facts.reverse();
    facts
}

/// The end of a path.
#[derive(Clone)]
pub(crate) struct Path<M> {
    pub(crate) state: State,
    way: Way,
    pub(crate) memory: M,
}

/// Follows the paths through a plan; returns their ends.
pub(crate) fn walk<F: Follower>(world: &World, plan: &Plan, follower: &mut F) -> Vec<Path<F::Memory>> {
    let mut walk = Walk {
        world,
        plan,
        follower,
        visits: 0,
    };
    let start = Path {
        state: world.state.clone(),
        way: None,
        memory: F::Memory::default(),
    };
    walk.nodes(plan.body(), vec![start])
}

struct Walk<'a, F> {
    world: &'a World,
    plan: &'a Plan,
    follower: &'a mut F,
    visits: usize,
}

type Paths<F> = Vec<Path<<F as Follower>::Memory>>;

impl<F: Follower> Walk<'_, F> {
    fn is_stopped(&self) -> bool {
        self.visits >= VISITS
    }

    fn nodes(&mut self, nodes: &[Node], mut paths: Paths<F>) -> Paths<F> {
        for node in nodes {
            if paths.is_empty() || self.is_stopped() {
                return paths;
            }
            paths = match node {
                Node::Step(id) => self.step(*id, paths),
                Node::If {
                    condition,
                    then,
                    otherwise,
                } => {
                    let (yes, no) = self.test(condition, paths);
                    let mut ends = self.nodes(then, yes);
                    ends.extend(self.nodes(otherwise, no));
                    self.joined(ends)
                }
                Node::While { condition, body } => self.repeated(condition, body, paths),
                Node::Repeat { times, body } => self.counted(*times, body, paths),
                Node::Parallel { lanes } => lanes::sequence(lanes)
                    .into_iter()
                    .fold(paths, |paths, step| self.step(step, paths)),
                Node::Remark(_) => paths,
            };
        }
        paths
    }

    fn step(&mut self, id: StepId, paths: Paths<F>) -> Paths<F> {
        let mut ends = Vec::with_capacity(paths.len());
        for path in paths {
            if self.is_stopped() {
                break;
            }
            self.one_step(id, path, &mut ends);
        }
        ends
    }

    fn one_step(&mut self, id: StepId, mut path: Path<F::Memory>, ends: &mut Paths<F>) {
        self.visits += 1;
        let step = self.plan.step(id);
        let action = self.world.domain().action(step.action);
        let before = path.state.clone();
        let mut changes = apply(self.world, &mut path.state, action, &step.arguments);
        let possible = possible_outcomes(self.world, step);
        let known = possible.iter().copied().find(|fact| path.state.holds(*fact));
        let open = match known {
            Some(fact) => vec![Some(fact)],
            None if possible.is_empty() => vec![None],
            None => possible.into_iter().map(Some).collect(),
        };
        let (facts, last) = (changes.facts.len(), open.len() - 1);
        let mut rest = Some(path);
        for (number, outcome) in open.into_iter().enumerate() {
            let taken = if number == last { rest.take() } else { rest.clone() };
            let Some(mut path) = taken else { break };
            changes.facts.truncate(facts);
            let way = path.way.clone();
            if let Some(fact) = outcome.filter(|fact| path.state.set(*fact, true)) {
                changes.facts.push(longstep_core::model::Change { fact, holds: true });
                path.way = Some(Rc::new(Outcome {
                    fact,
                    before: path.way.take(),
                }));
            }
            let visit = Visit {
                step: id,
                before: &before,
                after: &path.state,
                changes: &changes,
                outcome,
                way: &way,
            };
            self.follower.visit(&visit, &mut path.memory);
            ends.push(path);
        }
    }

    /// Splits paths into those on which a condition holds and those on which it does not.
    fn test(&mut self, condition: &Test, paths: Paths<F>) -> (Paths<F>, Paths<F>) {
        match condition {
            Test::Sense(id) => {
                let first = possible_outcomes(self.world, self.plan.step(*id)).first().copied();
                let holds = |path: &Path<F::Memory>| first.is_some_and(|fact| path.state.holds(fact));
                self.step(*id, paths).into_iter().partition(holds)
            }
            Test::Holds(fact) => {
                for path in &paths {
                    self.follower.test(*fact, &path.state, &path.memory);
                }
                paths.into_iter().partition(|path| path.state.holds(*fact))
            }
            Test::Not(inner) => {
                let (yes, no) = self.test(inner, paths);
                (no, yes)
            }
            Test::All(parts) => parts.iter().fold((paths, Vec::new()), |(yes, mut no), part| {
                let (holds, fails) = self.test(part, yes);
                no.extend(fails);
                (holds, no)
            }),
            Test::Any(parts) => parts.iter().fold((Vec::new(), paths), |(mut yes, no), part| {
                let (holds, fails) = self.test(part, no);
                yes.extend(holds);
                (yes, fails)
            }),
        }
    }

    /// Follows a loop with a condition until no new state begins an iteration.
    fn repeated(&mut self, condition: &Test, body: &[Node], paths: Paths<F>) -> Paths<F> {
        let mut seen: FxHashSet<ChangedLists> = FxHashSet::default();
        let mut open: VecDeque<Path<F::Memory>> = paths.into();
        let mut out = Vec::new();
        while let Some(path) = open.pop_front() {
            if self.is_stopped() {
                break;
            }
            if seen.len() >= STATES || !seen.insert(self.changed(&path)) {
                continue;
            }
            let (yes, no) = self.test(condition, vec![path]);
            out.extend(no);
            open.extend(self.nodes(body, yes));
        }
        self.joined(out)
    }

    /// Follows a loop with a fixed number of iterations. Once the states before an iteration repeat, only the remainder of
    /// the last period is followed, as verification does.
    fn counted(&mut self, times: u32, body: &[Node], mut paths: Paths<F>) -> Paths<F> {
        let mut rounds: FxHashMap<Vec<ChangedLists>, u32> = FxHashMap::default();
        let (mut round, mut last) = (0, times);
        while round < last && !paths.is_empty() && !self.is_stopped() {
            if last == times {
                let mut states: Vec<ChangedLists> = paths.iter().map(|path| self.changed(path)).collect();
                states.sort_unstable();
                if let Some(first) = rounds.insert(states, round) {
                    last = round + (times - round) % (round - first);
                    if round == last {
                        break;
                    }
                }
            }
            let ends = self.nodes(body, paths);
            paths = self.joined(ends);
            round += 1;
        }
        paths
    }

    fn changed(&self, path: &Path<F::Memory>) -> ChangedLists {
        path.state.changed_lists(&self.world.state)
    }

    /// Keeps the first path for each state, and at most [`STATES`] of them.
    fn joined(&mut self, paths: Paths<F>) -> Paths<F> {
        if paths.len() < 2 {
            return paths;
        }
        let mut places: FxHashMap<ChangedLists, usize> = FxHashMap::default();
        let mut kept: Paths<F> = Vec::new();
        for path in paths {
            let changed = self.changed(&path);
            match places.get(&changed) {
                Some(place) => self.follower.join(&mut kept[*place].memory, path.memory),
                None if kept.len() < STATES => {
                    places.insert(changed, kept.len());
                    kept.push(path);
                }
                None => {}
            }
        }
        kept
    }
}

/// Returns the possible outcomes of a sensing step; none for another step.
pub(crate) fn possible_outcomes(world: &World, step: &Step) -> Vec<Fact> {
    let outcomes = world.domain().action(step.action).senses.iter();
    outcomes.map(|atom| ground(atom, &step.arguments)).collect()
}

#[cfg(test)]
mod tests {
    use longstep_core::testing;
    use longstep_core::verify::VerifiedPlan;

    use super::*;
    use crate::shipped;

    /// Counts the visits of each step.
    struct Counter(Vec<usize>);

    impl Follower for Counter {
        type Memory = ();

        fn visit(&mut self, visit: &Visit<'_>, _memory: &mut ()) {
            self.0[visit.step.index()] += 1;
        }

        fn join(&mut self, _memory: &mut (), _other: ()) {}
    }

    /// Checks that the walk ends in the states in which verification ends, and visits every step.
    #[track_caller]
    fn check_walk(plan: &VerifiedPlan) {
        let mut counter = Counter(vec![0; plan.steps().len()]);
        let ends = walk(plan.world(), plan.plan(), &mut counter);
        let found: Vec<&State> = ends.iter().map(|end| &end.state).collect();
        assert_eq!(found.len(), plan.endings().len());
        assert!(plan.endings().iter().all(|ending| found.contains(&&ending.after)));
        assert!(counter.0.iter().all(|visits| *visits > 0), "{:?}", counter.0);
    }

    #[test]
    fn walk_ends_where_verification_ends() {
        let pantry = "crates/longstep-eval/suites/branching/scenes/pantry.json";
        let table = [
            (
                pantry,
                "if expired(milk) then put(milk, trash bin) else put(milk, pantry shelf)",
            ),
            (
                pantry,
                "put(ham, fridge) & if empty(cereal) then put(cereal, trash bin)",
            ),
            (
                pantry,
                "if expired(milk) then put(milk, trash bin) & if expired(ham) then put(ham, trash bin)",
            ),
        ];
        for (file, goal) in table {
            check_walk(&testing::plan_for(&shipped::world("household-checks", file), goal));
        }
        let workshop = "crates/longstep-eval/suites/two-arms/scenes/workshop.json";
        check_walk(&testing::plan_for(
            &shipped::world("household-dual", workshop),
            "put(vise, workbench)",
        ));
    }

    /// A plan that senses 11 places: 2,048 states, more than the walk follows. A sensing step is visited once for each outcome.
    #[test]
    fn walk_of_too_many_states_is_bounded_and_visits_the_first_ones() {
        let names: Vec<String> = (0..11).map(|number| format!("<table_{number}>")).collect();
        let world = testing::world("household-checks", serde_json::json!({"assets": names}));
        let steps: Vec<Step> = names
            .iter()
            .flat_map(|name| [("move-hand", name), ("check-cleanness", name)])
            .map(|(action, name)| shipped::step(&world, action, &[name]))
            .collect();
        let id = StepId::new;
        let body = (0..names.len()).flat_map(|number| {
            let condition = Test::Sense(id(2 * number + 1));
            let branch = Node::If {
                condition,
                then: Vec::new(),
                otherwise: Vec::new(),
            };
            [Node::Step(id(2 * number)), branch]
        });
        let plan = Plan::tree(steps, body.collect()).unwrap();
        let plan = shipped::verified(&world, plan);
        assert_eq!(plan.endings().len(), 2_048);
        let mut counter = Counter(vec![0; plan.steps().len()]);
        assert_eq!(walk(&world, plan.plan(), &mut counter).len(), STATES);
        assert!(
            counter.0.iter().all(|visits| (1..=2 * STATES).contains(visits)),
            "{:?}",
            counter.0
        );
    }
}
