//! A person who agrees to everything.

use longstep_core::execution::{Event, Execution, Proposal, StepOrder, Unseen};
use longstep_robot::Watcher;

/// Approves everything, answers no question, and hands new events on.
pub struct Agreeing<F>(pub F);

impl<F: FnMut(&Execution, &[Event])> Watcher for Agreeing<F> {
    fn record(&mut self, execution: &Execution, events: &[Event]) -> Result<(), String> {
        (self.0)(execution, events);
        Ok(())
    }

    fn approve(&mut self, _: &Execution, _: &Proposal) -> Option<bool> {
        Some(true)
    }

    fn judge(&mut self, _: &Execution, _: &StepOrder) -> Option<bool> {
        None
    }

    fn confirm(&mut self, _: &Execution, _: &Unseen) -> Option<bool> {
        None
    }
}
