//! Contradictions between comparisons of numbers.
//!
//! Comparisons of one number with a constant, and of two numbers, are bounds on differences. Bounds on differences of
//! integers contradict each other exactly if some cycle of them has a negative sum; numbers are integers, in millionths.

use longstep_model::effort;
use longstep_model::model::{Arithmetic, Comparison, Fluent, GroundExpression, GroundTest, Operation};

/// Returns true if no numbers satisfy all requirements, as far as comparisons of one number with a constant, or of two
/// numbers, show.
pub(super) fn are_contradictory<'t>(tests: impl IntoIterator<Item = &'t GroundTest>) -> bool {
    let mut bounds = DifferenceBounds::default();
    let (mut known, mut unknown): (Vec<Fluent>, Vec<&GroundExpression>) = (Vec::new(), Vec::new());
    for test in tests {
        match test {
            // A comparison holds only if both sides are known.
            GroundTest::Compare(left, comparison, right) => {
                test.for_each(&mut |fluent| known.push(*fluent));
                if let (Some(left), Some(right)) = (Difference::of(left), Difference::of(right)) {
                    bounds.add(&left.minus(&right), *comparison);
                }
            }
            GroundTest::Known(expression, true) => expression.for_each(&mut |fluent| known.push(*fluent)),
            GroundTest::Known(expression, false) => unknown.push(expression),
        }
    }
    let mut unknown = unknown.into_iter();
    let is_known_too = unknown.any(|expression| match expression {
        Arithmetic::Constant(_) => true,
        Arithmetic::Value(fluent) => known.contains(fluent),
        Arithmetic::Operation(..) => false,
    });
    is_known_too || bounds.are_contradictory()
}

/// A sum of numbers, each with its sign, and a constant in millionths.
#[derive(Debug, Clone, Default)]
struct Difference {
    added: Vec<Fluent>,
    subtracted: Vec<Fluent>,
    constant: i128,
}

impl Difference {
    /// Returns the sum that an expression is; none for products and quotients.
    fn of(expression: &GroundExpression) -> Option<Self> {
        let mut own = Self::default();
        match expression {
            Arithmetic::Constant(number) => own.constant = i128::from(number.millionths()),
            Arithmetic::Value(fluent) => own.added.push(*fluent),
            Arithmetic::Operation(operation, left, right) => {
                let (left, right) = (Self::of(left)?, Self::of(right)?);
                own = match operation {
                    Operation::Plus => left.minus(&Self::default().minus(&right)),
                    Operation::Minus => left.minus(&right),
                    Operation::Times | Operation::Over => return None,
                };
            }
        }
        Some(own)
    }

    fn minus(&self, other: &Self) -> Self {
        let mut result = Self {
            added: [&self.added[..], &other.subtracted].concat(),
            subtracted: [&self.subtracted[..], &other.added].concat(),
            constant: self.constant - other.constant,
        };
        let mut at = 0;
        while at < result.added.len() {
            match result.subtracted.iter().position(|own| *own == result.added[at]) {
                Some(same) => {
                    result.added.swap_remove(at);
                    result.subtracted.swap_remove(same);
                }
                None => at += 1,
            }
        }
        result
    }
}

/// Bounds on the differences of numbers.
#[derive(Debug, Default)]
struct DifferenceBounds {
    /// The numbers, from 1 on; 0 stands for the number zero.
    fluents: Vec<Fluent>,
    /// The first number minus the second one is at most this.
    most: Vec<(usize, usize, i128)>,
    /// The first number minus the second one is not this.
    not: Vec<(usize, usize, i128)>,
}

impl DifferenceBounds {
    /// Adds the comparison of a difference with zero; ignores sums of more than two numbers.
    fn add(&mut self, difference: &Difference, comparison: Comparison) {
        let (first, second) = match (&difference.added[..], &difference.subtracted[..]) {
            ([], []) => (0, 0),
            ([first], []) => (self.index(*first), 0),
            ([], [second]) => (0, self.index(*second)),
            ([first], [second]) => (self.index(*first), self.index(*second)),
            // Sums of more numbers would need linear programming.
            _ => return,
        };
        let most = -difference.constant;
        let at_most = (first, second, most);
        let at_least = (second, first, -most);
        match comparison {
            Comparison::AtMost => self.most.push(at_most),
            Comparison::Less => self.most.push((first, second, most - 1)),
            Comparison::AtLeast => self.most.push(at_least),
            Comparison::Greater => self.most.push((second, first, -most - 1)),
            Comparison::Equal => self.most.extend([at_most, at_least]),
            Comparison::NotEqual => self.not.push(at_most),
        }
    }

    fn index(&mut self, fluent: Fluent) -> usize {
        let known = self.fluents.iter().position(|own| *own == fluent);
        known.unwrap_or_else(|| {
            self.fluents.push(fluent);
            self.fluents.len() - 1
        }) + 1
    }

    /// Finds the least bound on each difference, by Floyd and Warshall.
    fn are_contradictory(&self) -> bool {
        let count = self.fluents.len() + 1;
        let mut least: Vec<Vec<Option<i128>>> = vec![vec![None; count]; count];
        for (first, second, most) in &self.most {
            let known = &mut least[*first][*second];
            *known = Some(known.map_or(*most, |known| known.min(*most)));
        }
        for middle in 0..count {
            for first in 0..count {
                // Unfinished bounds contradict nothing.
                if !effort::spend(count) {
                    return false;
                }
                for second in 0..count {
                    let (Some(to), Some(from)) = (least[first][middle], least[middle][second]) else {
                        continue;
                    };
                    let sum = to.saturating_add(from);
                    let known = &mut least[first][second];
                    *known = Some(known.map_or(sum, |known| known.min(sum)));
                }
            }
        }
        // A cycle with a negative sum says that a number is less than itself.
        let is_negative = |node: usize| least[node][node].is_some_and(|sum| sum < 0);
        let is_least = |first: usize, second: usize, value: i128| least[first][second] == Some(value);
        (0..count).any(is_negative)
            || self.not.iter().any(|(first, second, value)| {
                if first == second {
                    *value == 0
                } else {
                    is_least(*first, *second, *value) && is_least(*second, *first, -value)
                }
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use longstep_model::model::{FunctionId, Number};

    fn side(word: &str) -> GroundExpression {
        match Number::parse(word) {
            Some(number) => Arithmetic::Constant(number),
            None => Arithmetic::Value(Fluent::new(FunctionId::new(usize::from(word.as_bytes()[0])), [])),
        }
    }

    fn sum(word: &str) -> GroundExpression {
        match word.split_once('+') {
            Some((left, right)) => Arithmetic::operation(Operation::Plus, side(left), side(right)),
            None => side(word),
        }
    }

    fn test(text: &str) -> GroundTest {
        let words: Vec<&str> = text.split(' ').collect();
        match words[..] {
            [left, comparison, right] => {
                GroundTest::Compare(sum(left), Comparison::of(comparison).unwrap(), sum(right))
            }
            [word, known] => GroundTest::Known(sum(word), known == "known"),
            _ => panic!("{text}"),
        }
    }

    #[test]
    fn comparisons_contradict_each_other_if_no_numbers_satisfy_all() {
        for (tests, expected) in [
            ("a > b, b > a", true),
            ("a >= b, b >= a", false),
            ("a >= b, b >= a, a != b", true),
            ("a > b, a = b", true),
            ("a > b, a != b", false),
            ("a > 3, a < 3.000001", true),
            ("a > 3, a < 3.000002", false),
            ("a > b, b >= 5, a <= 5", true),
            ("a > b, b >= 5, a <= 5.000001", false),
            ("a > b, b > c, c > a", true),
            ("a > b, b > c, a > c", false),
            ("a >= b+2, a < 4, b >= 2", true),
            ("a >= b+2, a <= 4, b >= 2", false),
            ("a+b >= 5, a < 1, b < 1", false),
            ("a = a", false),
            ("a != a", true),
            ("a > 3, a unknown", true),
            ("a > 3, b unknown", false),
            ("a known, a unknown", true),
        ] {
            let all: Vec<GroundTest> = tests.split(", ").map(test).collect();
            assert_eq!(are_contradictory(&all), expected, "{tests}");
        }
    }
}
