//! From a domain, a world and a goal to the task of a search.

use rustc_hash::{FxHashMap, FxHashSet};

use super::GroundAction;
use super::formula::Formula;
use super::grounder::{Grounder, Meaning};
use super::operator::Operator;
use super::scope::{Requirements, Scope};
use super::target::Target;
use super::task::Task;
use longstep_model::model::{Condition, EntityId, Fact, World};

/// A ground condition.
#[derive(Debug, Clone)]
pub(crate) struct GroundCondition {
    /// The condition; static facts are replaced by their values.
    pub(crate) formula: Formula,
    /// The facts and the requirements on numbers, by their numbers in the literals.
    pub(crate) facts: Vec<Meaning>,
}

/// Grounds a condition under `bindings`; static facts and `initially` atoms are replaced by their values.
pub(crate) fn ground_condition(world: &World, condition: &Condition, bindings: &[EntityId]) -> GroundCondition {
    let scope = Scope::whole(world, &Requirements::default());
    let mut grounder = Grounder::new(world, &scope);
    let formula = grounder.formula(condition, &mut bindings.to_vec());
    GroundCondition {
        formula,
        facts: grounder.facts(),
    }
}

/// Grounds one step; returns the operator and the facts by number.
pub(crate) fn ground_step(world: &World, step: GroundAction) -> (Operator, Vec<Meaning>) {
    let scope = Scope::whole(world, &Requirements::default());
    let mut grounder = Grounder::new(world, &scope);
    let operator = grounder.operator(step);
    (operator, grounder.facts())
}

/// Grounds all actions whose static preconditions hold, without sensing.
pub(super) fn ground(world: &World, scope: &Scope, target: &Target) -> Task {
    ground_with(world, scope, target, false).0
}

/// Grounds like [`ground`], and returns the facts by number; none for auxiliary ones.
pub(super) fn ground_with_facts(world: &World, scope: &Scope, target: &Target) -> (Task, Vec<Option<Fact>>) {
    let (task, numbers) = ground_with(world, scope, target, false);
    let mut facts = vec![None; task.initial.len()];
    for (fact, number) in numbers {
        facts[number as usize] = Some(fact);
    }
    (task, facts)
}

/// Grounds like [`ground`], with an operator for each outcome of a sensing step.
pub(super) fn ground_sensing(world: &World, scope: &Scope, target: &Target) -> Task {
    ground_with(world, scope, target, true).0
}

fn ground_with(world: &World, scope: &Scope, target: &Target, sensing: bool) -> (Task, FxHashMap<Fact, u32>) {
    let mut grounder = Grounder::new(world, scope);
    let (marks, complete) = grounder.stages(&target.stages);
    let goal = Formula::and([grounder.goal(&target.wanted), complete]);
    let always = grounder.always();
    // Among equally short plans, prefer those with entities of the goal: walk to the sink rather than to its tap.
    let mentioned: FxHashSet<EntityId> = target.about().collect();
    let mut operators = grounder.operators(&mentioned);
    if sensing {
        operators.extend(grounder.sensing());
    }
    operators.extend(marks);
    let numbers = std::mem::take(&mut grounder.numbers);
    (grounder.task(operators, goal, always), numbers)
}
