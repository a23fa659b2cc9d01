//! Random domains with numbers against an independent simulation and search.
//!
//! A case is a domain with one or two actions' schemas over two objects, drawn as data. It is written as PDDL for this
//! library, and simulated here from the data: its own arithmetic, its own effects, its own Dijkstra search.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use super::{Limits, Outcome, solve};
use crate::goal::{self, GoalError};
use crate::pddl::{Problem, read_problem};
use longstep_model::domain::from_pddl;
use longstep_model::model::{EntityId, State, World};
use longstep_verify::plan::{Plan, Step};
use longstep_verify::verify::{Purpose, Violation, check};

/// A generator of numbers, the same in every run.
struct Draw(u64);

impl Draw {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit
    }

    fn one_in(&mut self, count: u64) -> bool {
        self.below(count) == 0
    }
}

/// One object, or a variable: the parameter of an action, or the variable of a quantifier.
#[derive(Debug, Clone, Copy)]
enum Who {
    A,
    B,
    X,
    Y,
}

#[derive(Debug, Clone)]
enum Value {
    /// Millionths.
    Plain(i64),
    Level(Who),
    /// A function that no action changes.
    Rate(Who),
    Charge,
    Operation(char, Box<Value>, Box<Value>),
}

#[derive(Debug, Clone)]
enum Test {
    All(Vec<Test>),
    Any(Vec<Test>),
    Not(Box<Test>),
    Fact(usize, Who),
    Compare(&'static str, Value, Value),
    Each(Box<Test>),
}

#[derive(Debug, Clone)]
enum Change {
    Fact(usize, Who, bool),
    /// None for the charge.
    Number(&'static str, Option<Who>, Value),
    When(Test, Box<Change>),
    Each(Box<Change>),
}

#[derive(Debug, Clone)]
struct Schema {
    requires: Test,
    changes: Vec<Change>,
    cost: Option<Value>,
}

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Situation {
    facts: [bool; 4],
    levels: [Option<i64>; 2],
    charge: Option<i64>,
}

/// The objects of the parameter and of the quantifier.
type Bound = [usize; 2];

fn object(who: Who, bound: Bound) -> usize {
    match who {
        Who::A => 0,
        Who::B => 1,
        Who::X => bound[0],
        Who::Y => bound[1],
    }
}

struct Case {
    schemas: Vec<Schema>,
    rates: [Option<i64>; 2],
    start: Situation,
    goal: Test,
    /// A comparison of the charge that must not hold in any state.
    never: Option<(&'static str, i64)>,
    has_costs: bool,
}

impl Case {
    fn draw(draw: &mut Draw) -> Self {
        let has_costs = draw.one_in(3);
        let schema = |draw: &mut Draw| Schema {
            requires: test(draw, 2, &[Who::A, Who::B, Who::X]),
            changes: (0..1 + draw.below(3))
                .map(|_| change(draw, 2, &[Who::A, Who::B, Who::X]))
                .collect(),
            cost: (has_costs && !draw.one_in(4)).then(|| {
                if draw.one_in(2) {
                    Value::Rate(Who::X)
                } else {
                    Value::Plain(draw.below(5) as i64 * 250_000)
                }
            }),
        };
        let schemas: Vec<Schema> = (0..1 + draw.below(3)).map(|_| schema(draw)).collect();
        let has_costs = schemas.iter().any(|schema| schema.cost.is_some());
        let number = |draw: &mut Draw| (!draw.one_in(8)).then(|| plain(draw));
        let rate = |draw: &mut Draw| (!draw.one_in(8)).then(|| plain(draw).abs());
        Self {
            schemas,
            rates: [rate(draw), rate(draw)],
            start: Situation {
                facts: std::array::from_fn(|_| draw.one_in(2)),
                levels: [number(draw), number(draw)],
                charge: number(draw),
            },
            goal: test(draw, 2, &[Who::A, Who::B]),
            never: draw.one_in(4).then(|| (comparison(draw), plain(draw))),
            has_costs,
        }
    }

    fn value(&self, value: &Value, at: &Situation, bound: Bound) -> Option<i64> {
        match value {
            Value::Plain(number) => Some(*number),
            Value::Level(who) => at.levels[object(*who, bound)],
            Value::Rate(who) => self.rates[object(*who, bound)],
            Value::Charge => at.charge,
            Value::Operation(operation, left, right) => {
                let left = i128::from(self.value(left, at, bound)?);
                let right = i128::from(self.value(right, at, bound)?);
                let nearest = |top: i128, bottom: i128| {
                    let (top, bottom) = if bottom < 0 { (-top, -bottom) } else { (top, bottom) };
                    let (whole, rest) = (top.div_euclid(bottom), top.rem_euclid(bottom));
                    match (2 * rest).cmp(&bottom) {
                        std::cmp::Ordering::Less => whole,
                        std::cmp::Ordering::Greater => whole + 1,
                        std::cmp::Ordering::Equal => whole + i128::from(top >= 0),
                    }
                };
                let result = match operation {
                    '+' => left + right,
                    '-' => left - right,
                    '*' => nearest(left * right, 1_000_000),
                    _ if right == 0 => return None,
                    _ => nearest(left * 1_000_000, right),
                };
                i64::try_from(result).ok().filter(|number| *number != i64::MIN)
            }
        }
    }

    /// Evaluates a test, or its negation: a comparison of unknown numbers is false either way.
    fn holds(&self, test: &Test, positive: bool, at: &Situation, bound: Bound) -> bool {
        match test {
            Test::All(parts) if positive => parts.iter().all(|part| self.holds(part, true, at, bound)),
            Test::Any(parts) if !positive => parts.iter().all(|part| self.holds(part, false, at, bound)),
            Test::All(parts) | Test::Any(parts) => parts.iter().any(|part| self.holds(part, positive, at, bound)),
            Test::Not(inner) => self.holds(inner, !positive, at, bound),
            Test::Fact(fact, who) => at.facts[2 * fact + object(*who, bound)] == positive,
            Test::Each(inner) => {
                let mut each = (0..2).map(|other| self.holds(inner, positive, at, [bound[0], other]));
                if positive {
                    each.all(|own| own)
                } else {
                    each.any(|own| own)
                }
            }
            Test::Compare(comparison, left, right) => {
                match (self.value(left, at, bound), self.value(right, at, bound)) {
                    (Some(left), Some(right)) => compares(comparison, left, right) == positive,
                    _ => false,
                }
            }
        }
    }

    /// Collects the changes that fire.
    fn fired(
        &self,
        change: &Change,
        at: &Situation,
        bound: Bound,
        facts: &mut Vec<(usize, bool)>,
        numbers: &mut Vec<(usize, &'static str, Option<i64>)>,
    ) {
        match change {
            Change::Fact(fact, who, holds) => facts.push((2 * fact + object(*who, bound), *holds)),
            Change::Number(kind, who, value) => {
                let place = who.map_or(2, |who| object(who, bound));
                numbers.push((place, kind, self.value(value, at, bound)));
            }
            Change::When(test, inner) => {
                if self.holds(test, true, at, bound) {
                    self.fired(inner, at, bound, facts, numbers);
                }
            }
            Change::Each(inner) => (0..2).for_each(|other| self.fired(inner, at, [bound[0], other], facts, numbers)),
        }
    }

    /// Returns the situation after a step; none if it is not applicable.
    fn after(&self, schema: usize, x: usize, at: &Situation) -> Option<Situation> {
        let own = &self.schemas[schema];
        if !self.holds(&own.requires, true, at, [x, 0]) || self.cost(schema, x).is_none() {
            return None;
        }
        let (mut facts, mut numbers) = (Vec::new(), Vec::new());
        own.changes
            .iter()
            .for_each(|change| self.fired(change, at, [x, 0], &mut facts, &mut numbers));
        let mut next = at.clone();
        facts.sort_by_key(|(_, holds)| *holds);
        facts.into_iter().for_each(|(place, holds)| next.facts[place] = holds);
        for place in 0..3 {
            let of_place = || numbers.iter().filter(move |(own, ..)| *own == place);
            let before = if place < 2 { at.levels[place] } else { at.charge };
            let assigned: BTreeSet<Option<i64>> = of_place()
                .filter(|(_, kind, _)| *kind == "assign")
                .map(|(.., value)| *value)
                .collect();
            let moves = of_place().filter(|(_, kind, _)| *kind != "assign").count();
            let new = match (assigned.len(), moves) {
                (0, 0) => continue,
                (1, 0) => assigned.into_iter().next().flatten()?,
                (0, _) => of_place().try_fold(before?, |sum, (_, kind, value)| match *kind {
                    "increase" => sum.checked_add((*value)?),
                    _ => sum.checked_sub((*value)?),
                })?,
                _ => return None,
            };
            match place {
                2 => next.charge = Some(new),
                _ => next.levels[place] = Some(new),
            }
        }
        Some(next)
    }

    /// Returns the cost of a step; none if it is unknown.
    fn cost(&self, schema: usize, x: usize) -> Option<i64> {
        match &self.schemas[schema].cost {
            None => Some(0),
            Some(cost) => self.value(cost, &self.start, [x, 0]),
        }
    }

    fn is_kept(&self, at: &Situation) -> bool {
        match (&self.never, at.charge) {
            (None, _) => true,
            (Some(_), None) => false,
            (Some((comparison, number)), Some(charge)) => !compares(comparison, charge, *number),
        }
    }

    /// Returns the steps from a situation that keep the rule.
    fn successors(&self, at: &Situation) -> Vec<(usize, usize, Situation)> {
        let all = (0..self.schemas.len()).flat_map(|schema| [(schema, 0), (schema, 1)]);
        let next = all.filter_map(|(schema, x)| Some((schema, x, self.after(schema, x, at)?)));
        next.filter(|(_, _, next)| !self.is_kept(at) || self.is_kept(next))
            .collect()
    }

    /// Searches with costs, then steps. `Ok` with the best cost and steps, or with none if no situation is left; `Err` if
    /// the limit is reached.
    fn best(&self, limit: usize) -> Result<Option<(i64, usize)>, ()> {
        let mut open: BTreeMap<(i64, usize, Situation), ()> = BTreeMap::new();
        let mut closed: BTreeSet<Situation> = BTreeSet::new();
        open.insert((0, 0, self.start.clone()), ());
        while let Some(((cost, steps, at), ())) = open.pop_first() {
            if self.holds(&self.goal, true, &at, [0, 0]) {
                return Ok(Some((cost, steps)));
            }
            if !closed.insert(at.clone()) {
                continue;
            }
            if closed.len() > limit {
                return Err(());
            }
            for (schema, x, next) in self.successors(&at) {
                if !closed.contains(&next) {
                    let cost = cost
                        + if self.has_costs {
                            self.cost(schema, x).unwrap_or(0)
                        } else {
                            1
                        };
                    open.insert((cost, steps + 1, next), ());
                }
            }
        }
        Ok(None)
    }

    fn domain(&self) -> String {
        let mut text = "(define (domain cases) (:requirements :adl :numeric-fluents)\n(:constants a b)\n(:predicates (p ?x) (q ?x))\n\
            (:functions (level ?x) - number (rate ?x) (charge)"
            .to_owned();
        if self.has_costs {
            text.push_str(" (total-cost)");
        }
        text.push(')');
        for (number, schema) in self.schemas.iter().enumerate() {
            let changes: Vec<String> = schema.changes.iter().map(change_text).collect();
            let cost = schema.cost.as_ref().map_or_else(String::new, |cost| {
                format!(" (increase (total-cost) {})", value_text(cost))
            });
            let _ = write!(
                text,
                "\n(:action do{number} :parameters (?x)\n :precondition {}\n :effect (and {}{cost}))",
                test_text(&schema.requires),
                changes.join(" ")
            );
        }
        text.push(')');
        text
    }

    fn problem(&self) -> String {
        let mut text = "(define (problem p) (:domain cases)\n(:init".to_owned();
        for (place, name) in ["(p a)", "(p b)", "(q a)", "(q b)"].iter().enumerate() {
            if self.start.facts[place] {
                let _ = write!(text, " {name}");
            }
        }
        let numbers = [
            ("(level a)", self.start.levels[0]),
            ("(level b)", self.start.levels[1]),
            ("(charge)", self.start.charge),
            ("(rate a)", self.rates[0]),
            ("(rate b)", self.rates[1]),
        ];
        for (name, number) in numbers {
            if let Some(number) = number {
                let _ = write!(text, " (= {name} {})", number_text(number));
            }
        }
        let _ = write!(text, ")\n(:goal {}))", test_text(&self.goal));
        text
    }
}

fn compares(comparison: &str, left: i64, right: i64) -> bool {
    match comparison {
        "<" => left < right,
        "<=" => left <= right,
        "=" => left == right,
        ">=" => left >= right,
        _ => left > right,
    }
}

fn comparison(draw: &mut Draw) -> &'static str {
    ["<", "<=", "=", ">=", ">"][draw.below(5) as usize]
}

/// A small number, often whole.
fn plain(draw: &mut Draw) -> i64 {
    match draw.below(6) {
        0 => (draw.below(21) as i64 - 10) * 100_000,
        _ => (draw.below(9) as i64 - 3) * 1_000_000,
    }
}

fn pick(draw: &mut Draw, scope: &[Who]) -> Who {
    scope[draw.below(scope.len() as u64) as usize]
}

fn value(draw: &mut Draw, depth: usize, scope: &[Who]) -> Value {
    match draw.below(if depth == 0 { 5 } else { 7 }) {
        0 | 1 => Value::Level(pick(draw, scope)),
        2 => Value::Charge,
        3 => Value::Rate(pick(draw, scope)),
        4 => Value::Plain(plain(draw)),
        _ => {
            let operation = ['+', '-', '*', '/'][draw.below(4) as usize];
            let sides = (value(draw, depth - 1, scope), value(draw, depth - 1, scope));
            Value::Operation(operation, Box::new(sides.0), Box::new(sides.1))
        }
    }
}

fn test(draw: &mut Draw, depth: usize, scope: &[Who]) -> Test {
    let parts = |draw: &mut Draw| (0..1 + draw.below(3)).map(|_| test(draw, depth - 1, scope)).collect();
    match draw.below(if depth == 0 { 4 } else { 8 }) {
        0 => Test::Fact(draw.below(2) as usize, pick(draw, scope)),
        1 => Test::Compare(comparison(draw), value(draw, 1, scope), value(draw, 1, scope)),
        2 | 3 => Test::Compare(comparison(draw), value(draw, 0, scope), Value::Plain(plain(draw))),
        4 | 5 => Test::All(parts(draw)),
        6 => {
            if draw.one_in(2) {
                Test::Any(parts(draw))
            } else {
                Test::Not(Box::new(test(draw, depth - 1, scope)))
            }
        }
        _ if scope.iter().any(|who| matches!(who, Who::Y)) => Test::Any(parts(draw)),
        _ => {
            let inner: Vec<Who> = scope.iter().copied().chain([Who::Y, Who::Y]).collect();
            Test::Each(Box::new(test(draw, depth - 1, &inner)))
        }
    }
}

fn change(draw: &mut Draw, depth: usize, scope: &[Who]) -> Change {
    match draw.below(if depth == 0 { 5 } else { 7 }) {
        0 => Change::Fact(draw.below(2) as usize, pick(draw, scope), draw.one_in(2)),
        1..=4 => {
            let kind = ["assign", "increase", "increase", "decrease", "decrease"][draw.below(5) as usize];
            let who = (!draw.one_in(3)).then(|| pick(draw, scope));
            // Mostly constant, as numbers in robots' domains are.
            let value = if draw.one_in(3) {
                value(draw, 1, scope)
            } else {
                Value::Plain(plain(draw))
            };
            Change::Number(kind, who, value)
        }
        5 => Change::When(test(draw, 1, scope), Box::new(change(draw, depth - 1, scope))),
        _ if scope.iter().any(|who| matches!(who, Who::Y)) => change(draw, depth - 1, scope),
        _ => {
            let inner: Vec<Who> = scope.iter().copied().chain([Who::Y, Who::Y]).collect();
            Change::Each(Box::new(change(draw, depth - 1, &inner)))
        }
    }
}

fn who_text(who: Who) -> &'static str {
    match who {
        Who::A => "a",
        Who::B => "b",
        Who::X => "?x",
        Who::Y => "?y",
    }
}

fn number_text(millionths: i64) -> String {
    let sign = if millionths < 0 { "-" } else { "" };
    format!(
        "{sign}{}.{:06}",
        millionths.abs() / 1_000_000,
        millionths.abs() % 1_000_000
    )
}

fn value_text(value: &Value) -> String {
    match value {
        Value::Plain(number) => number_text(*number),
        Value::Level(who) => format!("(level {})", who_text(*who)),
        Value::Rate(who) => format!("(rate {})", who_text(*who)),
        Value::Charge => "(charge)".to_owned(),
        Value::Operation(operation, left, right) => {
            format!("({operation} {} {})", value_text(left), value_text(right))
        }
    }
}

fn test_text(test: &Test) -> String {
    let all = |parts: &[Test]| parts.iter().map(test_text).collect::<Vec<_>>().join(" ");
    match test {
        Test::All(parts) => format!("(and {})", all(parts)),
        Test::Any(parts) => format!("(or {})", all(parts)),
        Test::Not(inner) => format!("(not {})", test_text(inner)),
        Test::Fact(fact, who) => format!("({} {})", ["p", "q"][*fact], who_text(*who)),
        Test::Compare(comparison, left, right) => format!("({comparison} {} {})", value_text(left), value_text(right)),
        Test::Each(inner) => format!("(forall (?y) {})", test_text(inner)),
    }
}

fn change_text(change: &Change) -> String {
    match change {
        Change::Fact(fact, who, true) => test_text(&Test::Fact(*fact, *who)),
        Change::Fact(fact, who, false) => format!("(not {})", test_text(&Test::Fact(*fact, *who))),
        Change::Number(kind, who, value) => {
            let fluent = who.map_or_else(|| "(charge)".to_owned(), |who| format!("(level {})", who_text(who)));
            format!("({kind} {fluent} {})", value_text(value))
        }
        Change::When(test, inner) => format!("(when {} {})", test_text(test), change_text(inner)),
        Change::Each(inner) => format!("(forall (?y) {})", change_text(inner)),
    }
}

/// Returns the situation that a state describes.
fn situation(state: &State) -> Situation {
    use longstep_model::model::{Fact, Fluent, FunctionId, PredicateId};
    let entity = |place: usize| EntityId::new(place);
    let number = |function: usize, arguments: &[EntityId]| {
        let fluent = Fluent::new(FunctionId::new(function), arguments.iter().copied());
        state.number(fluent).map(|number| number.millionths())
    };
    Situation {
        facts: std::array::from_fn(|place| state.holds(Fact::new(PredicateId::new(place / 2), [entity(place % 2)]))),
        levels: [number(0, &[entity(0)]), number(0, &[entity(1)])],
        charge: number(2, &[]),
    }
}

fn steps_of(world: &World, steps: &[(usize, usize)]) -> Vec<Step> {
    let ids: Vec<_> = world.domain().action_ids().map(|(id, _)| id).collect();
    let step = |(schema, x): &(usize, usize)| Step::explained(world, ids[*schema], vec![EntityId::new(*x)]);
    steps.iter().map(step).collect()
}

/// Compares the verdict on a random sequence of steps with the independent simulation.
fn check_steps(case: &Case, world: &World, draw: &mut Draw) {
    let choices = case.schemas.len() as u64;
    let steps: Vec<(usize, usize)> = (0..1 + draw.below(5))
        .map(|_| (draw.below(choices) as usize, draw.below(2) as usize))
        .collect();
    let report = check(world, Plan::sequence(steps_of(world, &steps)), &Purpose::default());
    let inapplicable = report.violations.first().map(|violation| match violation {
        Violation::Precondition { step, .. } => *step,
        other => panic!("{other:?}\n{}\n{}", case.domain(), case.problem()),
    });
    let mut at = case.start.clone();
    for (number, (schema, x)) in steps.iter().enumerate() {
        match case.after(*schema, *x, &at) {
            Some(next) => at = next,
            None => {
                assert_eq!(
                    inapplicable,
                    Some(number),
                    "{steps:?}\n{}\n{}",
                    case.domain(),
                    case.problem()
                );
                return;
            }
        }
    }
    assert_eq!(inapplicable, None, "{steps:?}\n{}\n{}", case.domain(), case.problem());
    assert_eq!(
        situation(&report.ending().after),
        at,
        "{steps:?}\n{}\n{}",
        case.domain(),
        case.problem()
    );
}

/// Counts of the outcomes of searches.
#[derive(Debug, Default)]
struct Counts {
    solved: usize,
    unsolvable: usize,
    gave_up: usize,
    beyond: usize,
}

impl Counts {
    fn add(&mut self, more: &Self) {
        self.solved += more.solved;
        self.unsolvable += more.unsolvable;
        self.gave_up += more.gave_up;
        self.beyond += more.beyond;
    }
}

fn check_search(case: &Case, problem: &Problem, counts: &mut Counts) {
    let shown = || format!("{:?}\n{}\n{}", case.never, case.domain(), case.problem());
    let world = match &case.never {
        None => problem.world.clone(),
        Some((comparison, number)) => {
            let rule = format!("never charge {comparison} {}", number_text(*number));
            match goal::rules(&problem.world, &rule) {
                Ok(rules) => problem.world.with_prohibitions(rules),
                // No action changes the charge: the rule forbids nothing.
                Err(GoalError::NeverHolds { .. }) => problem.world.clone(),
                Err(error) => panic!("{rule}: {error}"),
            }
        }
    };
    let limits = Limits {
        effort: Limits::default().effort,
        direct: 300,
        proof: 300,
        shortest: 600,
        any: 600,
    };
    let best = case.best(1_500);
    let outcome = solve(&world, &Purpose::from(problem), &limits);
    match (&outcome, best) {
        (Outcome::GaveUp { .. }, _) => counts.gave_up += 1,
        (Outcome::ProvenUnsolvable { .. }, Ok(None)) => counts.unsolvable += 1,
        // No situation up to the limit of this search is a goal.
        (Outcome::ProvenUnsolvable { .. }, Err(())) => counts.beyond += 1,
        (Outcome::ProvenUnsolvable { .. }, Ok(Some(best))) => panic!("unsolvable, not {best:?}\n{}", shown()),
        (
            Outcome::Solved {
                plan, cost, shortest, ..
            },
            best,
        ) => {
            let report = check(&world, plan.clone(), &Purpose::from(problem));
            assert_eq!(report.violations, [], "{}", shown());
            assert_eq!(*cost, report.cost(), "{}", shown());
            let (mut at, mut spent) = (case.start.clone(), 0);
            for step in plan.steps() {
                let (schema, x) = (step.action.index(), step.arguments[0].index());
                spent += case.cost(schema, x).unwrap();
                at = case
                    .after(schema, x, &at)
                    .unwrap_or_else(|| panic!("{schema} {x}\n{}", shown()));
            }
            assert!(case.holds(&case.goal, true, &at, [0, 0]), "{}", shown());
            let steps = plan.steps().len();
            let own = if case.has_costs { spent } else { steps as i64 };
            assert_eq!(
                cost.map(|cost| cost.millionths()),
                case.has_costs.then_some(spent),
                "{}",
                shown()
            );
            match best {
                Ok(None) => panic!("solved, and there is no plan\n{}", shown()),
                Ok(Some((best, fewest))) if *shortest => {
                    assert_eq!(own, best, "{}", shown());
                    assert!(case.has_costs || steps == fewest, "{}", shown());
                }
                Ok(Some((best, _))) => assert!(own >= best, "{}", shown()),
                Err(()) => {}
            }
            counts.solved += 1;
        }
    }
}

/// Runs cases from a seed; returns the counts.
fn run(seed: u64, cases: usize) -> Counts {
    let mut draw = Draw(seed);
    let mut counts = Counts::default();
    for _ in 0..cases {
        let mut case = Case::draw(&mut draw);
        let (domain, problem) = (case.domain(), case.problem());
        let domain = from_pddl("domain.pddl", &domain).unwrap_or_else(|error| panic!("{error}\n{domain}"));
        let problem = read_problem(&domain, "p.pddl", &problem).unwrap_or_else(|error| panic!("{error}\n{problem}"));
        let start = situation(&problem.world.state);
        // A number that nothing reads begins at 0.
        if case.start.charge.is_none() && start.charge == Some(0) {
            case.start.charge = start.charge;
        }
        assert_eq!(start, case.start);
        for _ in 0..4 {
            check_steps(&case, &problem.world, &mut draw);
        }
        check_search(&case, &problem, &mut counts);
    }
    counts
}

#[test]
fn random_domains_agree_with_an_independent_simulation_and_search() {
    let counts = run(1, 400);
    // Both outcomes are common, and giving up is not.
    assert!(
        counts.solved > 100 && counts.unsolvable > 60 && counts.gave_up < 60,
        "{counts:?}"
    );
}

/// `LONGSTEP_NUMBER_CASES=20000 cargo test -p longstep-core --release --lib more_random -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes"]
fn more_random_domains() {
    let cases = std::env::var("LONGSTEP_NUMBER_CASES").map_or(2_000, |text| text.parse().unwrap());
    let mut total = Counts::default();
    let mut failing = Vec::new();
    for seed in 0..cases / 50 {
        match std::panic::catch_unwind(|| run(seed + 100, 50)) {
            Ok(counts) => total.add(&counts),
            Err(_) => failing.push(seed + 100),
        }
    }
    println!("{cases} cases: {total:?}");
    assert_eq!(failing, Vec::<u64>::new());
}
