//! Monitoring: what was observed, compared with what was predicted.

use rustc_hash::FxHashSet;

use super::{Event, Execution, ExecutionError, Phase, Stop};
use crate::environment::{Observation, Statements};
use crate::model::{Changes, State, StepPattern, apply, broken_bindings, changed_facts, fired};

impl Execution {
    /// Takes an observation, which may be partial.
    ///
    /// # Errors
    ///
    /// An observation that cannot be read in this world. It is still needed then.
    pub fn observed(&mut self, statements: &Statements) -> Result<(), ExecutionError> {
        if self.is_ended() {
            return Err(ExecutionError::Ended);
        }
        let observation = Observation::read(&self.world, &self.settings.reports, statements)?;
        self.events.push(Event::Observed {
            statements: statements.clone(),
        });
        self.due = false;
        if self.settle_interrupted(&observation) {
            self.compare(&observation);
        } else {
            self.phase = Phase::Judging(observation);
        }
        Ok(())
    }

    /// Compares the prediction with an observation.
    fn compare(&mut self, observation: &Observation) {
        let mut masked = FxHashSet::default();
        for order in &self.running {
            let action = self.world.domain().action(order.action);
            let mut facts = Vec::new();
            fired(
                &self.world,
                self.state(),
                action,
                &mut order.arguments.clone(),
                &mut facts,
            );
            masked.extend(facts.into_iter().map(|(fact, _)| fact));
        }
        let seen = observation.revised_but(&self.world, self.state(), &masked);
        if seen != *self.state() {
            self.withdraw();
            self.differences = changed_facts(self.state(), &seen);
            let broken = self.newly_broken(&seen);
            self.cursor.correct(seen);
            self.suspicious = true;
            if let Some(constraint) = broken {
                let because = self.differences.clone();
                self.end(Stop::Broken { constraint, because });
                return;
            }
            let state = self.cursor.state().clone();
            self.progress.advance(&self.world, &self.purpose, &state);
        }
        if !self.suspicious && self.running.is_empty() {
            self.confirm();
        }
        if self.suspicious && self.running.is_empty() {
            self.assess();
        }
    }

    /// Records that the observed world is as predicted, or as good.
    pub(super) fn confirm(&mut self) {
        for step in self.since.drain(..) {
            self.failures.remove(&step);
        }
        self.checkpoint = self.cursor.clone();
    }

    /// Returns a constraint, or a rule for every state, that held in the predicted state and does not hold in the
    /// observed one. An entity that is to be left untouched may be moved by others.
    fn newly_broken(&self, seen: &State) -> Option<String> {
        let world = &self.world;
        world.always_rules().find_map(|(number, rule)| {
            let prohibition = world.prohibition(number);
            let concerns_steps = |pattern: &StepPattern| pattern.anywhere.is_some();
            if prohibition.is_some_and(|own| own.steps.iter().any(concerns_steps)) {
                return None;
            }
            let broken = broken_bindings(rule, world, seen);
            if broken.is_empty() {
                return None;
            }
            let known = broken_bindings(rule, world, self.state());
            let is_new = broken.iter().any(|bindings| known.binary_search(bindings).is_err());
            let name = || match prohibition {
                Some(own) => own.says.clone(),
                None => rule.name.clone(),
            };
            is_new.then(name)
        })
    }

    /// Decides about an interrupted order.
    ///
    /// # Errors
    ///
    /// If no person was asked about this order.
    pub fn judged(&mut self, number: u64, done: bool) -> Result<(), ExecutionError> {
        let Phase::Judging(observation) = &self.phase else {
            return Err(ExecutionError::UnknownOrder(number));
        };
        let observation = observation.clone();
        let place = self.interrupted.iter().position(|order| order.number == number);
        let order = self
            .interrupted
            .remove(place.ok_or(ExecutionError::UnknownOrder(number))?);
        self.events.push(Event::Judged { order: number, done });
        if done {
            self.complete(&order, None)?;
        }
        if self.interrupted.is_empty() {
            self.phase = Phase::Active;
            self.compare(&observation);
        }
        Ok(())
    }

    /// Decides by an observation which of the interrupted orders were done. Returns false if a person has to be asked
    /// about some of them.
    fn settle_interrupted(&mut self, observation: &Observation) -> bool {
        let seen = observation.revised(&self.world, self.state());
        for order in std::mem::take(&mut self.interrupted) {
            // Sensing changes nothing, so it is simply repeated.
            if !order.outcomes.is_empty() {
                continue;
            }
            let action = self.world.domain().action(order.action);
            let Changes { facts, .. } = apply(&self.world, &mut self.state().clone(), action, &order.arguments);
            let mut visible = facts
                .iter()
                .filter(|own| observation.decides(&self.world, own.fact))
                .peekable();
            let is_visible = visible.peek().is_some();
            let came_about = visible.all(|own| seen.holds(own.fact) == own.holds);
            if !is_visible {
                self.interrupted.push(order);
            } else if came_about && self.complete(&order, None).is_ok() {
                self.events.push(Event::Found { order: order.number });
            }
        }
        self.interrupted.is_empty()
    }
}
