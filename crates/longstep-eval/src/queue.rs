//! Who runs which unit: one program alone, or several that share a queue.

use std::collections::BTreeSet;
use std::convert::Infallible;
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::{Deserialize, Serialize};

use crate::attempt::{Attempt, Timing};
use crate::run::Lines;

/// The answer of a [`Queue`] to a program that could run a unit.
#[derive(Debug)]
pub enum Turn<Right> {
    /// Nobody has run it, and nobody else runs it while the right is held.
    Mine(Right),
    /// Another program runs it.
    Elsewhere,
    /// It was run.
    Done(Lines),
}

/// The units of a run, by their places in it.
pub trait Queue: Sync {
    /// The right to run a unit. Dropping it gives it back.
    type Right;
    /// The reason why a queue cannot be used.
    type Error;

    /// Takes a unit, unless it was run or is run by another program.
    ///
    /// # Errors
    ///
    /// When the queue cannot be used.
    fn turn(&self, number: usize) -> Result<Turn<Self::Right>, Self::Error>;

    /// Keeps the lines of a unit, and returns those that count: the first ones that anybody kept.
    ///
    /// # Errors
    ///
    /// When the queue cannot be used.
    fn keep(&self, number: usize, lines: Lines) -> Result<Lines, Self::Error>;
}

/// The queue of a program that runs all units by itself.
#[derive(Debug, Clone, Copy, Default)]
pub struct Alone;

impl Queue for Alone {
    type Right = ();
    type Error = Infallible;

    fn turn(&self, _: usize) -> Result<Turn<()>, Infallible> {
        Ok(Turn::Mine(()))
    }

    fn keep(&self, _: usize, lines: Lines) -> Result<Lines, Infallible> {
        Ok(lines)
    }
}

/// The units that a program has not seen the end of.
#[derive(Debug)]
pub(crate) struct Open(Mutex<Units>);

#[derive(Debug, Default)]
struct Units {
    /// Those to look at, in order.
    open: BTreeSet<usize>,
    /// Those that another program ran when they were looked at.
    elsewhere: BTreeSet<usize>,
}

/// The next deed of a worker.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Next {
    /// Ask for this unit.
    Unit(usize),
    /// Wait for other programs, then go on.
    Wait,
    /// Nothing is left.
    End,
}

impl Open {
    /// All units up to a number.
    pub(crate) fn new(units: usize) -> Self {
        Self(Mutex::new(Units {
            open: (0..units).collect(),
            elsewhere: BTreeSet::new(),
        }))
    }

    fn units(&self) -> MutexGuard<'_, Units> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the next unit, which nobody else in this program gets.
    pub(crate) fn next(&self) -> Next {
        let mut units = self.units();
        match units.open.pop_first() {
            Some(number) => Next::Unit(number),
            None if units.elsewhere.is_empty() => Next::End,
            None => Next::Wait,
        }
    }

    /// Puts a unit aside that another program runs.
    pub(crate) fn put_aside(&self, number: usize) {
        self.units().elsewhere.insert(number);
    }

    /// Looks at those that were put aside again, before the others.
    pub(crate) fn look_again(&self) {
        let mut units = self.units();
        let mut elsewhere = std::mem::take(&mut units.elsewhere);
        units.open.append(&mut elsewhere);
    }
}

/// The lines of a unit, as a queue keeps them.
#[derive(Serialize, Deserialize)]
struct Kept {
    attempts: Vec<Attempt>,
    timings: Vec<Timing>,
}

/// Writes the lines of a unit as one line of JSON.
pub fn kept_text(lines: &Lines) -> String {
    let (attempts, timings) = lines.iter().cloned().unzip();
    // Plain data with string keys; its serialization does not fail.
    serde_json::to_string(&Kept { attempts, timings }).unwrap_or_default()
}

/// Reads the lines of a unit as [`kept_text`] wrote them.
///
/// # Errors
///
/// When the text has another form.
pub fn read_kept(text: &str) -> Result<Lines, serde_json::Error> {
    let Kept { attempts, timings } = serde_json::from_str(text)?;
    if attempts.len() != timings.len() {
        return Err(serde::de::Error::custom("attempts and timings differ in number"));
    }
    Ok(attempts.into_iter().zip(timings).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_others_are_looked_at_again_before_later_ones() {
        let open = Open::new(4);
        assert_eq!(open.next(), Next::Unit(0));
        open.put_aside(0);
        assert_eq!(open.next(), Next::Unit(1));
        open.look_again();
        assert_eq!(open.next(), Next::Unit(0));
        assert_eq!((open.next(), open.next()), (Next::Unit(2), Next::Unit(3)));
        open.put_aside(2);
        assert_eq!(open.next(), Next::Wait);
        open.look_again();
        assert_eq!((open.next(), open.next()), (Next::Unit(2), Next::End));
    }
}
