//! Grounding: numbers for facts, and conditions and actions about entities.

use std::borrow::Cow;

use rustc_hash::{FxHashMap, FxHashSet};

use super::GroundAction;
use super::formula::{Formula, Literal};
use super::numbers::NumberGrounder;
use super::operator::{GroundEffect, GroundNumericEffect, Operator};
use super::scope::Scope;
use super::task::{Always, Task};
use longstep_model::effort;
use longstep_model::model::{
    Action, ActionId, Arithmetic, Atom, Bindings, Condition, Domain, EntityId, Fact, GroundTest, Moment, Slot, State,
    Term, TypeId, Wanted, When, World, ever_candidates, ground as ground_atom, static_value,
};

/// Work units for one node of a condition, which is stored and copied into smaller tasks.
const PART: usize = 16;

/// The meaning of a literal of a task.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) enum Meaning {
    /// A fact of the world.
    Fact(Fact),
    /// A requirement on numbers.
    Test(GroundTest),
}

impl Meaning {
    /// Returns the value in a state.
    pub(crate) fn holds(&self, state: &State) -> bool {
        match self {
            Self::Fact(fact) => state.holds(*fact),
            Self::Test(test) => test.holds(&|fluent| state.number(*fluent)),
        }
    }
}

/// Returns the conjuncts of a condition; atoms and equalities with the number of parameters to bind before evaluation.
fn conjuncts(condition: &Condition) -> Vec<(usize, &Condition)> {
    condition.conjuncts().map(|part| (slots_of(part), part)).collect()
}

/// Returns the number of slots to bind before a conjunct is evaluated.
fn slots_of(part: &Condition) -> usize {
    match part {
        Condition::Atom { atom, .. } => atom.terms.iter().map(slots_of_term).max().unwrap_or(0),
        Condition::Equal { left, right, .. } => slots_of_term(left).max(slots_of_term(right)),
        Condition::Number(test) => test.last_slot().map_or(0, |slot| slot + 1),
        _ => 0,
    }
}

fn slots_of_term(term: &Term) -> usize {
    match term {
        Term::Variable(slot) => slot + 1,
        Term::Constant(_) => 0,
    }
}

/// The events of a stage after the first one.
#[derive(Debug)]
pub(super) struct StageEvents {
    /// The fact that the stage has begun.
    pub(super) begun: u32,
    /// The number of the copy of each event.
    pub(super) copies: FxHashMap<Fact, u32>,
}

/// Numbers facts and grounds conditions.
pub(crate) struct Grounder<'a> {
    pub(super) domain: &'a Domain,
    world: &'a World,
    scope: &'a Scope,
    pub(super) numbers: FxHashMap<Fact, u32>,
    fluents: NumberGrounder,
    /// The events of the stages after the first one.
    pub(super) events: Vec<StageEvents>,
    /// True while conditions refer to the copies of events in the last stage.
    pub(super) copying: bool,
    /// By numbered fact: true if it holds in the initial state.
    pub(crate) initial: Vec<bool>,
}

impl<'a> Grounder<'a> {
    pub(crate) fn new(world: &'a World, scope: &'a Scope) -> Self {
        let domain = world.domain();
        Self {
            domain,
            world,
            scope,
            numbers: FxHashMap::default(),
            fluents: NumberGrounder::default(),
            events: Vec::new(),
            copying: false,
            initial: Vec::new(),
        }
    }

    /// Returns the task of everything that was grounded.
    pub(crate) fn task(self, mut operators: Vec<Operator>, goal: Formula, always: Always) -> Task {
        let state = &self.world.state;
        let numbers = self.fluents.finish(|fluent| state.number(fluent), &mut operators);
        Task {
            initial: self.initial,
            operators,
            goal,
            always,
            numbers,
        }
    }

    /// Marks in the operators the requirements on numbers that they may change.
    pub(super) fn mark(&self, operators: &mut [Operator]) {
        let state = &self.world.state;
        // On a copy, because the caller still needs the meanings of the tests.
        self.fluents.clone().finish(|fluent| state.number(fluent), operators);
    }

    /// Grounds the conjunction of all wanted conditions.
    pub(crate) fn goal(&mut self, wanted: &[Wanted]) -> Formula {
        let parts: Vec<Formula> = wanted
            .iter()
            .map(|wanted| self.formula(&wanted.condition, &mut wanted.bindings.clone()))
            .collect();
        Formula::and(parts)
    }

    /// Grounds the `always` rules.
    pub(crate) fn always(&mut self) -> Always {
        let mut parts = Vec::new();
        for (_, rule) in self.world.always_rules() {
            self.instances_of_rule(&rule.everywhere(), rule.variables.len(), &mut Vec::new(), &mut parts);
        }
        Always::of(parts)
    }

    /// Adds a formula for each binding of the rule's variables, which are the outermost quantifiers.
    fn instances_of_rule(
        &mut self,
        condition: &Condition,
        variables: usize,
        bindings: &mut Bindings,
        parts: &mut Vec<Formula>,
    ) {
        // One formula for each binding: an instance that is broken at first must not release the others.
        let Condition::Forall(slot, kind, inner) = condition else {
            return parts.push(self.formula(condition, bindings));
        };
        if variables == 0 {
            return parts.push(self.formula(condition, bindings));
        }
        for entity in self.things((*slot, *kind), inner, false, bindings).as_ref() {
            if !effort::spend(effort::KEPT) {
                return;
            }
            bindings.push(*entity);
            self.instances_of_rule(inner, variables - 1, bindings, parts);
            bindings.pop();
        }
    }

    /// Grounds every action in scope with all arguments that satisfy its static preconditions. Operators with the
    /// fewest arguments outside of `mentioned` come first, and the search tries them first.
    pub(crate) fn operators(&mut self, mentioned: &FxHashSet<EntityId>) -> Vec<Operator> {
        let mut operators: Vec<Operator> = Vec::new();
        let matters = self.domain.action_ids().zip(&self.scope.actions);
        for ((id, action), _) in matters.filter(|((_, action), matters)| **matters && action.senses.is_empty()) {
            self.each_binding(id, &mut |grounder, arguments, precondition| {
                let step = GroundAction {
                    action: id,
                    arguments: arguments.to_vec(),
                };
                operators.push(Operator {
                    effects: grounder.effects(action, arguments),
                    numeric: grounder.numeric(action, arguments),
                    step,
                    is_mark: false,
                    cost: 1,
                    tag: 0,
                    outcome: None,
                    precondition,
                });
            });
        }
        operators.sort_by_key(|operator| {
            let arguments = operator.step.arguments.iter();
            arguments.filter(|entity| !mentioned.contains(entity)).count()
        });
        operators
    }

    /// Grounds every sensing action in scope: one operator for each outcome, applicable while none of the outcomes is
    /// known.
    pub(super) fn sensing(&mut self) -> Vec<Operator> {
        let mut operators: Vec<Operator> = Vec::new();
        let matters = self.domain.action_ids().zip(&self.scope.actions);
        for ((id, action), _) in matters.filter(|((_, action), matters)| **matters && !action.senses.is_empty()) {
            self.each_binding(id, &mut |grounder, arguments, precondition| {
                let outcomes: Vec<Fact> = action.senses.iter().map(|atom| ground_atom(atom, arguments)).collect();
                let numbers: Vec<u32> = outcomes.iter().map(|fact| grounder.number(*fact)).collect();
                let unknown = |fact: &u32| Formula::literal(*fact, false);
                let precondition = Formula::and(std::iter::once(precondition).chain(numbers.iter().map(unknown)));
                for (outcome, fact) in outcomes.iter().zip(&numbers) {
                    operators.push(Operator {
                        step: GroundAction {
                            action: id,
                            arguments: arguments.to_vec(),
                        },
                        is_mark: false,
                        cost: 1,
                        tag: 0,
                        outcome: Some(*outcome),
                        precondition: precondition.clone(),
                        effects: vec![GroundEffect {
                            condition: Formula::TRUE,
                            literal: Literal {
                                fact: *fact,
                                holds: true,
                            },
                            may: false,
                        }],
                        numeric: Vec::new(),
                    });
                }
            });
        }
        operators
    }

    /// Grounds one action, whether or not it can ever be applicable.
    pub(crate) fn operator(&mut self, step: GroundAction) -> Operator {
        let action = self.domain.action(step.action);
        let precondition = self.formula(&action.precondition, &mut step.arguments.clone());
        Operator {
            effects: self.effects(action, &step.arguments),
            numeric: self.numeric(action, &step.arguments),
            step,
            is_mark: false,
            cost: 1,
            tag: 0,
            outcome: None,
            precondition,
        }
    }

    /// Returns the meanings of the facts by number; requires a task without extra facts.
    pub(super) fn facts(self) -> Vec<Meaning> {
        let facts = self
            .numbers
            .into_iter()
            .map(|(fact, number)| (number, Meaning::Fact(fact)));
        let tests = self
            .fluents
            .tests()
            .iter()
            .map(|(test, number)| (*number, Meaning::Test(test.clone())));
        let mut facts: Vec<(u32, Meaning)> = facts.chain(tests).collect();
        facts.sort_unstable_by_key(|(number, _)| *number);
        facts.into_iter().map(|(_, fact)| fact).collect()
    }

    /// Adds an auxiliary fact that does not exist in the world.
    pub(crate) fn extra(&mut self, holds: bool) -> u32 {
        self.initial.push(holds);
        (self.initial.len() - 1) as u32
    }

    fn number(&mut self, fact: Fact) -> u32 {
        if let Some(copy) = self.copy(fact) {
            return copy;
        }
        *self.numbers.entry(fact).or_insert_with(|| {
            self.initial.push(self.world.state.holds(fact));
            (self.initial.len() - 1) as u32
        })
    }

    /// Calls `found` for every binding that the static preconditions and the prohibitions allow.
    fn each_binding(&mut self, id: ActionId, found: &mut impl FnMut(&mut Self, &[EntityId], Formula)) {
        let action = self.domain.action(id);
        let conjuncts = conjuncts(&action.precondition);
        self.bind(
            action,
            &conjuncts,
            &mut Vec::with_capacity(action.parameters.len()),
            &mut |grounder, arguments, precondition| {
                if grounder.world.forbids(id, arguments).is_none() {
                    found(grounder, arguments, precondition);
                }
            },
        );
    }

    /// Binds the parameters from the next one on; backtracks as soon as a static precondition fails.
    fn bind(
        &mut self,
        action: &Action,
        conjuncts: &[(usize, &Condition)],
        arguments: &mut Bindings,
        found: &mut impl FnMut(&mut Self, &[EntityId], Formula),
    ) {
        let bound = arguments.len();
        for (needed, condition) in conjuncts {
            if *needed == bound && static_value(self.world, condition, arguments) == Some(false) {
                return;
            }
        }
        if bound == action.parameters.len() {
            let parts: Vec<Formula> = conjuncts.iter().map(|(_, c)| self.formula(c, arguments)).collect();
            let precondition = Formula::and(parts);
            if !precondition.is_false() {
                found(self, arguments, precondition);
            }
            return;
        }
        let parameter = (bound, action.parameters[bound].kind);
        for entity in self.things(parameter, &action.precondition, true, arguments).as_ref() {
            if !effort::spend(1 + conjuncts.len() / 4) {
                return;
            }
            arguments.push(*entity);
            self.bind(action, conjuncts, arguments, found);
            arguments.pop();
        }
    }

    /// Grounds a condition and eliminates its quantifiers. Spends [`PART`] units for each node; the result is
    /// meaningless once the budget is exhausted.
    pub(crate) fn formula(&mut self, condition: &Condition, bindings: &mut Bindings) -> Formula {
        if !effort::spend(PART) {
            return Formula::FALSE;
        }
        match condition {
            // Both stop at the first part that decides the value.
            Condition::And(all) => Formula::and(all.iter().map(|part| self.formula(part, bindings))),
            Condition::Or(any) => Formula::or(any.iter().map(|part| self.formula(part, bindings))),
            Condition::Forall(slot, kind, inner) => {
                let parts = self.instances((*slot, *kind), inner, false, bindings);
                Formula::and(parts)
            }
            Condition::Exists(slot, kind, inner) => {
                let parts = self.instances((*slot, *kind), inner, true, bindings);
                Formula::or(parts)
            }
            literal => match (static_value(self.world, literal, bindings), literal) {
                (None, Condition::Atom { atom, holds, .. }) => Formula::Literal(Literal {
                    fact: self.number(ground_atom(atom, bindings)),
                    holds: *holds,
                }),
                (None, Condition::Number(test)) => self.test(test.ground(self.world, bindings)),
                (value, _) => constant(value == Some(true)),
            },
        }
    }

    /// Returns the formula for a requirement on numbers.
    fn test(&mut self, test: GroundTest) -> Formula {
        let known = |test: &GroundTest| test.expressions().all(|own| matches!(own, Arithmetic::Constant(_)));
        if known(&test) {
            return constant(test.holds(&|_| None));
        }
        let (initial, state) = (&mut self.initial, &self.world.state);
        Formula::Literal(self.fluents.literal(test, |test| {
            initial.push(test.holds(&|fluent| state.number(*fluent)));
            (initial.len() - 1) as u32
        }))
    }

    /// Grounds the effects of an action on numbers.
    fn numeric(&mut self, action: &Action, arguments: &[EntityId]) -> Vec<GroundNumericEffect> {
        let mut effects = Vec::new();
        for effect in &action.numeric {
            let mut bindings = arguments.to_vec();
            self.for_all(
                &effect.forall,
                &effect.condition,
                &mut bindings,
                &mut |grounder, condition, bindings| {
                    if effort::spend(effort::KEPT) {
                        let value = effect.value.ground(grounder.world, bindings);
                        effects.push(GroundNumericEffect {
                            condition,
                            variable: grounder.fluents.of_fluent(effect.fluent.ground(bindings)),
                            kind: effect.kind,
                            value: grounder.fluents.expression(&value),
                        });
                    }
                },
            );
        }
        // An assignment comes before others; equal assignments count once, equal increases each for itself.
        effects.sort();
        effects
    }

    /// Calls `done` with the grounded condition for all entities of the slots of `forall` with which it may hold.
    fn for_all(
        &mut self,
        forall: &[(Slot, TypeId)],
        condition: &Condition,
        bindings: &mut Bindings,
        done: &mut dyn FnMut(&mut Self, Formula, &mut Bindings),
    ) {
        let Some(((slot, kind), others)) = forall.split_first() else {
            let condition = self.formula(condition, bindings);
            if !condition.is_false() {
                done(self, condition, bindings);
            }
            return;
        };
        debug_assert_eq!(*slot, bindings.len());
        for entity in self.things((*slot, *kind), condition, true, bindings).as_ref() {
            if !effort::spend(1) {
                return;
            }
            bindings.push(*entity);
            self.for_all(others, condition, bindings, done);
            bindings.pop();
        }
    }

    /// Grounds the condition for each entity with which it may have the value; other entities do not affect the result.
    fn instances(
        &mut self,
        (slot, kind): (Slot, TypeId),
        inner: &Condition,
        value: bool,
        bindings: &mut Bindings,
    ) -> Vec<Formula> {
        let mut parts = Vec::new();
        for entity in self.things((slot, kind), inner, value, bindings).as_ref() {
            if effort::is_exhausted() {
                break;
            }
            bindings.push(*entity);
            parts.push(self.formula(inner, bindings));
            bindings.pop();
        }
        parts
    }

    /// Returns the entities of a type with which a condition may have the value.
    fn things(
        &self,
        (slot, kind): (Slot, TypeId),
        condition: &Condition,
        value: bool,
        bindings: &mut Bindings,
    ) -> Cow<'a, [EntityId]> {
        let (domain, world) = (self.domain, self.world);
        // Facts that an action may change must not narrow the choice, since they may hold later.
        let unchanging = |atom: &Atom, at: When| at != When::Now || !domain.words(atom.predicate).fluent;
        let moment = Moment {
            world,
            state: &world.state,
        };
        match ever_candidates(moment, (slot, kind), condition, value, bindings, &unchanging) {
            Some(mut things) => {
                things.retain(|thing| self.scope.contains(*thing));
                Cow::Owned(things)
            }
            None => Cow::Borrowed(self.scope.of_kind(kind)),
        }
    }

    fn effects(&mut self, action: &Action, arguments: &[EntityId]) -> Vec<GroundEffect> {
        let mut effects = Vec::new();
        for effect in &action.effects {
            let mut bindings = arguments.to_vec();
            self.for_all(
                &effect.forall,
                &effect.condition,
                &mut bindings,
                &mut |grounder, condition, bindings| {
                    let fact = ground_atom(&effect.atom, bindings);
                    if effect.adds {
                        effects.extend(grounder.copied(&condition, fact));
                    }
                    let fact = grounder.number(fact);
                    effects.push(GroundEffect {
                        condition,
                        literal: Literal {
                            fact,
                            holds: effect.adds,
                        },
                        may: false,
                    });
                },
            );
        }
        // A fact that is both deleted and added under one condition holds afterwards.
        let adds = effects.iter().filter(|e| e.literal.holds);
        let always = Formula::TRUE;
        let added: FxHashSet<(u32, &Formula)> = adds.map(|e| (e.literal.fact, &e.condition)).collect();
        let counting = effects.iter().map(|e| {
            let is_added = |condition| added.contains(&(e.literal.fact, condition));
            e.literal.holds || !(is_added(&always) || is_added(&e.condition))
        });
        let mut counting = counting.collect::<Vec<bool>>().into_iter();
        effects.retain(|_| counting.next().unwrap_or(true));
        effects.sort();
        effects.dedup();
        effects
    }
}

fn constant(value: bool) -> Formula {
    if value { Formula::TRUE } else { Formula::FALSE }
}
