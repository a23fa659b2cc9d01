//! Rules that are broken, and rules that are set aside.

use super::Purpose;
use crate::model::{
    Bindings, Condition, Domain, EntityId, Rule, RuleTime, State, Term, Wanted, World, broken_bindings,
};

/// A rule that is set aside for whatever an entity is part of, because the goal asks for the opposite.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Waiver {
    /// The rule's place in the domain's list.
    pub rule: usize,
    /// The entity that the goal speaks of.
    pub entity: EntityId,
}

impl Waiver {
    fn covers(&self, rule: usize, bindings: &[EntityId]) -> bool {
        self.rule == rule && (bindings.is_empty() || bindings.contains(&self.entity))
    }
}

/// Returns whether a step from one state to another breaks a rule for every state that held before it.
pub(super) fn breaks_a_rule(domain: &Domain, world: &World, before: &State, after: &State) -> bool {
    let mut always = domain.rules.iter().filter(|rule| rule.time == RuleTime::Always);
    always.any(|rule| {
        let broken = broken_bindings(rule, world, after);
        !broken.is_empty() && {
            let known = broken_bindings(rule, world, before);
            broken.iter().any(|bindings| known.binary_search(bindings).is_err())
        }
    })
}

/// How many rules for the end a state breaks, each counted for every choice of entities.
pub(super) fn broken_rules_at_end(domain: &Domain, world: &World, state: &State) -> usize {
    let at_end = domain.rules.iter().filter(|rule| rule.time == RuleTime::End);
    at_end.map(|rule| broken_bindings(rule, world, state).len()).sum()
}

/// A rule that is broken in the last state of a plan.
pub(crate) struct Broken {
    /// The rule's place in the domain's list.
    pub(crate) rule: usize,
    /// The entities for which it is.
    pub(crate) bindings: Bindings,
    /// Whether the plan has to keep it; it is only remarked on otherwise.
    pub(crate) binds: bool,
}

/// The rules that are broken in a last state and that the purpose does not set aside, in the domain's order.
pub(crate) fn broken_at_end<'a>(
    domain: &'a Domain,
    world: &'a World,
    state: &'a State,
    purpose: &'a Purpose,
) -> impl Iterator<Item = Broken> + 'a {
    let rules = domain.rules.iter().enumerate();
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

/// What the rules ask of the last state of a plan; those for tidiness only if it is made from a goal.
pub(crate) fn wanted_at_end(domain: &Domain, waivers: &[Waiver], from_goal: bool) -> Vec<Wanted> {
    let at_end = |rule: &Rule| rule.time == RuleTime::End || (from_goal && rule.time == RuleTime::Tidy);
    let rules = domain.rules.iter().enumerate().filter(|(_, rule)| at_end(rule));
    rules
        .map(|(number, rule)| {
            let waived = waivers.iter().filter(|waiver| waiver.rule == number);
            let mut rule = rule.clone();
            // For what is waived the rule says nothing; one without variables says nothing at all.
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
