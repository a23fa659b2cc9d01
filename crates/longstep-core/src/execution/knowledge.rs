//! The sources of the facts and numbers of the believed state: observed, promised by a step, or assumed.

use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use super::StepOrder;
use longstep_model::environment::ObservedFacts;
use longstep_model::model::{
    Application, Atom, EntityId, PredicateId, Slot, StateVariable, Term, TypeId, World, entries_of,
};

/// The basis of a fact or number that no look of the end of a run has shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// It was observed after an order, and no later step could have changed it.
    Seen,
    /// Nothing can show it; the robot says that it performed the step that changed it.
    Word,
    /// A step could have changed it, and it was not observed since.
    Promised,
    /// The environment of the plan says so, and it was never observed.
    Assumed,
    /// It was observed before a pause, in which others may have changed it, and not since.
    BeforePause,
}

/// A fact or number that no look of the end of a run has shown, with its basis.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Unseen {
    /// The fact or number as a sentence.
    pub what: String,
    /// Its basis.
    pub basis: Basis,
    /// The number of the order after which it was seen last ([`Basis::Seen`], [`Basis::BeforePause`]), or that promised it; 0 for the beginning, none
    /// for an assumption.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order: Option<u64>,
}

impl Basis {
    /// Returns true for a basis that a look could test, and none has since others could have changed it.
    pub(super) fn is_open(self) -> bool {
        matches!(self, Self::Promised | Self::Assumed | Self::BeforePause)
    }
}

impl Unseen {
    /// Returns true if only a promise, an assumption or a look before a pause says so, although a look could show it.
    pub fn is_open(&self) -> bool {
        self.basis.is_open()
    }

    /// Writes the basis and the fact as a sentence.
    ///
    /// ```
    /// use longstep_core::execution::{Basis, Unseen};
    /// let text = r#"{"what": "the door is closed", "basis": "promised", "order": 3}"#;
    /// let unseen: Unseen = serde_json::from_str(text).unwrap();
    /// assert_eq!(unseen.basis, Basis::Promised);
    /// assert_eq!(unseen.sentence(), "promised by step 3, not seen since: the door is closed");
    /// ```
    pub fn sentence(&self) -> String {
        let what = &self.what;
        match (self.basis, self.order) {
            (Basis::Seen, Some(0) | None) => format!("last seen before the first step: {what}"),
            (Basis::Seen, Some(order)) => format!("last seen after step {order}: {what}"),
            (Basis::Word, _) => format!("on the robot's word: {what}"),
            (Basis::Promised, Some(order)) => format!("promised by step {order}, not seen since: {what}"),
            (Basis::BeforePause, Some(0) | None) => {
                format!("last seen before the first step, and a pause since: {what}")
            }
            (Basis::BeforePause, Some(order)) => format!("last seen after step {order}, and a pause since: {what}"),
            (Basis::Promised | Basis::Assumed, _) => format!("never seen: {what}"),
        }
    }
}

/// A moment of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
struct Moment {
    /// Counts observations and changes by steps.
    tick: u64,
    /// The number of orders so far, or the order that changed something.
    order: u64,
}

/// The effect of an order on facts or numbers with an argument that is known only when it happens.
#[derive(Debug, Clone)]
struct Pattern<T> {
    target: T,
    arguments: Vec<EntityId>,
    /// The quantified variables with their types.
    forall: Vec<(Slot, TypeId)>,
    moment: Moment,
}

/// The sources of everything in the believed state.
#[derive(Debug, Clone, Default)]
pub(super) struct Knowledge {
    now: Moment,
    /// The tick at which the last order ended.
    ended: u64,
    /// The tick at which others could have acted last.
    others: u64,
    entities: FxHashMap<EntityId, Moment>,
    predicates: FxHashMap<PredicateId, Moment>,
    /// The last list of facts without a subject.
    alone: Option<Moment>,
    shown: FxHashMap<StateVariable, Moment>,
    touched: FxHashMap<StateVariable, Moment>,
    touched_facts: Vec<Pattern<Atom>>,
    touched_numbers: Vec<Pattern<Application>>,
}

impl Knowledge {
    fn tick(&mut self, order: u64) -> Moment {
        self.now = Moment {
            tick: self.now.tick + 1,
            order,
        };
        self.now
    }

    /// Records an observation, before which this many orders were given. The orders that are `running` may change what
    /// it shows at any moment.
    pub(super) fn observed(&mut self, observation: &ObservedFacts, orders: u64, world: &World, running: &[StepOrder]) {
        let now = self.tick(orders);
        self.entities
            .extend(observation.entities().iter().map(|own| (*own, now)));
        self.predicates
            .extend(observation.predicates().iter().map(|own| (*own, now)));
        if observation.lists_facts() {
            self.alone = Some(now);
        }
        let facts = observation.facts().map(StateVariable::Fact);
        let numbers = observation.numbers().map(|(fluent, _)| StateVariable::Number(fluent));
        self.shown.extend(facts.chain(numbers).map(|own| (own, now)));
        for order in running {
            self.touch(world, order);
        }
    }

    /// Records that a sensing step, or a person, says how something is.
    pub(super) fn learned(&mut self, variables: impl IntoIterator<Item = StateVariable>, orders: u64) {
        let now = self.tick(orders);
        self.shown.extend(variables.into_iter().map(|own| (own, now)));
    }

    /// Records that an order may have changed what its effects name, whatever their conditions.
    pub(super) fn touch(&mut self, world: &World, order: &StepOrder) {
        let now = self.tick(order.number);
        let action = world.domain().action(order.action);
        let arguments = &order.arguments;
        let is_bound = |terms: &[Term]| {
            let bound = |term: &Term| !matches!(term, Term::Variable(slot) if *slot >= arguments.len());
            terms.iter().all(bound)
        };
        for effect in &action.effects {
            if is_bound(&effect.atom.terms) {
                let fact = longstep_model::model::ground(&effect.atom, arguments);
                self.touched.insert(StateVariable::Fact(fact), now);
            } else {
                touch_all(&mut self.touched_facts, &effect.atom, (arguments, &effect.forall), now)
            }
        }
        for effect in &action.numeric {
            if is_bound(&effect.fluent.terms) {
                let fluent = effect.fluent.ground(arguments);
                self.touched.insert(StateVariable::Number(fluent), now);
            } else {
                touch_all(
                    &mut self.touched_numbers,
                    &effect.fluent,
                    (arguments, &effect.forall),
                    now,
                )
            }
        }
    }

    /// Records that an order has ended, in whatever way.
    pub(super) fn ended(&mut self, world: &World, order: &StepOrder) {
        self.touch(world, order);
        self.ended = self.now.tick;
    }

    /// Records that others may have changed anything that an observation shows.
    pub(super) fn others_acted(&mut self) {
        self.others = self.now.tick;
    }

    fn last_shown(&self, world: &World, variable: StateVariable) -> Option<Moment> {
        let own = self.shown.get(&variable).copied();
        let StateVariable::Fact(fact) = variable else {
            return own;
        };
        let domain = world.domain();
        // What sensing reveals is not visible.
        if domain.is_sensed(fact.predicate()) {
            return own;
        }
        let listed = entries_of(world, fact).filter_map(|(subject, _)| self.entities.get(&subject).copied());
        let reported = self.predicates.get(&fact.predicate()).copied();
        let alone = self.alone.filter(|_| ObservedFacts::is_without_subject(domain, fact));
        listed.chain(own).chain(reported).chain(alone).max()
    }

    fn last_touched(&self, world: &World, variable: StateVariable) -> Option<Moment> {
        let own = self.touched.get(&variable).copied();
        let pattern = match variable {
            StateVariable::Fact(fact) => {
                let fits = |own: &&Pattern<Atom>| {
                    let is_named = own.target.predicate == fact.predicate();
                    is_named && own.fits(world, &own.target.terms, |place| fact.argument(place))
                };
                self.touched_facts.iter().filter(fits).map(|own| own.moment).max()
            }
            StateVariable::Number(fluent) => {
                let fits = |own: &&Pattern<Application>| {
                    let is_named = own.target.function == fluent.function();
                    is_named && own.fits(world, &own.target.terms, |place| fluent.argument(place))
                };
                self.touched_numbers.iter().filter(fits).map(|own| own.moment).max()
            }
        };
        own.max(pattern)
    }

    /// Returns true if an order could have changed it.
    pub(super) fn is_touched(&self, world: &World, variable: StateVariable) -> bool {
        self.last_touched(world, variable).is_some()
    }

    /// Returns true if an order could have changed it since this tick.
    pub(super) fn is_touched_since(&self, world: &World, variable: StateVariable, tick: u64) -> bool {
        self.last_touched(world, variable).is_some_and(|own| own.tick > tick)
    }

    /// Returns the current tick.
    pub(super) fn now(&self) -> u64 {
        self.now.tick
    }

    /// Returns the basis of a fact or number, with its order; none if it was seen since the last order ended, or if it never
    /// changes.
    pub(super) fn basis(
        &self,
        world: &World,
        reports: &[PredicateId],
        variable: StateVariable,
    ) -> Option<(Basis, Option<u64>)> {
        let domain = world.domain();
        let changes = match variable {
            StateVariable::Fact(fact) => domain.words(fact.predicate()).fluent,
            StateVariable::Number(fluent) => domain.function(fluent.function()).changes,
        };
        if !changes {
            return None;
        }
        let is_visible = ObservedFacts::can_show(world, reports, variable);
        match (self.last_shown(world, variable), self.last_touched(world, variable)) {
            (Some(shown), touched) if touched.is_none_or(|touched| touched < shown) => {
                let basis = if is_visible && shown.tick <= self.others {
                    Basis::BeforePause
                } else {
                    Basis::Seen
                };
                (basis == Basis::BeforePause || shown.tick < self.ended).then_some((basis, Some(shown.order)))
            }
            (_, Some(touched)) if is_visible => Some((Basis::Promised, Some(touched.order))),
            (_, Some(touched)) => Some((Basis::Word, Some(touched.order))),
            (_, None) if is_visible => Some((Basis::Assumed, None)),
            (_, None) => None,
        }
    }
}

impl<T> Pattern<T> {
    /// Returns true if these terms can be these arguments: a quantified variable is one entity of its type.
    fn fits(&self, world: &World, terms: &[Term], argument: impl Fn(usize) -> EntityId) -> bool {
        terms.iter().enumerate().all(|(place, term)| match term {
            Term::Constant(entity) => *entity == argument(place),
            Term::Variable(slot) => match self.arguments.get(*slot) {
                Some(entity) => *entity == argument(place),
                None => {
                    let mut kinds = self.forall.iter().filter(|(own, _)| own == slot);
                    let first = terms.iter().position(|own| own == term).unwrap_or(place);
                    argument(first) == argument(place)
                        && kinds.all(|(_, kind)| world.is_of_kind(argument(place), *kind))
                }
            },
        })
    }
}

/// Notes that everything that fits a pattern may have changed.
fn touch_all<T: Clone + PartialEq>(
    patterns: &mut Vec<Pattern<T>>,
    target: &T,
    (arguments, forall): (&[EntityId], &[(Slot, TypeId)]),
    now: Moment,
) {
    let same = |own: &&mut Pattern<T>| own.target == *target && own.arguments == arguments && own.forall == forall;
    match patterns.iter_mut().find(same) {
        Some(own) => own.moment = now,
        None => patterns.push(Pattern {
            target: target.clone(),
            arguments: arguments.to_vec(),
            forall: forall.to_vec(),
            moment: now,
        }),
    }
}
