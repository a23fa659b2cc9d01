//! Budgets of work, which bound the number of elementary steps of every operation.
//!
//! A small input can require an unbounded amount of work: a condition with eight nested quantifiers over forty entities
//! has 40^8 instances. Each operation of the library therefore runs with a budget, counted in *units*. One unit is one
//! fact looked up, one entity tried or one candidate compared, which takes ten to a hundred nanoseconds. An operation
//! that exhausts its budget ends early with a typed result that says so; it never returns a verdict that rests on
//! unfinished work.
//!
//! Budgets count units, never seconds, so the result does not depend on the machine. `docs/reference/limits.md` lists every
//! budget.
//!
//! ```
//! use longstep_model::effort;
//!
//! let spent = effort::within(1_000, || 2 + 2);
//! assert_eq!((spent.result, spent.exhausted), (4, false));
//! ```
//!
//! The counter is local to the thread, for the duration of one call of [`within`]. Conditions are evaluated in about
//! two hundred places, and a parameter for the budget would be in every signature of the library. An operation sets its
//! own budget when it begins, so its result depends only on its arguments.

use std::cell::Cell;

/// The budget of one verification, one binding of hidden arguments, or one environment that is read.
///
/// At 20 to 40 ns per unit this is about half a second.
pub const OPERATION: u64 = 15_000_000;

/// The units charged for keeping a value of a few dozen bytes in memory.
pub const KEPT: usize = 8;

thread_local! {
    static LEFT: Cell<u64> = const { Cell::new(u64::MAX) };
}

/// A result and the work that it took.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Spent<T> {
    /// The result. If the budget was exhausted, it is incomplete and serves only to show the progress.
    pub result: T,
    /// The units that were spent.
    pub units: u64,
    /// True if the budget ran out before the work was done.
    pub exhausted: bool,
}

/// Restores the budget of the enclosing call, less the units spent, even when `work` panics.
struct Enclosing {
    outer: u64,
    limit: u64,
}

impl Drop for Enclosing {
    fn drop(&mut self) {
        LEFT.with(|left| left.set(self.outer - (self.limit - left.get())));
    }
}

/// Runs `work` with at most `limit` units, or with the rest of the enclosing budget if that is less.
///
/// With `u64::MAX` it only measures.
pub fn within<T>(limit: u64, work: impl FnOnce() -> T) -> Spent<T> {
    let outer = left();
    let limit = limit.min(outer);
    let enclosing = Enclosing { outer, limit };
    LEFT.with(|left| left.set(limit));
    let result = work();
    let remaining = left();
    drop(enclosing);
    Spent {
        result,
        units: limit - remaining,
        exhausted: remaining == 0,
    }
}

/// Spends units; returns `false` if the budget is exhausted.
///
/// A loop that gets `false` must end. Its partial result is not used: the operation that set the budget reports that it
/// was exhausted.
#[inline]
pub fn spend(units: usize) -> bool {
    LEFT.with(|left| {
        let remaining = left.get().saturating_sub(units as u64);
        left.set(remaining);
        remaining > 0
    })
}

/// Returns true if the budget is exhausted.
#[inline]
pub fn is_exhausted() -> bool {
    left() == 0
}

/// Returns the rest of the budget.
pub fn left() -> u64 {
    LEFT.with(Cell::get)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_ends_when_its_budget_is_spent() {
        let spent = within(10, || (0..100).take_while(|_| spend(1)).count());
        assert_eq!((spent.result, spent.units, spent.exhausted), (9, 10, true));
        assert!(!is_exhausted(), "the budget ends with the call");
    }

    #[test]
    fn an_inner_budget_is_part_of_the_outer_one() {
        let outer = within(100, || {
            let inner = within(1_000, || spend(30));
            (inner.units, within(u64::MAX, || spend(1_000)).exhausted)
        });
        assert_eq!((outer.result, outer.units, outer.exhausted), ((30, true), 100, true));
    }

    #[test]
    fn a_panic_leaves_the_outer_budget_as_it_was() {
        let outer = within(100, || {
            let caught = std::panic::catch_unwind(|| within(50, || assert!(!spend(50), "as wanted")));
            assert!(caught.is_ok());
            let panicked = std::panic::catch_unwind(|| {
                within(20, || {
                    spend(5);
                    std::panic::resume_unwind(Box::new(()));
                })
            });
            assert!(panicked.is_err());
        });
        assert_eq!(outer.units, 55);
    }
}
