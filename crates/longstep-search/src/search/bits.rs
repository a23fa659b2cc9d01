//! States as bit sets.

use super::formula::Literal;
use super::task::Task;
use longstep_model::model::Number;

/// A state or a set of facts: one bit for each fact of the task, then one word for each of its numbers.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Bits(Box<[u64]>);

/// The word of a variable without a number; no number has as many millionths.
const UNKNOWN: u64 = i64::MIN as u64;

/// Returns the number of words for the facts of a task.
fn fact_words(task: &Task) -> usize {
    task.initial.len().div_ceil(64)
}

impl Bits {
    /// Returns the state in which none of the facts hold, with all numbers zero.
    pub(super) fn none(task: &Task) -> Self {
        Self(vec![0; fact_words(task) + task.numbers.initial.len()].into())
    }

    /// Work units for storing a state: three copies of its bits and the search data.
    pub(super) fn units(task: &Task) -> usize {
        32 + task.initial.len() / 16 + 4 * task.numbers.initial.len()
    }

    /// Returns the number of a variable; none if it has none.
    pub(super) fn number(&self, task: &Task, variable: u32) -> Option<Number> {
        Number::of_millionths(self.0[fact_words(task) + variable as usize] as i64)
    }

    /// Sets the number of a variable.
    pub(super) fn set_number(&mut self, task: &Task, variable: u32, number: Option<Number>) {
        let word = number.map_or(UNKNOWN, |number| number.millionths() as u64);
        self.0[fact_words(task) + variable as usize] = word;
    }

    pub(super) fn holds(&self, fact: u32) -> bool {
        self.0[fact as usize / 64] >> (fact % 64) & 1 == 1
    }

    pub(super) fn is(&self, literal: Literal) -> bool {
        self.holds(literal.fact) == literal.holds
    }

    pub(super) fn set(&mut self, literal: Literal) {
        let bit = 1 << (literal.fact % 64);
        let word = &mut self.0[literal.fact as usize / 64];
        if literal.holds {
            *word |= bit;
        } else {
            *word &= !bit;
        }
    }

    /// Returns the facts that hold in `self` and not in `others`.
    pub(super) fn without(&self, others: &Bits) -> Bits {
        Bits(
            self.0
                .iter()
                .zip(&others.0)
                .map(|(word, other)| word & !other)
                .collect(),
        )
    }

    /// Iterates over the facts, of which the task has `facts`, that two states differ in.
    pub(super) fn changed_facts(&self, other: &Bits, facts: usize) -> impl Iterator<Item = u32> {
        // Rules mention numbers by tests only, which are facts, so the words of numbers are left out.
        let words = self.0.iter().zip(&other.0).take(facts.div_ceil(64)).enumerate();
        words.flat_map(|(word, (one, other))| {
            let mut bits = one ^ other;
            std::iter::from_fn(move || {
                let fact = (bits != 0).then(|| word as u32 * 64 + bits.trailing_zeros())?;
                bits &= bits - 1;
                Some(fact)
            })
        })
    }

    /// Returns true if `self` equals `better` in all facts where it differs from `other`.
    pub(super) fn no_worse_than(&self, other: &Bits, better: &Bits) -> bool {
        let mut words = self.0.iter().zip(&other.0).zip(&better.0);
        words.all(|((word, other), better)| (word ^ other) & (word ^ better) == 0)
    }
}
