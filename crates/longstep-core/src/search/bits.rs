//! States as bit sets.

use super::formula::Literal;

/// A state or a set of facts: one bit for each fact of the task.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Bits(Box<[u64]>);

impl Bits {
    /// Returns the state in which none of the facts hold.
    pub(super) fn none(facts: usize) -> Self {
        Self(vec![0; facts.div_ceil(64)].into())
    }

    /// Work units for storing a state: three copies of its bits and the search data.
    pub(super) fn units(facts: usize) -> usize {
        32 + facts / 16
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

    /// Returns true if `self` equals `better` in all facts where it differs from `other`.
    pub(super) fn no_worse_than(&self, other: &Bits, better: &Bits) -> bool {
        let mut words = self.0.iter().zip(&other.0).zip(&better.0);
        words.all(|((word, other), better)| (word ^ other) & (word ^ better) == 0)
    }
}
