//! Monitoring: what was observed, compared with what was predicted.

use rustc_hash::FxHashSet;

use super::{Event, Execution, ExecutionError, Phase, Stop};
use longstep_model::environment::{Observation, ObservedFacts};
use longstep_model::model::{
    Changes, Difference, Fact, Fluent, State, StateVariable, StepPattern, Voice, World, apply, assigned,
    broken_bindings, changed_facts, fact_text, fired,
};
use longstep_search::search::GroundAction;

/// A difference between the expected and the observed world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Noticed {
    /// A fact holds in exactly one of them.
    Fact(Difference),
    /// A number differs; with the state that has the observed number.
    Number(Fluent, longstep_model::model::Number),
}

impl Noticed {
    /// Writes the observed side as a sentence for a person.
    pub fn sentence(self, world: &World) -> String {
        match self {
            Self::Fact(own) => fact_text(world, own.fact, own.now_holds),
            Self::Number(fluent, number) => {
                let voice = Voice::Person;
                let name = voice.fluent(world, fluent);
                format!("{name} is {}", voice.number(world, fluent, number))
            }
        }
    }

    /// Returns the differences between two states: facts first.
    pub(super) fn between(expected: &State, seen: &State) -> Vec<Self> {
        let facts = changed_facts(expected, seen).into_iter().map(Self::Fact);
        let numbers = seen.numbers().iter();
        let numbers = numbers.filter(|(fluent, number)| expected.number(*fluent) != Some(*number));
        let numbers = numbers.map(|(fluent, number)| Self::Number(*fluent, *number));
        facts.chain(numbers).collect()
    }
}

/// A step that a robot says that it performed.
#[derive(Debug, Clone)]
pub(super) struct Completed {
    pub(super) action: GroundAction,
    /// The believed state before it.
    pub(super) before: State,
    /// The changes that it promised.
    pub(super) changes: Changes,
    /// Those of them that an observation has shown. What happens to them later isn't the step's.
    pub(super) shown: FxHashSet<StateVariable>,
    /// Those of them of which an observation shows that they did not come about.
    pub(super) denied: FxHashSet<StateVariable>,
    /// True if its events are part of the progress through the stages.
    pub(super) counted: bool,
}

impl Completed {
    /// Returns true if it promised a new value for a variable.
    fn changes(&self, variable: StateVariable) -> bool {
        match variable {
            StateVariable::Fact(fact) => self.changes.facts.iter().any(|own| own.fact == fact),
            StateVariable::Number(fluent) => self.changes.numbers.iter().any(|own| own.fluent == fluent),
        }
    }

    /// Returns true if an observation shows that one of its changes did not come about.
    pub(super) fn is_refuted(&self) -> bool {
        !self.denied.is_empty()
    }

    /// Takes over what an observation says of a change, true if it came about. Returns false if it did not, and was never
    /// seen before.
    fn compare(&mut self, variable: StateVariable, came_about: bool) -> bool {
        if came_about {
            self.denied.remove(&variable);
            self.shown.insert(variable);
        } else if !self.shown.contains(&variable) {
            self.denied.insert(variable);
            return false;
        }
        true
    }
}

impl Execution {
    /// Takes an observation, which may be partial. See the [example](Self#example).
    ///
    /// # Errors
    ///
    /// An observation that cannot be read in this world. It is still needed then.
    pub fn observed(&mut self, statements: &Observation) -> Result<(), ExecutionError> {
        if self.is_ended() {
            return Err(ExecutionError::Ended);
        }
        let observation = ObservedFacts::read(&self.world, &self.settings.reports, statements)?;
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
    fn compare(&mut self, observation: &ObservedFacts) {
        self.forget_hidden();
        self.knowledge
            .observed(observation, self.orders, &self.world, &self.running);
        self.looks.add(observation);
        let observation = &self.with_earlier_look(observation.clone());
        self.earlier_look = None;
        let masked = self.under_change();
        let mut seen = observation.revised_but(&self.world, self.state(), &masked);
        for event in self.events_before_pause() {
            seen.set(*event, true);
        }
        for event in self.refuted_events(observation, &masked) {
            seen.set(event, false);
        }
        if seen != *self.state() {
            self.withdraw();
            self.differences = Noticed::between(self.state(), &seen);
            let broken = self.newly_broken(&seen);
            self.cursor.correct(seen);
            self.suspicious = true;
            if let Some(constraint) = broken {
                let because = self.differences.clone();
                self.end(Stop::Broken { constraint, because });
                return;
            }
        }
        self.take_back(observation);
        self.seen_recent = true;
        self.confirm_progress();
        if !self.suspicious && self.running.is_empty() {
            self.confirm();
        }
        // A difference is assessed after a pause, from a new look.
        if self.suspicious && self.running.is_empty() && !self.is_paused() {
            self.assess();
        }
    }

    /// Returns an observation together with a look of which the believed state knows nothing yet.
    pub(super) fn with_earlier_look(&self, observation: ObservedFacts) -> ObservedFacts {
        match self.earlier_look.clone() {
            Some(earlier) => earlier.updated(&self.world, observation),
            None => observation,
        }
    }

    /// Returns the facts and numbers that the orders under way may be changing at this moment.
    fn under_change(&self) -> FxHashSet<StateVariable> {
        let mut all = FxHashSet::default();
        for order in &self.running {
            let action = self.world.domain().action(order.action);
            let mut bindings = order.arguments.clone();
            let mut facts = Vec::new();
            fired(&self.world, self.state(), action, &mut bindings, &mut facts);
            all.extend(facts.into_iter().map(|(fact, _)| StateVariable::Fact(fact)));
            let numbers = assigned(&self.world, self.state(), &action.numeric, &mut bindings);
            all.extend(numbers.into_iter().map(|(fluent, _)| StateVariable::Number(fluent)));
        }
        all
    }

    /// Marks the steps of which an observation shows that an effect did not come about; returns the events of these steps.
    fn refuted_events(&mut self, observation: &ObservedFacts, masked: &FxHashSet<StateVariable>) -> Vec<Fact> {
        let (mut events, mut takes_back) = (Vec::new(), false);
        for index in 0..self.recent.len() {
            let world = &self.world;
            let (own, later) = (&self.recent[index], &self.recent[index + 1..]);
            let is_last = |variable: StateVariable| {
                !masked.contains(&variable) && !later.iter().any(|step| step.changes(variable))
            };
            let facts = own.changes.facts.iter().filter_map(|change| {
                let shown = observation.decides(world, change.fact);
                shown.then(|| {
                    (
                        StateVariable::Fact(change.fact),
                        observation.states(change.fact) == change.holds,
                    )
                })
            });
            let numbers = own.changes.numbers.iter().filter_map(|change| {
                let shown = observation.number(change.fluent)?;
                Some((StateVariable::Number(change.fluent), shown == change.after))
            });
            let said: Vec<(StateVariable, bool)> = facts
                .chain(numbers)
                .filter(|(variable, _)| is_last(*variable))
                .collect();
            let own = &mut self.recent[index];
            let mut denies = false;
            for (variable, came_about) in said {
                denies |= !own.compare(variable, came_about);
            }
            takes_back |= own.is_refuted() && own.counted;
            if denies {
                let (own, later) = (&self.recent[index], &self.recent[index + 1..]);
                let is_event = |fact: &Fact| {
                    let variable = StateVariable::Fact(*fact);
                    world.domain().words(fact.predicate()).event
                        && !observation.decides(world, *fact)
                        && !later.iter().any(|step| step.changes(variable))
                };
                let new = own.changes.facts.iter().filter(|change| change.holds);
                events.extend(new.map(|change| change.fact).filter(is_event));
            }
        }
        if takes_back {
            self.take_back_recent();
        }
        events
    }

    /// Records that the observed world is as predicted, or as good.
    pub(super) fn confirm(&mut self) {
        self.since.clear();
        self.meanwhile.is_blameless = false;
        for step in self.worked.drain(..) {
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

    /// Decides about an interrupted order. See the example of [`Execution::resume`].
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
    fn settle_interrupted(&mut self, observation: &ObservedFacts) -> bool {
        let seen = observation.revised(&self.world, self.state());
        for order in std::mem::take(&mut self.interrupted) {
            // Sensing changes nothing, so it is simply repeated.
            if !order.outcomes.is_empty() {
                continue;
            }
            let action = self.world.domain().action(order.action);
            let Changes { facts, numbers } = apply(&self.world, &mut self.state().clone(), action, &order.arguments);
            let can_show = |own: StateVariable| ObservedFacts::can_show(&self.world, &self.settings.reports, own);
            let facts = facts.iter().filter(|own| can_show(StateVariable::Fact(own.fact)));
            let facts = facts.map(|own| {
                let shown = observation.decides(&self.world, own.fact);
                shown.then(|| seen.holds(own.fact) == own.holds)
            });
            let numbers = numbers
                .iter()
                .map(|own| Some(observation.number(own.fluent)? == own.after));
            // By visible effect: true if it came about; none if the observation does not show it.
            let visible: Vec<Option<bool>> = facts.chain(numbers).collect();
            let is_undecided = !visible.contains(&Some(false)) && (visible.is_empty() || visible.contains(&None));
            if is_undecided {
                self.interrupted.push(order);
            } else if !visible.contains(&Some(false)) && self.complete(&order, None).is_ok() {
                self.events.push(Event::Found { order: order.number });
            }
        }
        self.interrupted.is_empty()
    }
}
