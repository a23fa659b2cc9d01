//! Comparison of the verifier with brute force: every outcome and every interleaving, one at a time, without memory.

use std::collections::BTreeSet;

use proptest::prelude::*;

use super::bench::{Guard, Part, domain, fact, plan, world};
use crate::plan::{LaneItem, Node, Plan, StepId, Test};
use crate::verify::{Purpose, Violation, apply, check, unmet};
use longstep_model::environment::Claim;
use longstep_model::model::{Domain, Environment, Fact, State, World};

/// Findings about a plan, without their order.
#[derive(Debug, Default, PartialEq, Eq)]
struct Findings {
    /// Steps that are not applicable on some path, with the missing facts.
    impossible: BTreeSet<(usize, Vec<(Fact, bool)>)>,
    unsensed: BTreeSet<Fact>,
    endless: bool,
    ends: BTreeSet<Vec<Fact>>,
}

/// Remaining work on a path: nodes, and loops with the states seen at their heads.
#[derive(Clone)]
enum Todo<'a> {
    Node(&'a Node),
    Head(&'a Node, Vec<State>),
}

struct Enumeration<'a> {
    domain: &'a Domain,
    world: &'a World,
    plan: &'a Plan,
    findings: Findings,
    /// Remaining transitions.
    left: usize,
}

impl<'a> Enumeration<'a> {
    /// Enumerates all paths; none if there are too many, since some random plans have millions.
    fn of(world: &'a World, plan: &'a Plan) -> Option<Findings> {
        let domain = world.domain();
        let mut all = Self {
            domain,
            world,
            plan,
            findings: Findings::default(),
            left: 200_000,
        };
        let todo = plan.body().iter().rev().map(Todo::Node).collect();
        all.go(todo, world.state.clone());
        (all.left > 0).then_some(all.findings)
    }

    /// Counts a transition; false if none are left.
    fn turn(&mut self) -> bool {
        self.left = self.left.saturating_sub(1);
        self.left > 0
    }

    /// Executes the remaining work, last item first; returns true if some path ends.
    fn go(&mut self, mut todo: Vec<Todo<'a>>, state: State) -> bool {
        if !self.turn() {
            return true;
        }
        let Some(next) = todo.pop() else {
            self.findings.ends.insert(state.iter().collect());
            return true;
        };
        match next {
            Todo::Node(Node::Step(id)) => {
                let mut ends = false;
                for state in self.step(*id, state) {
                    ends |= self.go(todo.clone(), state);
                }
                ends
            }
            Todo::Node(Node::If {
                condition,
                then,
                otherwise,
            }) => {
                let mut ends = false;
                for (state, holds) in self.evaluate(condition, state) {
                    let mut todo = todo.clone();
                    let side = if holds { then } else { otherwise };
                    todo.extend(side.iter().rev().map(Todo::Node));
                    ends |= self.go(todo, state);
                }
                ends
            }
            Todo::Node(node @ Node::While { .. }) => {
                todo.push(Todo::Head(node, Vec::new()));
                self.go(todo, state)
            }
            Todo::Head(node, mut seen) => {
                let Node::While { condition, body } = node else {
                    unreachable!()
                };
                if seen.contains(&state) {
                    // The continuation was explored at the first visit of this state.
                    return false;
                }
                let mut alone = Self {
                    findings: Findings::default(),
                    ..*self
                };
                self.findings.endless |= !alone.only(vec![Todo::Head(node, Vec::new())], state.clone());
                self.left = alone.left;
                seen.push(state.clone());
                let mut ends = false;
                for (state, holds) in self.evaluate(condition, state) {
                    let mut todo = todo.clone();
                    if holds {
                        todo.push(Todo::Head(node, seen.clone()));
                        todo.extend(body.iter().rev().map(Todo::Node));
                    }
                    ends |= self.go(todo, state);
                }
                ends
            }
            Todo::Node(Node::Repeat { times, body }) => {
                for _ in 0..*times {
                    todo.extend(body.iter().rev().map(Todo::Node));
                }
                self.go(todo, state)
            }
            Todo::Node(Node::Parallel { .. } | Node::Remark(_)) => unreachable!(),
        }
    }

    /// Returns true if some path through the remaining work ends; inner loops are not checked for termination.
    fn only(&mut self, mut todo: Vec<Todo<'a>>, state: State) -> bool {
        if !self.turn() {
            return true;
        }
        let Some(next) = todo.pop() else { return true };
        let ways: Vec<(Vec<Todo<'a>>, State)> = match next {
            Todo::Node(Node::Step(id)) => self
                .step(*id, state)
                .into_iter()
                .map(|state| (todo.clone(), state))
                .collect(),
            Todo::Node(Node::If {
                condition,
                then,
                otherwise,
            }) => {
                let branches = self.evaluate(condition, state).into_iter();
                branches
                    .map(|(state, holds)| {
                        let mut todo = todo.clone();
                        todo.extend(if holds { then } else { otherwise }.iter().rev().map(Todo::Node));
                        (todo, state)
                    })
                    .collect()
            }
            Todo::Node(Node::Repeat { times, body }) => {
                for _ in 0..*times {
                    todo.extend(body.iter().rev().map(Todo::Node));
                }
                vec![(todo, state)]
            }
            Todo::Node(node @ Node::While { .. }) => {
                todo.push(Todo::Head(node, Vec::new()));
                vec![(todo, state)]
            }
            Todo::Head(node @ Node::While { condition, body }, mut seen) => {
                if seen.contains(&state) {
                    return false;
                }
                seen.push(state.clone());
                let branches = self.evaluate(condition, state).into_iter();
                branches
                    .map(|(state, holds)| {
                        let mut todo = todo.clone();
                        if holds {
                            todo.push(Todo::Head(node, seen.clone()));
                            todo.extend(body.iter().rev().map(Todo::Node));
                        }
                        (todo, state)
                    })
                    .collect()
            }
            _ => unreachable!(),
        };
        ways.into_iter().any(|(todo, state)| self.only(todo, state))
    }

    fn step(&mut self, id: StepId, mut state: State) -> Vec<State> {
        let step = self.plan.step(id);
        let action = self.domain.action(step.action);
        let missing = unmet(self.world, &state, &action.precondition, &mut step.arguments.clone());
        if !missing.is_empty() {
            let mut facts: Vec<(Fact, bool)> = missing.iter().map(|m| (m.fact.unwrap(), m.holds)).collect();
            facts.sort();
            self.findings.impossible.insert((id.index(), facts));
        }
        apply(self.world, &mut state, action, &step.arguments);
        let outcomes: Vec<Fact> = action
            .senses
            .iter()
            .map(|atom| Fact::new(atom.predicate, step.arguments.iter().copied()))
            .collect();
        if outcomes.is_empty() || outcomes.iter().any(|fact| state.holds(*fact)) {
            return vec![state];
        }
        let with_outcome = |fact: &Fact| {
            let mut state = state.clone();
            state.set(*fact, true);
            state
        };
        outcomes.iter().map(with_outcome).collect()
    }

    fn evaluate(&mut self, test: &Test, state: State) -> Vec<(State, bool)> {
        match test {
            Test::Sense(id) => {
                let step = self.plan.step(*id);
                let first = &self.domain.action(step.action).senses[0];
                let fact = Fact::new(first.predicate, step.arguments.iter().copied());
                let states = self.step(*id, state).into_iter();
                states
                    .map(|state| {
                        let holds = state.holds(fact);
                        (state, holds)
                    })
                    .collect()
            }
            Test::Holds(fact) => {
                let sensed = self
                    .domain
                    .actions
                    .iter()
                    .find(|a| a.senses.iter().any(|s| s.predicate == fact.predicate()));
                let known = sensed.is_none_or(|action| {
                    let holds =
                        |atom: &longstep_model::model::Atom| state.holds(Fact::new(atom.predicate, [fact.argument(0)]));
                    action.senses.iter().any(holds)
                });
                if known {
                    let holds = state.holds(*fact);
                    return vec![(state, holds)];
                }
                self.findings.unsensed.insert(*fact);
                vec![(state.clone(), true), (state, false)]
            }
            Test::Not(inner) => {
                let branches = self.evaluate(inner, state).into_iter();
                branches.map(|(state, holds)| (state, !holds)).collect()
            }
            Test::All(parts) => self.in_turn(parts, true, state),
            Test::Any(parts) => self.in_turn(parts, false, state),
        }
    }

    /// Evaluates the parts in order as long as each has the value.
    fn in_turn(&mut self, parts: &[Test], value: bool, state: State) -> Vec<(State, bool)> {
        let Some((first, rest)) = parts.split_first() else {
            return vec![(state, value)];
        };
        let mut all = Vec::new();
        for (state, holds) in self.evaluate(first, state) {
            if holds == value {
                all.extend(self.in_turn(rest, value, state))
            } else {
                all.push((state, holds))
            }
        }
        all
    }
}

/// Returns the claim that exactly these lamps are lit in the final state.
fn lit_claim(world: &World, lamps: &BTreeSet<usize>) -> Claim {
    let states: Vec<String> = lamps
        .iter()
        .map(|lamp| format!(r#""<lamp_{lamp}>": "LIT()""#))
        .collect();
    let text = format!(
        r#"{{"assets": [], "objects": [], "object_states": {{{}}}}}"#,
        states.join(", ")
    );
    Claim::read(world, &Environment::from_json(&text).unwrap())
}

/// Converts the verifier's report to [`Findings`].
fn findings(world: &World, plan: &Plan) -> (Findings, bool) {
    let report = check(world, plan.clone(), &Purpose::default());
    let mut found = Findings::default();
    let mut too_many = false;
    for violation in &report.violations {
        let violation = match violation {
            Violation::When { violation, .. } => violation,
            plain => plain,
        };
        match violation {
            Violation::Precondition { step, missing } => {
                let mut facts: Vec<(Fact, bool)> = missing.iter().map(|m| (m.fact.unwrap(), m.holds)).collect();
                facts.sort();
                found.impossible.insert((*step, facts));
            }
            Violation::Unsensed { fact, .. } => drop(found.unsensed.insert(*fact)),
            Violation::EndlessLoop { .. } => found.endless = true,
            Violation::TooManyStates { .. } => too_many = true,
            other => panic!("{other:?}"),
        }
    }
    found.ends = report
        .endings
        .iter()
        .map(|ending| ending.after.iter().collect())
        .collect();
    (found, too_many)
}

const LAMPS: usize = 2;

fn guards() -> impl Strategy<Value = Guard> {
    let predicate = prop::sample::select(vec!["lit", "warm", "cold"]);
    let leaf = prop_oneof![
        (1..=LAMPS).prop_map(Guard::Feel),
        (predicate, 1..=LAMPS).prop_map(|(predicate, lamp)| Guard::Is(predicate, lamp)),
    ];
    leaf.prop_recursive(2, 4, 2, |inner| {
        prop_oneof![
            inner.clone().prop_map(|guard| Guard::Not(Box::new(guard))),
            prop::collection::vec(inner.clone(), 1..=2).prop_map(Guard::All),
            prop::collection::vec(inner, 1..=2).prop_map(Guard::Any),
        ]
    })
}

fn steps(hand: &'static str) -> impl Strategy<Value = String> {
    let one = prop::sample::select(vec!["press", "unpress"]);
    let two = prop::sample::select(vec!["pass", "link"]);
    prop_oneof![
        (one, 1..=LAMPS + 2).prop_map(move |(verb, lamp)| format!("{verb} {hand} {lamp}")),
        (two, 1..=LAMPS + 2, 1..=LAMPS + 2)
            .prop_map(move |(verb, lamp, other)| format!("{verb} {hand} {lamp} {other}")),
    ]
}

fn calls() -> impl Strategy<Value = String> {
    let of_lamp = prop::sample::select(vec!["press left", "unpress left", "feel", "cool", "wait"]);
    (of_lamp, 1..=LAMPS).prop_map(|(verb, lamp)| format!("{verb} {lamp}"))
}

pub(crate) fn parts() -> impl Strategy<Value = Vec<Part>> {
    let leaf = calls().prop_map(Part::Do).boxed();
    let part = leaf.prop_recursive(3, 10, 3, |inner| {
        let body = || prop::collection::vec(inner.clone(), 0..=3);
        prop_oneof![
            3 => calls().prop_map(Part::Do),
            3 => (guards(), body(), body()).prop_map(|(guard, then, otherwise)| Part::If(guard, then, otherwise)),
            2 => (guards(), body()).prop_map(|(guard, body)| Part::While(guard, body)),
            1 => (0u32..6, body()).prop_map(|(times, body)| Part::Repeat(times, body)),
        ]
    });
    prop::collection::vec(part, 1..=4)
}

/// Returns all interleavings of the lanes; `None` for a deadlock.
fn orders(lanes: &[Vec<LaneItem>], places: &[usize]) -> Vec<Option<Vec<StepId>>> {
    let next = |lane: usize| lanes[lane].get(places[lane]);
    let all = 0..lanes.len();
    if all.clone().all(|lane| next(lane).is_none()) {
        return vec![Some(Vec::new())];
    }
    let mut found = Vec::new();
    for lane in all.clone() {
        let mut to = places.to_vec();
        let begins = match next(lane) {
            Some(LaneItem::Step(step)) => {
                to[lane] += 1;
                vec![*step]
            }
            Some(sync @ LaneItem::Sync(_)) => {
                let ahead = |lane: &usize| lanes[*lane][places[*lane]..].contains(sync);
                let waiting: Vec<usize> = all.clone().filter(ahead).collect();
                if waiting[0] != lane || !waiting.iter().all(|lane| next(*lane) == Some(sync)) {
                    continue;
                }
                waiting.iter().for_each(|lane| to[*lane] += 1);
                Vec::new()
            }
            _ => continue,
        };
        for rest in orders(lanes, &to) {
            found.push(rest.map(|rest| [begins.clone(), rest].concat()));
        }
    }
    if found.is_empty() {
        found.push(None);
    }
    found
}

pub(crate) fn lane(hand: &'static str) -> impl Strategy<Value = Vec<String>> {
    let item = prop_oneof![5 => steps(hand), 1 => prop::sample::select(vec!["sync a".to_owned(), "sync b".to_owned()])];
    prop::collection::vec(item, 0..=4).prop_map(|mut items| {
        // Each synchronization point occurs once in a lane.
        let mut seen = Vec::new();
        items.retain(|item| {
            !item.starts_with("sync") || {
                let new = !seen.contains(item);
                seen.push(item.clone());
                new
            }
        });
        items
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_000, ..ProptestConfig::default() })]

    #[test]
    fn verify_agrees_with_enumeration_of_outcomes(parts in parts(), lit in prop::collection::vec(1..=LAMPS, 0..=2)) {
        let domain = domain();
        let world = world(&domain, LAMPS, &lit);
        let plan = plan(&world, &parts);
        let expected = Enumeration::of(&world, &plan);
        prop_assume!(expected.is_some());
        let expected = expected.unwrap();
        let (found, too_many) = findings(&world, &plan);
        prop_assert!(!too_many);
        prop_assert_eq!(&found.impossible, &expected.impossible);
        prop_assert_eq!(&found.unsensed, &expected.unsensed);
        prop_assert_eq!(found.endless, expected.endless);
        if !expected.ends.is_empty() {
            prop_assert_eq!(&found.ends, &expected.ends);
        }
    }

    #[test]
    fn claim_holds_if_one_ending_satisfies_it(
        parts in parts(),
        lit in prop::collection::vec(1..=LAMPS, 0..=2),
        claimed in prop::collection::btree_set(1..=LAMPS, 0..=LAMPS),
    ) {
        let domain = domain();
        let world = world(&domain, LAMPS, &lit);
        let plan = plan(&world, &parts);
        let purpose = Purpose { claim: Some(lit_claim(&world, &claimed)), ..Purpose::default() };
        let expected = Enumeration::of(&world, &plan);
        prop_assume!(expected.is_some());
        let ends = expected.unwrap().ends;
        let promised: Vec<Fact> = claimed.iter().map(|lamp| fact(&world, "lit", *lamp)).collect();
        let promised: Vec<Fact> = promised.into_iter().filter(|fact| !world.state.holds(*fact)).collect();
        let report = check(&world, plan, &purpose);
        // A plan without an end has no ending that could fulfill the claim and is rejected for that.
        if !ends.is_empty() {
            let kept = ends.iter().any(|end| promised.iter().all(|fact| end.contains(fact)));
            prop_assert_eq!(report.claimed.is_some(), kept);
            prop_assert_eq!(report.violations.iter().any(|found| found.kind() == "claim"), !kept);
            if let Some(number) = report.claimed {
                prop_assert!(promised.iter().all(|fact| report.endings[number].after.holds(*fact)));
            }
        }
    }

    #[test]
    fn verify_agrees_with_enumeration_of_lane_orders(left in lane("left"), right in lane("right"), lit in prop::collection::vec(1..=4usize, 0..=3)) {
        let domain = domain();
        let world = world(&domain, LAMPS + 2, &lit);
        let plan = plan(&world, &[Part::Lanes(vec![("left", left), ("right", right)])]);
        let [Node::Parallel { lanes }] = plan.body() else { unreachable!() };
        let lanes: Vec<Vec<LaneItem>> = lanes.iter().map(|lane| lane.items.clone()).collect();
        let report = check(&world, plan.clone(), &Purpose::default());
        let (mut possible, mut ends, mut waits) = (true, BTreeSet::new(), false);
        for order in orders(&lanes, &[0, 0]) {
            let Some(order) = order else { waits = true; continue };
            let mut state = world.state.clone();
            for id in order {
                let step = plan.step(id);
                let action = domain.action(step.action);
                possible &= unmet(&world, &state, &action.precondition, &mut step.arguments.clone()).is_empty();
                apply(&world, &mut state, action, &step.arguments);
            }
            ends.insert(state.iter().collect::<Vec<Fact>>());
        }
        let has = |kind: &str| report.violations.iter().any(|violation| violation.kind() == kind);
        prop_assert_eq!(has("deadlock"), waits);
        if !waits {
            // An accepted plan is applicable in every order and has one final state. A plan with these properties is
            // rejected only if two orders differ at an intermediate position.
            let fine = possible && ends.len() == 1;
            let refused = has("precondition") || has("race");
            prop_assert!(fine || refused);
            prop_assert!(!fine || !has("precondition"));
            prop_assert!(ends.len() == 1 || has("race"));
            if !has("race") {
                prop_assert_eq!(possible, !has("precondition"));
            }
        }
    }
}
