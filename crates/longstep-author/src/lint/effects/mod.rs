//! Lints about wrong effects: an effect too much, an effect that is missing, and effects about the wrong entity.
//!
//! A wrong effect is valid PDDL, so it is found by comparison: with the precondition of its action, and with the effects of
//! the other actions on the same facts.

mod action_facts;
mod exchange;
mod lasting;
#[cfg(test)]
mod tests;
mod whereabouts;

use self::action_facts::ActionFacts;
use self::exchange::Exchanges;
use self::lasting::Required;
use super::notation::shown;
use super::places::Places;
use super::reach::Reach;
use super::{Finding, Lint};
use longstep::domain::{Condition, Domain, Effect, PredicateId, Term, TypeId};
use longstep_core::model::{Arithmetic, Comparison, NumberChangeKind, NumberTest};

/// The rules' view of a domain.
struct Rules<'a> {
    domain: &'a Domain,
    reach: &'a Reach<'a>,
    places: &'a Places<'a>,
    actions: Vec<ActionFacts<'a>>,
}

pub(super) fn findings(domain: &Domain, reach: &Reach<'_>, places: &Places<'_>) -> Vec<Finding> {
    let possible = domain
        .actions
        .iter()
        .enumerate()
        .filter(|(index, _)| reach.action(*index).is_none());
    let rules = Rules {
        domain,
        reach,
        places,
        actions: possible.map(|(_, action)| ActionFacts::of(action)).collect(),
    };
    let mut findings = Vec::new();
    let exchanges = Exchanges::of(&rules);
    exchange::conflicting_facts(&rules, &exchanges, &mut findings);
    exchange::swapped_arguments(&rules, &exchanges, &mut findings);
    exchange::vanished_objects(&rules, &exchanges, &mut findings);
    whereabouts::lost_robots(&rules, &mut findings);
    whereabouts::lost_states(&rules, &mut findings);
    lasting::lost_facts(&rules, &Required::of(domain), &mut findings);
    let conflicts: Vec<Option<String>> = findings.iter().map(|own| own.of.last().cloned()).collect();
    lasting::permanent_facts(&rules, &mut findings);
    // A fact that conflicts with another one has its finding.
    findings.retain(|own| own.lint != Lint::PermanentFact || !conflicts.contains(&own.of.last().cloned()));
    idle_effects(&rules, &mut findings);
    effects_on_all(&rules, &mut findings);
    wrong_directions(&rules, &mut findings);
    findings
}

impl<'a> Rules<'a> {
    /// Adds a finding about an effect of an action.
    fn report(
        &self,
        findings: &mut Vec<Finding>,
        lint: Lint,
        action: &str,
        changed: &str,
        message: String,
        hint: String,
    ) {
        let of = [action, changed];
        if !findings.iter().any(|own| own.lint == lint && own.of == of) {
            let place = self.places.within_action(action, ":effect", changed);
            findings.push(Finding::new(lint, &of, place, message, hint));
        }
    }

    /// Returns true for a predicate that describes the state and that actions change: no event, no outcome of sensing.
    fn is_state(&self, predicate: PredicateId) -> bool {
        let words = self.domain.words(predicate);
        words.fluent && !words.event && !self.domain.is_sensed(predicate)
    }

    /// Returns true if an action makes the predicate true (`adds`) or false.
    fn changes(&self, predicate: PredicateId, adds: bool) -> bool {
        let mut effects = self.domain.actions.iter().flat_map(|action| &action.effects);
        effects.any(|effect| effect.atom.predicate == predicate && effect.adds == adds)
    }

    /// Returns true for a type of places: entities that stay, if the domain separates them from those that move.
    fn is_place(&self, kind: TypeId) -> bool {
        let environment = &self.domain.environment;
        let types = &self.domain.types;
        let apart =
            !types.is_a(environment.object, environment.asset) && !types.is_a(environment.asset, environment.object);
        apart && types.is_a(kind, environment.asset)
    }

    /// Returns the actions that make the predicate true.
    fn adding(&self, predicate: PredicateId) -> Vec<&ActionFacts<'a>> {
        let adds = |effect: &Effect| effect.adds && effect.atom.predicate == predicate;
        let all = self.actions.iter();
        all.filter(|facts| facts.action.effects.iter().any(adds)).collect()
    }

    /// Returns up to three actions that need the predicate to be true or false.
    fn needing(&self, predicate: PredicateId, holds: bool) -> Vec<&'a str> {
        let needs = |facts: &&ActionFacts<'a>| {
            let literals = if holds { &facts.needs } else { &facts.excludes };
            literals.iter().any(|atom| atom.predicate == predicate)
        };
        self.actions
            .iter()
            .filter(needs)
            .map(ActionFacts::name)
            .take(3)
            .collect()
    }
}

/// Reports an effect that the precondition implies.
fn idle_effects(rules: &Rules<'_>, findings: &mut Vec<Finding>) {
    let mut found = Vec::new();
    for (index, facts) in rules.actions.iter().enumerate() {
        for effect in facts
            .action
            .effects
            .iter()
            .filter(|effect| action_facts::is_certain(effect))
        {
            let (known, opposite) = if effect.adds {
                (&facts.needs, facts.removes(&effect.atom))
            } else {
                (&facts.excludes, facts.makes(&effect.atom))
            };
            if known.contains(&&effect.atom) && !opposite {
                found.push((index, effect));
            }
        }
    }
    for (index, effect) in found {
        let facts = &rules.actions[index];
        let name = facts.name();
        let text = shown(rules.domain, &effect.atom, &facts.action.parameters);
        let predicate = rules.domain.predicate(effect.atom.predicate).name.as_str();
        let (value, other) = if effect.adds {
            ("true", "false")
        } else {
            ("false", "true")
        };
        let message =
            format!("the action `{name}` makes `{text}` {value}, but it needs that before, so nothing changes");
        let hint = format!(
            "write the fact that is different after `{name}` (is `{predicate}` {other} then, or another argument meant?), or take the effect out"
        );
        rules.report(findings, Lint::IdleEffect, name, predicate, message, hint);
    }
}

/// Reports an effect that makes a fact true of all entities of a type, in an action that is about one of them.
fn effects_on_all(rules: &Rules<'_>, findings: &mut Vec<Finding>) {
    let mut found = Vec::new();
    for (index, facts) in rules.actions.iter().enumerate() {
        let of_all = |effect: &&Effect| effect.adds && !effect.forall.is_empty() && effect.condition == Condition::TRUE;
        for effect in facts.action.effects.iter().filter(of_all) {
            let quantified = |slot: usize| {
                effect
                    .forall
                    .iter()
                    .find(|(own, _)| *own == slot)
                    .map(|(_, kind)| *kind)
            };
            let named = facts.parameters_of(&effect.atom);
            let kinds: Vec<_> = effect
                .atom
                .terms
                .iter()
                .filter_map(|term| match term {
                    Term::Variable(slot) => quantified(*slot),
                    Term::Constant(_) => None,
                })
                .collect();
            let parameters = facts.action.parameters.iter().enumerate();
            let mut own = parameters.filter(|(slot, own)| !named.contains(slot) && kinds.contains(&own.kind));
            if let Some((_, parameter)) = own.next() {
                found.push((index, effect.atom.predicate, parameter.name.clone()));
            }
        }
    }
    for (index, predicate, parameter) in found {
        let name = rules.actions[index].name();
        let predicate = rules.domain.predicate(predicate).name.as_str();
        let message =
            format!("the action `{name}` makes `{predicate}` true of all, although it is about one `?{parameter}`");
        let hint =
            format!("write `?{parameter}` in the effect of `{name}` in place of the `forall`, unless all are meant");
        rules.report(findings, Lint::EffectOnAll, name, predicate, message, hint);
    }
}

/// Reports a number that an action changes away from the limit of its own precondition.
fn wrong_directions(rules: &Rules<'_>, findings: &mut Vec<Finding>) {
    let mut found = Vec::new();
    for (index, facts) in rules.actions.iter().enumerate() {
        for effect in &facts.action.numeric {
            let guards = facts.action.precondition.conjuncts().filter_map(|part| match part {
                Condition::Number(NumberTest::Compare(Arithmetic::Value(own), comparison, Arithmetic::Constant(_)))
                    if *own == effect.fluent =>
                {
                    Some(*comparison)
                }
                _ => None,
            });
            let guards: Vec<Comparison> = guards.collect();
            let is_wrong = |guard: &Comparison| match effect.kind {
                NumberChangeKind::Increase => matches!(guard, Comparison::AtLeast | Comparison::Greater),
                NumberChangeKind::Decrease => matches!(guard, Comparison::AtMost | Comparison::Less),
                NumberChangeKind::Assign => false,
            };
            if !guards.is_empty() && guards.iter().all(is_wrong) {
                found.push((index, effect));
            }
        }
    }
    for (index, effect) in found {
        let name = rules.actions[index].name();
        let function = rules.domain.function(effect.fluent.function).name.as_str();
        let (does, limit, other) = match effect.kind {
            NumberChangeKind::Increase => ("increases", "least", "decrease"),
            _ => ("decreases", "most", "increase"),
        };
        let message =
            format!("the action `{name}` {does} `{function}`, but its precondition limits it to at {limit} a number");
        let hint =
            format!("write `{other}` in the effect of `{name}`, or turn the comparison in its precondition round");
        rules.report(findings, Lint::WrongDirection, name, function, message, hint);
    }
}
