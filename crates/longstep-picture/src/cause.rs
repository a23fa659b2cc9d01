//! Causal links of a plan: what each step is needed for.
//!
//! A causal link leads from a step that changes a fact or a number to what rests on it: the precondition of a later step, a
//! condition of the plan, the goal, or a rule for the final state (Tate, 1977; McAllester and Rosenblitt, 1991). A condition
//! that holds for several reasons rests on the one with the fewest facts that steps have changed.

use std::collections::BTreeSet;

use longstep_core::effort;
use longstep_core::model::{
    Bindings, Change, Changes, Condition, Effect, EntityId, Fact, Moment, Rule, RuleTime, State, StateVariable, Wanted,
    World, broken_bindings, ground, holds, rests_on, support, unify,
};
use longstep_core::plan::{Node, Plan, StepId, tree};
use longstep_core::verify::{Milestone, Purpose, VerifiedPlan};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::walk::{Follower, Visit, walk};

/// The use of a change, the most telling one first.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Use {
    /// It achieves the goal with this index.
    Goal(usize),
    /// It achieves a condition that need not last.
    Stage,
    /// A later step needs it.
    Step(StepId, String),
    /// A condition of the plan looks at it.
    Test(String),
    /// It keeps a rule of the domain for the final state, with the entities of its variables.
    Rule(usize, Bindings),
    /// It lasts to the end of a plan that has no goal.
    End(String),
}

/// The changes, uses and assumptions of one step.
#[derive(Debug, Clone, Default)]
pub(crate) struct Role {
    /// The changes on the first path that reaches the step; none for a step that no path reaches.
    pub(crate) changes: Option<Changes>,
    /// The uses, without repetition.
    pub(crate) uses: BTreeSet<Use>,
    /// Assumed facts that the precondition rests on.
    pub(crate) assumed: BTreeSet<Fact>,
}

/// Finds the roles of the steps of a plan, in reading order. Returns none if that takes more work than a verification may.
///
/// Without a purpose, changes that last to the end of the plan count as its goal.
pub(crate) fn roles(plan: &VerifiedPlan, purpose: Option<&Purpose>) -> Option<Vec<Role>> {
    let spent = effort::within(effort::OPERATION, || found(plan, purpose));
    (!spent.exhausted).then_some(spent.result)
}

fn found(plan: &VerifiedPlan, purpose: Option<&Purpose>) -> Vec<Role> {
    let world = plan.world();
    let from_goal = purpose.is_some_and(|purpose| purpose.from_goal);
    let is_final = |rule: &Rule| rule.time == RuleTime::End || from_goal && rule.time == RuleTime::Tidy;
    let rules = world.domain().rules.iter().enumerate();
    let mut links = Links {
        world,
        plan: plan.plan(),
        stages: purpose
            .into_iter()
            .flat_map(|own| own.stages.iter().flatten())
            .collect(),
        rules: rules.filter(|(_, rule)| is_final(rule)).collect(),
        roles: vec![Role::default(); plan.steps().len()],
    };
    let ends = walk(world, plan.plan(), &mut links);
    let wanted = purpose.map_or(&[][..], |purpose| &purpose.wanted);
    for end in &ends {
        for (index, own) in wanted.iter().enumerate() {
            links.achieve(own, &end.state, &end.memory, &Use::Goal(index));
        }
        if purpose.is_none() {
            links.last(&end.state, &end.memory);
        }
    }
    links.sense(plan.plan());
    links.roles
}

/// The steps that last changed each fact and number of a path.
#[derive(Debug, Clone, Default)]
pub(crate) struct Makers(FxHashMap<StateVariable, Vec<StepId>>);

impl Makers {
    fn of(&self, variable: StateVariable) -> &[StepId] {
        self.0.get(&variable).map_or(&[], Vec::as_slice)
    }

    fn weight(&self, variable: StateVariable) -> u32 {
        u32::from(self.0.contains_key(&variable))
    }

    fn record(&mut self, step: StepId, changes: &Changes) {
        let facts = changes.facts.iter().map(|change| StateVariable::Fact(change.fact));
        let numbers = changes
            .numbers
            .iter()
            .map(|change| StateVariable::Number(change.fluent));
        for variable in facts.chain(numbers) {
            self.0.insert(variable, vec![step]);
        }
    }
}

struct Links<'a> {
    world: &'a World,
    plan: &'a Plan,
    stages: Vec<&'a Milestone>,
    /// The rules for the final state, with their index.
    rules: Vec<(usize, &'a Rule)>,
    roles: Vec<Role>,
}

impl Links<'_> {
    /// Adds a use to the steps that made a variable what it is.
    fn link(&mut self, makers: &Makers, variable: StateVariable, used: &Use) {
        for step in makers.of(variable) {
            self.roles[step.index()].uses.insert(used.clone());
        }
    }

    /// Adds the use of a step to those that its conditions rest on.
    fn need(&mut self, visit: &Visit<'_>, condition: &Condition, bindings: &mut Bindings, makers: &Makers) {
        let moment = Moment {
            world: self.world,
            state: visit.before,
        };
        let rests = support(moment, condition, bindings, &|variable| makers.weight(variable));
        for variable in rests.unwrap_or_default() {
            let sentence = variable.sentence(self.world, visit.before);
            self.link(makers, variable, &Use::Step(visit.step, sentence));
        }
    }

    /// Adds the use of a step to those that made its changes possible: the conditions of its effects.
    fn need_for_effects(&mut self, visit: &Visit<'_>, makers: &Makers) {
        let step = self.plan.step(visit.step);
        let effects = &self.world.domain().action(step.action).effects;
        let conditional = effects.iter().filter(|effect| effect.condition != Condition::TRUE);
        for effect in conditional {
            for change in visit.changes.facts.iter().filter(|change| change.holds == effect.adds) {
                let Some(mut bindings) = bound(effect, *change, &step.arguments) else {
                    continue;
                };
                self.need(visit, &effect.condition, &mut bindings, makers);
            }
        }
    }

    /// Adds a use to the steps that a condition rests on in a state.
    fn achieve(&mut self, wanted: &Wanted, state: &State, makers: &Makers, used: &Use) {
        let moment = Moment {
            world: self.world,
            state,
        };
        let mut bindings = wanted.bindings.clone();
        let rests = support(moment, &wanted.condition, &mut bindings, &|variable| {
            makers.weight(variable)
        });
        for variable in rests.unwrap_or_default() {
            self.link(makers, variable, used);
        }
    }

    /// Adds the use of achieving what need not last, to the steps behind it.
    fn achieve_stages(&mut self, visit: &Visit<'_>, makers: &Makers) {
        for own in self.stages.clone() {
            let is_met = |state| {
                let moment = Moment {
                    world: self.world,
                    state,
                };
                holds(moment, &own.wanted.condition, &mut own.wanted.bindings.clone())
            };
            if !is_met(visit.before) && is_met(visit.after) {
                self.achieve(&own.wanted, visit.after, makers, &Use::Stage);
            }
        }
    }

    /// Adds the rules for the final state that the step ends the violation of.
    fn keep_rules(&mut self, visit: &Visit<'_>) {
        let mut kept = Vec::new();
        for (number, rule) in &self.rules {
            let [before, after] = [visit.before, visit.after].map(|state| broken_bindings(rule, self.world, state));
            let ended = before.into_iter().filter(|bindings| !after.contains(bindings));
            kept.extend(ended.map(|bindings| Use::Rule(*number, bindings)));
        }
        self.roles[visit.step.index()].uses.extend(kept);
    }

    /// Adds the changes that last to the end of a path, as an environment can say them.
    fn last(&mut self, state: &State, makers: &Makers) {
        let domain = self.world.domain();
        let differences = longstep_core::model::differences(domain, &self.world.state, state);
        for fact in differences.iter().filter(|own| own.now_holds).map(|own| own.fact) {
            let variable = StateVariable::Fact(fact);
            self.link(makers, variable, &Use::End(variable.sentence(self.world, state)));
        }
    }

    /// Adds the use of sensing steps that are conditions themselves.
    fn sense(&mut self, plan: &Plan) {
        for condition in tree::iter(plan.body()).filter_map(Node::condition) {
            for step in condition.steps() {
                self.roles[step.index()].uses.insert(Use::Test(String::new()));
            }
        }
    }

    fn assume(&mut self, visit: &Visit<'_>, condition: &Condition, bindings: &mut Bindings, makers: &Makers) {
        let moment = Moment {
            world: self.world,
            state: visit.before,
        };
        let touched = |fact: Fact| makers.weight(StateVariable::Fact(fact)) > 0;
        let mut rested = FxHashSet::default();
        rests_on(moment, condition, bindings, &touched, &mut rested);
        self.roles[visit.step.index()].assumed.extend(rested);
    }
}

/// Returns the arguments of a step with the entities of an effect's quantified variables; none if the effect does not make
/// the change.
fn bound(effect: &Effect, change: Change, arguments: &[EntityId]) -> Option<Bindings> {
    let slots = arguments.len() + effect.forall.len();
    let mut bound: Vec<Option<EntityId>> = arguments.iter().copied().map(Some).collect();
    bound.resize(slots, None);
    if effect.atom.predicate != change.fact.predicate() || !unify(&effect.atom, change.fact, &mut bound) {
        return None;
    }
    let bindings = bound.into_iter().collect::<Option<Bindings>>()?;
    (ground(&effect.atom, &bindings) == change.fact).then_some(bindings)
}

impl Follower for Links<'_> {
    type Memory = Makers;

    fn visit(&mut self, visit: &Visit<'_>, makers: &mut Makers) {
        let step = self.plan.step(visit.step);
        let precondition = &self.world.domain().action(step.action).precondition;
        let mut bindings = step.arguments.clone();
        self.need(visit, precondition, &mut bindings, makers);
        self.assume(visit, precondition, &mut bindings, makers);
        self.need_for_effects(visit, makers);
        let role = &mut self.roles[visit.step.index()];
        role.changes.get_or_insert_with(|| visit.changes.clone());
        makers.record(visit.step, visit.changes);
        self.achieve_stages(visit, makers);
        self.keep_rules(visit);
    }

    fn test(&mut self, fact: Fact, state: &State, makers: &Makers) {
        let variable = StateVariable::Fact(fact);
        self.link(makers, variable, &Use::Test(variable.sentence(self.world, state)));
    }

    fn join(&mut self, makers: &mut Makers, other: Makers) {
        for (variable, steps) in other.0 {
            let own = makers.0.entry(variable).or_default();
            own.extend(steps);
            own.sort_unstable();
            own.dedup();
        }
    }
}
