//! Progress through the stages of a purpose along an execution path.
//!
//! Progress is a set of facts of the simulated state, with predicates that the domain does not have. So paths with
//! different progress stay apart, and loops are followed until their progress repeats too.

use super::{Milestone, Purpose};
use longstep_model::effort;
use longstep_model::model::{
    Action, Bindings, EntityId, Fact, Moment, PredicateId, State, StateVariable, Wanted, World, fired, holds, support,
};

/// The stages of a purpose, prepared for simulation.
pub(super) struct StageTracker<'a> {
    stages: Vec<Vec<StageCondition<'a>>>,
    /// The events that conditions of stages after the first one refer to.
    events: Vec<PredicateId>,
    /// Number of predicates of the domain; higher numbers are progress.
    predicates: usize,
}

/// Decides whether a condition that holds (`true`), or that does not hold (`false`), is certain.
type Certain<'a> = &'a mut dyn FnMut(Moment<'_>, &Wanted, bool) -> bool;

/// A condition of a stage.
struct StageCondition<'a> {
    wanted: &'a Wanted,
    /// The fact that it was achieved in order.
    done: Fact,
    /// The fact that it was false when its stage began; none if it need not be.
    open: Option<Fact>,
}

impl<'a> StageTracker<'a> {
    pub(super) fn new(world: &World, purpose: &'a Purpose) -> Self {
        let domain = world.domain();
        let later = purpose.stages.iter().skip(1).flatten();
        let atoms = later.flat_map(|milestone| milestone.wanted.condition.atoms());
        let mut events: Vec<PredicateId> = atoms.map(|(atom, _)| atom.predicate).collect();
        events.sort_unstable();
        events.dedup();
        events.retain(|predicate| domain.words(*predicate).event);
        let predicates = domain.predicates.len();
        let flag = |number: usize| Fact::new(PredicateId::new(predicates), [EntityId::new(number)]);
        let (mut stages, mut milestones) = (Vec::new(), 0);
        for stage in &purpose.stages {
            let mut conditions = Vec::with_capacity(stage.len());
            for Milestone { wanted, anew } in stage {
                milestones += 1;
                conditions.push(StageCondition {
                    wanted,
                    done: flag(2 * milestones),
                    open: anew.then(|| flag(2 * milestones + 1)),
                });
            }
            stages.push(conditions);
        }
        Self {
            stages,
            events,
            predicates,
        }
    }

    /// Returns true if the purpose has no stages.
    pub(super) fn is_empty(&self) -> bool {
        self.stages.is_empty()
    }

    /// Returns true if conditions refer to the events since their stage began.
    pub(super) fn counts_events(&self) -> bool {
        !self.events.is_empty()
    }

    /// Returns the fact that a stage has begun.
    fn begun(&self, stage: usize) -> Fact {
        // The numbers from 2 on belong to the conditions.
        let places = [EntityId::new(0), EntityId::new(stage)];
        Fact::new(PredicateId::new(self.predicates), places)
    }

    /// Returns the event as a fact about a stage.
    fn since(&self, stage: usize, event: Fact, arity: usize) -> Option<Fact> {
        let index = self.events.binary_search(&event.predicate()).ok()?;
        let predicate = self.predicates + 1 + stage * self.events.len() + index;
        let arguments = (0..arity).map(|place| event.argument(place));
        Some(Fact::new(PredicateId::new(predicate), arguments))
    }

    fn is_complete(&self, stage: usize, state: &State) -> bool {
        self.stages[stage].iter().all(|condition| state.holds(condition.done))
    }

    /// Evaluates something in a stage: with the events since it began, in place of all events.
    fn in_stage<T>(&self, world: &World, state: &State, stage: usize, evaluate: impl FnOnce(Moment<'_>) -> T) -> T {
        if stage == 0 || self.events.is_empty() {
            return evaluate(Moment { world, state });
        }
        let mut state = state.clone();
        for (index, event) in self.events.iter().enumerate() {
            let predicate = PredicateId::new(self.predicates + 1 + stage * self.events.len() + index);
            let arity = world.domain().predicate(*event).parameters.len();
            let since: Vec<Fact> = state.of_predicate(predicate).to_vec();
            for fact in state.of_predicate(*event).to_vec() {
                state.set(fact, false);
            }
            for fact in since {
                state.set(Fact::new(*event, (0..arity).map(|place| fact.argument(place))), true);
            }
        }
        let state = &state;
        evaluate(Moment { world, state })
    }

    /// Records the events of a step. `before` is the state before it, `after` the one to record them in.
    pub(super) fn step(
        &self,
        world: &World,
        before: &State,
        action: &Action,
        arguments: &mut Bindings,
        after: &mut State,
    ) {
        if self.events.is_empty() {
            return;
        }
        let domain = world.domain();
        let mut facts = Vec::new();
        fired(world, before, action, arguments, &mut facts);
        for (event, _) in facts.into_iter().filter(|(_, adds)| *adds) {
            let arity = domain.predicate(event.predicate()).parameters.len();
            for stage in 1..self.stages.len() {
                // Stages begin in their order, so no later one has begun either.
                if !before.holds(self.begun(stage)) {
                    break;
                }
                if let Some(since) = self.since(stage, event, arity) {
                    after.set(since, true);
                }
            }
        }
    }

    /// Returns true if it is certain that a condition has this value in a stage; none if it has not.
    fn judged(
        &self,
        world: &World,
        state: &State,
        stage: usize,
        (wanted, value): (&Wanted, bool),
        certain: Certain<'_>,
    ) -> Option<bool> {
        self.in_stage(world, state, stage, |moment| {
            let is_so = holds(moment, &wanted.condition, &mut wanted.bindings.clone()) == value;
            is_so.then(|| certain(moment, wanted, value))
        })
    }

    /// Records what a state achieves.
    pub(super) fn advance(&self, world: &World, state: &mut State) {
        self.advance_where(world, state, &mut |_, _, _| true);
    }

    /// Records what a state achieves, as far as the conditions that hold are `certain`.
    fn advance_where(&self, world: &World, state: &mut State, certain: Certain<'_>) {
        for (index, stage) in self.stages.iter().enumerate() {
            if index > 0 && !state.holds(self.begun(index)) {
                // Later stages cannot begin before this one.
                if !self.is_complete(index - 1, state) {
                    return;
                }
                let mut open = Vec::new();
                for (condition, flag) in stage.iter().filter_map(|condition| Some((condition, condition.open?))) {
                    match self.judged(world, state, index, (condition.wanted, false), certain) {
                        Some(true) => open.push(flag),
                        // If it is not certain that the condition was false, the stage cannot begin yet.
                        Some(false) => return,
                        None => {}
                    }
                }
                state.set(self.begun(index), true);
                for flag in open {
                    state.set(flag, true);
                }
            }
            for condition in stage.iter().filter(|_| effort::spend(1)) {
                let counts = condition.open.is_none_or(|open| state.holds(open)) && !state.holds(condition.done);
                if counts && self.judged(world, state, index, (condition.wanted, true), certain) == Some(true) {
                    state.set(condition.done, true);
                }
            }
        }
    }

    /// Returns the first condition that a final state has not achieved in order, by its number among the conditions of
    /// all stages, with `true` for one of the first stage.
    pub(super) fn missing(&self, state: &State) -> Option<(usize, bool)> {
        let first = self.stages.first().map_or(0, Vec::len);
        let missing = self
            .stages
            .iter()
            .flatten()
            .position(|condition| !state.holds(condition.done))?;
        Some((missing, missing < first))
    }

    /// Removes the progress from a state.
    pub(super) fn forget(&self, state: &mut State) {
        if !self.is_empty() {
            state.truncate(self.predicates);
        }
    }
}

/// Progress through the stages of a purpose while its plan is carried out.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Progress(Vec<Fact>);

impl Progress {
    /// Records what a state achieves.
    pub fn advance(&mut self, world: &World, purpose: &Purpose, state: &State) {
        self.confirm(world, purpose, state, &|_| 0);
    }

    /// Records what a state achieves, as far as it rests on variables without weight; returns those that the conditions rest
    /// on besides, sorted.
    pub fn confirm(
        &mut self,
        world: &World,
        purpose: &Purpose,
        state: &State,
        weight: &dyn Fn(StateVariable) -> u32,
    ) -> Vec<StateVariable> {
        let mut open = Vec::new();
        if purpose.stages.is_empty() {
            return open;
        }
        let order = StageTracker::new(world, purpose);
        let mut state = self.added(state);
        order.advance_where(world, &mut state, &mut |moment, wanted, holds| {
            let mut bindings = wanted.bindings.clone();
            let rests_on = if holds {
                support(moment, &wanted.condition, &mut bindings, weight)
            } else {
                support(moment, &wanted.condition.clone().complement(), &mut bindings, weight)
            };
            let rests_on = rests_on.unwrap_or_default();
            let certain = rests_on.is_empty();
            open.extend(rests_on);
            certain
        });
        self.0 = state.iter_from(order.predicates).collect();
        open.sort_unstable();
        open.dedup();
        open
    }

    /// Records the events of a step.
    pub fn step(
        &mut self,
        world: &World,
        purpose: &Purpose,
        (before, after): (&State, &State),
        action: &Action,
        arguments: &[EntityId],
    ) {
        if purpose.stages.is_empty() {
            return;
        }
        let order = StageTracker::new(world, purpose);
        let (before, mut after) = (self.added(before), self.added(after));
        order.step(world, &before, action, &mut arguments.to_vec(), &mut after);
        self.0 = after.iter_from(order.predicates).collect();
    }

    fn added(&self, state: &State) -> State {
        let mut state = state.clone();
        for fact in &self.0 {
            state.set(*fact, true);
        }
        state
    }

    /// Returns the stages of a purpose that are not complete, for the rest of its plan.
    ///
    /// Behind the first stage, an empty stage begins them, so that events count from now on: a condition on several
    /// events of which one has happened is achieved anew.
    pub fn remaining(&self, world: &World, purpose: &Purpose) -> Vec<Vec<Milestone>> {
        let order = StageTracker::new(world, purpose);
        let is = |fact: &Fact| self.0.binary_search(fact).is_ok();
        let is_complete = |stage: &Vec<StageCondition<'_>>| stage.iter().all(|condition| is(&condition.done));
        let Some(current) = order.stages.iter().position(|stage| !is_complete(stage)) else {
            return Vec::new();
        };
        let open = order.stages[current].iter().zip(&purpose.stages[current]);
        let open = open
            .filter(|(condition, _)| !is(&condition.done))
            .map(|(condition, milestone)| {
                let was_false = condition.open.as_ref().is_some_and(is);
                Milestone {
                    anew: milestone.anew && !was_false,
                    ..milestone.clone()
                }
            });
        let mut stages: Vec<Vec<Milestone>> = Vec::new();
        if current > 0 {
            stages.push(Vec::new());
        }
        stages.push(open.collect());
        stages.extend(purpose.stages[current + 1..].iter().cloned());
        stages
    }
}
