//! Rule checks and rule waivers.

use super::Purpose;
use longstep_model::model::{
    Bindings, Condition, Domain, EntityId, Rule, RuleTime, State, Term, Wanted, World, broken_bindings,
};

/// A rule suspended for all bindings that contain an entity, because the goal contradicts it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Waiver {
    /// Index of the rule in the domain's list.
    pub rule: usize,
    /// The entity in the goal.
    pub entity: EntityId,
}

impl Waiver {
    fn covers(&self, rule: usize, bindings: &[EntityId]) -> bool {
        self.rule == rule && (bindings.is_empty() || bindings.contains(&self.entity))
    }
}

/// Returns true if the step newly breaks an `always` rule of the domain. Prohibitions do not count: they decide whether
/// a plan may be carried out, not what it means.
pub(super) fn breaks_a_rule(world: &World, before: &State, after: &State) -> bool {
    let mut always = world
        .always_rules()
        .filter(|(number, _)| world.prohibition(*number).is_none());
    always.any(|(_, rule)| {
        let broken = broken_bindings(rule, world, after);
        // Most steps break no rule, so the state before is examined only if one is broken after.
        !broken.is_empty() && {
            let known = broken_bindings(rule, world, before);
            broken.iter().any(|bindings| known.binary_search(bindings).is_err())
        }
    })
}

/// Counts the broken rules for the final state, once for each binding.
pub(super) fn broken_rules_at_end(world: &World, state: &State) -> usize {
    let at_end = world.domain().rules.iter().filter(|rule| rule.time == RuleTime::End);
    at_end.map(|rule| broken_bindings(rule, world, state).len()).sum()
}

/// A rule that is broken in the final state.
#[non_exhaustive]
pub struct Broken {
    /// Index of the rule in the domain's list.
    pub rule: usize,
    /// The entities that the rule is broken for.
    pub bindings: Bindings,
    /// True if the rule is mandatory for the plan; otherwise breaking it is a warning.
    pub binds: bool,
}

/// Returns the rules that are broken in a final state and not waived, in the domain's order.
pub fn broken_at_end<'a>(
    world: &'a World,
    state: &'a State,
    purpose: &'a Purpose,
) -> impl Iterator<Item = Broken> + 'a {
    let rules = world.domain().rules.iter().enumerate();
    let at_end = rules.filter(|(_, rule)| matches!(rule.time, RuleTime::End | RuleTime::Tidy));
    at_end.flat_map(move |(number, rule)| {
        let waived = move |bindings: &Bindings| purpose.waivers.iter().any(|waiver| waiver.covers(number, bindings));
        let broken = broken_bindings(rule, world, state).into_iter();
        broken
            .filter(move |bindings| !waived(bindings))
            .map(move |bindings| Broken {
                rule: number,
                bindings,
                binds: rule.time == RuleTime::End || purpose.from_goal,
            })
    })
}

/// Returns the conditions that the rules impose on the final state; tidiness rules only if the plan is made from a
/// goal.
pub(crate) fn wanted_at_end(domain: &Domain, waivers: &[Waiver], from_goal: bool) -> Vec<Wanted> {
    let at_end = |rule: &Rule| rule.time == RuleTime::End || (from_goal && rule.time == RuleTime::Tidy);
    let rules = domain.rules.iter().enumerate().filter(|(_, rule)| at_end(rule));
    rules
        .map(|(number, rule)| {
            let waived = waivers.iter().filter(|waiver| waiver.rule == number);
            let mut rule = rule.clone();
            // Bindings with a waived entity satisfy the rule; a waived rule without variables is always satisfied.
            let exceptions = waived.flat_map(|waiver| match rule.variables.len() {
                0 => vec![Condition::TRUE],
                variables => (0..variables).map(|slot| is(slot, waiver.entity)).collect(),
            });
            let mut alternatives: Vec<Condition> = exceptions.collect();
            alternatives.push(rule.condition);
            rule.condition = Condition::Or(alternatives);
            Wanted {
                condition: rule.everywhere(),
                bindings: Vec::new(),
            }
        })
        .collect()
}

fn is(slot: usize, entity: EntityId) -> Condition {
    Condition::Equal {
        left: Term::Variable(slot),
        right: Term::Constant(entity),
        holds: true,
    }
}
