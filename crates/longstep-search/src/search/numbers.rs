//! Numbers in a search task.
//!
//! A number is a variable of the state. Each requirement on numbers is an auxiliary fact, the test, which is computed again
//! after every step, so conditions have nothing but facts. An operator that may change a test has an effect on it that is
//! marked [`GroundEffect::may`]. Such an effect is never applied; it tells the analyses of a task (delete relaxation,
//! relevance, landmark cuts, dominance) that the operator may make the test true or false. So a heuristic based on the
//! delete relaxation stays admissible, and an operator that a test depends on is not removed.
//!
//! An increase by a positive constant can make `level >= 5` true and never false. An assignment of 2 makes it false, and it
//! may make it true later: the increase by 3 after it does. If some number may grow without bound, or an effect is not
//! constant, every effect on a variable may change every test of it in both ways.

use rustc_hash::{FxHashMap, FxHashSet};

use super::formula::Literal;
use super::operator::{GroundEffect, GroundNumericEffect, Operator, VariableExpression};
use longstep_model::effort;
use longstep_model::model::{
    Arithmetic, Comparison, Fluent, GroundExpression, GroundTest, Number, NumberChangeKind, NumberTest, Operation,
};

/// Numbers below this size, in ones, do not leave the range of [`Number`] by constant changes within any search.
// Numbers range to nine million times this, and no search looks at plans of so many steps.
const TAME: i32 = 1_000_000;

/// A requirement on numbers, and the fact with its value.
#[derive(Debug, Clone)]
pub(crate) struct Test {
    pub(crate) fact: u32,
    pub(crate) test: NumberTest<u32>,
}

/// The numbers of a task.
#[derive(Debug, Clone, Default)]
pub(crate) struct Numbers {
    /// By variable: its number in the initial state.
    pub(crate) initial: Vec<Option<Number>>,
    pub(crate) tests: Vec<Test>,
}

impl Numbers {
    /// Returns the numbers after an operator, given those before it; none if an effect cannot be computed, which the
    /// precondition excludes.
    pub(super) fn after(
        operator: &Operator,
        before: &impl Fn(u32) -> Option<Number>,
        holds: &impl Fn(Literal) -> bool,
    ) -> Option<Vec<(u32, Number)>> {
        let mut after: Vec<(u32, Number)> = Vec::with_capacity(operator.numeric.len());
        for effect in operator.numeric.iter().filter(|effect| effect.condition.holds(holds)) {
            let value = effect.value.evaluate(&|variable: &u32| before(*variable))?;
            let place = after.iter().position(|(variable, _)| *variable == effect.variable);
            let current = place.map_or_else(|| before(effect.variable), |place| Some(after[place].1));
            let number = match effect.kind {
                NumberChangeKind::Assign => value,
                NumberChangeKind::Increase => current?.plus(value)?,
                NumberChangeKind::Decrease => current?.minus(value)?,
            };
            match place {
                Some(place) => after[place].1 = number,
                None => after.push((effect.variable, number)),
            }
        }
        Some(after)
    }

    /// Marks the tests that each operator may change.
    fn mark_changes(&self, operators: &mut [Operator]) {
        let is_tame = self.is_tame(operators);
        let depends = depends(operators, self.initial.len());
        // A variable that has no number and is never assigned one stays without: its tests are false for ever.
        let mut known: Vec<bool> = self.initial.iter().map(Option::is_some).collect();
        for effect in operators.iter().flat_map(|operator| &operator.numeric) {
            known[effect.variable as usize] |= effect.kind == NumberChangeKind::Assign;
        }
        let mut by_variable: Vec<Vec<(usize, bool)>> = vec![Vec::new(); self.initial.len()];
        for (index, test) in self.tests.iter().enumerate() {
            let mut is_known = true;
            test.test
                .for_each(&mut |variable| is_known &= known[*variable as usize]);
            // Such a test has one value in every state, so no operator changes it.
            if !is_known || is_tame && self.is_always_known(&test.test) {
                continue;
            }
            let mut direct: FxHashSet<u32> = FxHashSet::default();
            test.test.for_each(&mut |variable| {
                direct.insert(*variable);
            });
            let indirect: FxHashSet<u32> = direct
                .iter()
                .flat_map(|variable| depends[*variable as usize].iter().copied())
                .collect();
            for variable in 0..self.initial.len() as u32 {
                // A change that reaches the test through another variable has no known direction.
                if indirect.contains(&variable) {
                    by_variable[variable as usize].push((index, false));
                } else if direct.contains(&variable) {
                    by_variable[variable as usize].push((index, is_tame));
                }
            }
        }
        // By test: the values that changes other than assignments may give to it.
        let mut moved = vec![[false; 2]; self.tests.len()];
        for effect in operators.iter().flat_map(|operator| &operator.numeric) {
            for (index, _) in &by_variable[effect.variable as usize] {
                if effect.kind != NumberChangeKind::Assign {
                    let [to_false, to_true] = outcomes(&self.tests[*index].test, effect);
                    moved[*index][0] |= to_false;
                    moved[*index][1] |= to_true;
                }
            }
        }
        for operator in operators {
            let mut marks: Vec<GroundEffect> = Vec::new();
            for effect in &operator.numeric {
                for (index, by_direction) in &by_variable[effect.variable as usize] {
                    let Test { fact, test } = &self.tests[*index];
                    let mut can = match by_direction {
                        true => outcomes(test, effect),
                        false => [true; 2],
                    };
                    if effect.kind == NumberChangeKind::Assign {
                        // The distance to the other value is a different one afterwards.
                        can = [can[0] || moved[*index][0], can[1] || moved[*index][1]];
                    }
                    for holds in [false, true].into_iter().filter(|holds| can[usize::from(*holds)]) {
                        effort::spend(effort::KEPT);
                        marks.push(GroundEffect {
                            condition: effect.condition.clone(),
                            literal: Literal { fact: *fact, holds },
                            may: true,
                        });
                    }
                }
            }
            marks.sort();
            marks.dedup();
            operator.effects.extend(marks);
        }
    }

    /// Returns true if all changes are constant and small, so that no number leaves its range.
    fn is_tame(&self, operators: &[Operator]) -> bool {
        let limit = Number::from(TAME);
        let small = |number: Number| Number::ZERO.minus(limit).is_some_and(|least| number > least) && number < limit;
        let mut effects = operators.iter().flat_map(|operator| &operator.numeric);
        self.initial.iter().flatten().all(|number| small(*number))
            && effects.all(|effect| matches!(effect.value, Arithmetic::Constant(number) if small(number)))
    }

    /// Returns true if all tame numbers have a value for the test: sums and differences of variables that have numbers.
    fn is_always_known(&self, test: &NumberTest<u32>) -> bool {
        match test {
            NumberTest::Known(expression, _) => self.is_linear(expression),
            NumberTest::Compare(..) => false,
        }
    }

    fn is_linear(&self, expression: &VariableExpression) -> bool {
        match expression {
            Arithmetic::Constant(number) => *number < Number::from(TAME) && Number::from(-TAME) < *number,
            Arithmetic::Value(variable) => self.initial[*variable as usize].is_some(),
            Arithmetic::Operation(Operation::Plus | Operation::Minus, left, right) => {
                self.is_linear(left) && self.is_linear(right)
            }
            Arithmetic::Operation(..) => false,
        }
    }

    /// By variable: true if a test with one of these facts depends on it.
    pub(super) fn needed(&self, operators: &[Operator], stays: &impl Fn(u32) -> bool) -> Vec<bool> {
        let depends = depends(operators, self.initial.len());
        let mut needed = vec![false; self.initial.len()];
        for test in self.tests.iter().filter(|test| stays(test.fact)) {
            test.test.for_each(&mut |variable| {
                needed[*variable as usize] = true;
                depends[*variable as usize]
                    .iter()
                    .for_each(|other| needed[*other as usize] = true);
            });
        }
        needed
    }

    /// Keeps the tests with these facts and the variables that they depend on; renumbers both. `fact` gives the new number
    /// of a fact that stays.
    pub(super) fn keep(&mut self, operators: &mut [Operator], fact: impl Fn(u32) -> Option<u32>) {
        let needed = self.needed(operators, &|number| fact(number).is_some());
        self.tests.retain_mut(|test| {
            let number = fact(test.fact);
            test.fact = number.unwrap_or_default();
            number.is_some()
        });
        let mut numbers: Vec<u32> = vec![0; needed.len()];
        let mut initial = Vec::new();
        for (variable, _) in needed.iter().enumerate().filter(|(_, needed)| **needed) {
            numbers[variable] = initial.len() as u32;
            initial.push(self.initial[variable]);
        }
        let again = |variable: &u32| Arithmetic::Value(numbers[*variable as usize]);
        for test in &mut self.tests {
            test.test = test.test.map(&mut { again });
        }
        for operator in operators {
            operator.numeric.retain(|effect| needed[effect.variable as usize]);
            for effect in &mut operator.numeric {
                effect.variable = numbers[effect.variable as usize];
                effect.value = effect.value.map(&mut { again });
            }
        }
        self.initial = initial;
    }
}

/// By variable: the variables that its effects read, directly or through others.
fn depends(operators: &[Operator], variables: usize) -> Vec<FxHashSet<u32>> {
    let mut depends: Vec<FxHashSet<u32>> = vec![FxHashSet::default(); variables];
    for effect in operators.iter().flat_map(|operator| &operator.numeric) {
        effect.value.for_each(&mut |other| {
            depends[effect.variable as usize].insert(*other);
        });
    }
    loop {
        let mut changed = false;
        for variable in 0..variables {
            let others: Vec<u32> = depends[variable].iter().copied().collect();
            for other in others {
                let more: Vec<u32> = depends[other as usize].iter().copied().collect();
                if effort::spend(1) {
                    let before = depends[variable].len();
                    depends[variable].extend(more);
                    changed |= depends[variable].len() > before;
                }
            }
        }
        if !changed {
            return depends;
        }
    }
}

/// The direction in which an expression moves when a variable grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Trend {
    Still,
    Up,
    Down,
    Any,
}

impl Trend {
    fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Still, only) | (only, Self::Still) => only,
            (one, other) if one == other => one,
            _ => Self::Any,
        }
    }

    fn reversed(self) -> Self {
        match self {
            Self::Up => Self::Down,
            Self::Down => Self::Up,
            other => other,
        }
    }

    /// Returns the trend of a product with a constant.
    fn times(self, factor: Number) -> Self {
        match factor.cmp(&Number::ZERO) {
            std::cmp::Ordering::Less => self.reversed(),
            std::cmp::Ordering::Equal => Self::Still,
            std::cmp::Ordering::Greater => self,
        }
    }
}

fn trend(expression: &VariableExpression, variable: u32) -> Trend {
    match expression {
        Arithmetic::Constant(_) => Trend::Still,
        Arithmetic::Value(own) if *own == variable => Trend::Up,
        Arithmetic::Value(_) => Trend::Still,
        Arithmetic::Operation(operation, left, right) => {
            let sides = (trend(left, variable), trend(right, variable));
            match (operation, left.as_ref(), right.as_ref()) {
                (Operation::Plus, ..) => sides.0.and(sides.1),
                (Operation::Minus, ..) => sides.0.and(sides.1.reversed()),
                _ if sides == (Trend::Still, Trend::Still) => Trend::Still,
                (Operation::Times, Arithmetic::Constant(factor), _) => sides.1.times(*factor),
                (Operation::Times | Operation::Over, _, Arithmetic::Constant(factor)) => sides.0.times(*factor),
                _ => Trend::Any,
            }
        }
    }
}

/// Returns the values that an effect may directly give to a test of its variable: false, and true.
fn outcomes(test: &NumberTest<u32>, effect: &GroundNumericEffect) -> [bool; 2] {
    // An effect without a known direction counts in both, which keeps bounds and dead ends valid.
    let NumberTest::Compare(left, comparison, right) = test else {
        return [true; 2];
    };
    let Arithmetic::Constant(value) = effect.value else {
        return [true; 2];
    };
    let moved = match effect.kind {
        NumberChangeKind::Assign => {
            // The value decides a test of this variable alone.
            let mut alone = true;
            test.for_each(&mut |own| alone &= *own == effect.variable);
            let holds = test.holds(&|_| Some(value));
            return if alone { [!holds, holds] } else { [true; 2] };
        }
        NumberChangeKind::Increase => Trend::Up.times(value),
        NumberChangeKind::Decrease => Trend::Down.times(value),
    };
    let difference = trend(left, effect.variable).and(trend(right, effect.variable).reversed());
    let moves = match (moved, difference) {
        (Trend::Still, _) | (_, Trend::Still) => Trend::Still,
        (_, Trend::Any) => Trend::Any,
        (Trend::Down, other) => other.reversed(),
        (_, other) => other,
    };
    match (moves, comparison) {
        (Trend::Still, _) => [false; 2],
        (Trend::Up, Comparison::AtLeast | Comparison::Greater) => [false, true],
        (Trend::Up, Comparison::AtMost | Comparison::Less) => [true, false],
        (Trend::Down, Comparison::AtLeast | Comparison::Greater) => [true, false],
        (Trend::Down, Comparison::AtMost | Comparison::Less) => [false, true],
        _ => [true; 2],
    }
}

/// Numbers the fluents and the requirements on them while a task is grounded.
#[derive(Debug, Clone, Default)]
pub(super) struct NumberGrounder {
    variables: FxHashMap<Fluent, u32>,
    fluents: Vec<Fluent>,
    /// The facts of the tests.
    facts: FxHashMap<GroundTest, u32>,
    tests: Vec<(GroundTest, u32)>,
}

impl NumberGrounder {
    fn variable(&mut self, fluent: Fluent) -> u32 {
        *self.variables.entry(fluent).or_insert_with(|| {
            self.fluents.push(fluent);
            (self.fluents.len() - 1) as u32
        })
    }

    /// Returns the expression over variables.
    pub(super) fn expression(&mut self, expression: &GroundExpression) -> VariableExpression {
        expression.map(&mut |fluent| Arithmetic::Value(self.variable(*fluent)))
    }

    /// Returns the variable of a fluent.
    pub(super) fn of_fluent(&mut self, fluent: Fluent) -> u32 {
        self.variable(fluent)
    }

    /// Returns the literal for a requirement; `add` adds its fact if there is none yet.
    pub(super) fn literal(&mut self, test: GroundTest, add: impl FnOnce(&GroundTest) -> u32) -> Literal {
        // Both values of "is known" are one fact. A comparison and its negation are two, since an unknown number makes
        // both false.
        let (test, holds) = match test {
            NumberTest::Known(expression, known) => (NumberTest::Known(expression, true), known),
            compare => (compare, true),
        };
        if let Some(fact) = self.facts.get(&test) {
            return Literal { fact: *fact, holds };
        }
        let fact = add(&test);
        self.facts.insert(test.clone(), fact);
        self.tests.push((test, fact));
        Literal { fact, holds }
    }

    /// Returns the requirements with their facts.
    pub(super) fn tests(&self) -> &[(GroundTest, u32)] {
        &self.tests
    }

    /// Returns the numbers of the task, and marks in the operators the tests that they may change.
    pub(super) fn finish(mut self, number: impl Fn(Fluent) -> Option<Number>, operators: &mut [Operator]) -> Numbers {
        let tests = std::mem::take(&mut self.tests);
        let tests = tests.into_iter().map(|(test, fact)| Test {
            fact,
            test: test.map(&mut |fluent| Arithmetic::Value(self.variable(*fluent))),
        });
        let tests: Vec<Test> = tests.collect();
        let numbers = Numbers {
            initial: self.fluents.iter().map(|fluent| number(*fluent)).collect(),
            tests,
        };
        if !numbers.tests.is_empty() {
            numbers.mark_changes(operators);
        }
        numbers
    }
}
