//! Where the robot is, and which of two opposite states a thing is in: actions after which it is two of them, or none.
//!
//! A domain with one robot often has no parameter for it: `(at ?place)` of one place, and `(at-dock ?dock)`. Actions that go
//! somewhere make the new place true and all others false.

use super::Rules;
use super::action_facts::{ActionFacts, is_certain, is_quantified};
use super::lasting::begins_with_argument;
use crate::lint::notation::{shown, shown_term};
use crate::lint::{Finding, Lint};
use longstep::domain::{Atom, Effect, PredicateId};

/// An action that goes somewhere.
struct Mover {
    /// The index of the action.
    action: usize,
    /// The predicate that is true of the new place.
    to: PredicateId,
    /// The predicates that are true of no entity afterwards, but for the new place.
    leaves: Vec<PredicateId>,
}

/// Reports actions after which the robot is at two places, or at none.
pub(super) fn lost_robots(rules: &Rules<'_>, findings: &mut Vec<Finding>) {
    let movers = movers(rules);
    for mover in &movers {
        let facts = &rules.actions[mover.action];
        for other in &movers {
            let place = other.to;
            let is_exclusive = other.leaves.contains(&mover.to) && other.leaves.contains(&place);
            // A place in a room needs the room, and does not leave it.
            let is_within = facts
                .action
                .precondition
                .atoms()
                .any(|(atom, _)| atom.predicate == place);
            if !is_exclusive || is_within || mover.to == place || removes_some(facts, place) {
                continue;
            }
            let name = |predicate: PredicateId| &rules.domain.predicate(predicate).name;
            let (own, there, action) = (name(mover.to), name(place), facts.name());
            let message = format!(
                "after the action `{action}`, `{own}` and `{there}` can both be true, but `{}` makes all `{own}` false",
                rules.actions[other.action].name()
            );
            let hint = format!(
                "let the effect of `{action}` make all `{there}` false: `(forall (?x ...) (not ({there} ?x)))`"
            );
            rules.report(findings, Lint::ConflictingFacts, action, there, message, hint);
        }
    }
    for facts in &rules.actions {
        let removed = facts
            .action
            .effects
            .iter()
            .filter(|effect| !effect.adds && is_certain(effect));
        for effect in removed {
            let place = effect.atom.predicate;
            let is_place = movers
                .iter()
                .any(|mover| mover.to == place && mover.leaves.contains(&place));
            let named = facts.needs.contains(&&effect.atom);
            let mut gained = facts.action.effects.iter().filter(|own| own.adds);
            if !is_place || !named || gained.any(|own| is_robots(rules, own.atom.predicate)) {
                continue;
            }
            let (action, predicate) = (facts.name(), &rules.domain.predicate(place).name);
            let message = format!(
                "the action `{action}` makes `{}` false, and says nothing about where the robot is then",
                shown(rules.domain, &effect.atom, &facts.action.parameters)
            );
            let hint = format!("take it out of the effect of `{action}`, or add where the robot is afterwards");
            rules.report(findings, Lint::VanishedObject, action, predicate, message, hint);
        }
    }
}

/// Returns true if a fact may say where the robot is: its sentence begins with words, not with a thing.
fn is_robots(rules: &Rules<'_>, predicate: PredicateId) -> bool {
    !begins_with_argument(rules.domain, predicate)
}

fn movers(rules: &Rules<'_>) -> Vec<Mover> {
    let mut movers = Vec::new();
    for (index, facts) in rules.actions.iter().enumerate() {
        let leaves: Vec<PredicateId> = facts
            .action
            .effects
            .iter()
            .filter(|effect| !effect.adds && is_of_all(effect))
            .map(|effect| effect.atom.predicate)
            .collect();
        for to in facts
            .adds
            .iter()
            .filter(|atom| atom.terms.len() == 1 && rules.is_state(atom.predicate))
        {
            if is_robots(rules, to.predicate) && leaves.contains(&to.predicate) {
                movers.push(Mover {
                    action: index,
                    to: to.predicate,
                    leaves: leaves.clone(),
                });
            }
        }
    }
    movers
}

/// Returns true for an effect on all facts of a predicate.
fn is_of_all(effect: &Effect) -> bool {
    !effect.forall.is_empty() && effect.atom.terms.iter().all(|term| is_quantified(effect, *term))
}

fn removes_some(facts: &ActionFacts<'_>, predicate: PredicateId) -> bool {
    facts
        .action
        .effects
        .iter()
        .any(|effect| !effect.adds && effect.atom.predicate == predicate)
}

/// Reports actions that end a state of a thing and leave it in none, where all actions that bring the state or its opposite about
/// need one of the two: `open` needs closed, `close` needs open, and `spin` ends closed.
pub(super) fn lost_states(rules: &Rules<'_>, findings: &mut Vec<Finding>) {
    let mut found = Vec::new();
    for facts in &rules.actions {
        for lost in facts
            .needs
            .iter()
            .filter(|atom| atom.terms.len() == 1 && facts.removes(atom))
        {
            if facts.adds_about(lost.terms[0]) || !rules.is_state(lost.predicate) {
                continue;
            }
            if let Some(opposite) = opposite_of(rules, lost.predicate) {
                found.push((facts, *lost, opposite));
            }
        }
    }
    for (facts, lost, opposite) in found {
        let (name, parameters) = (facts.name(), &facts.action.parameters);
        let opposite = &rules.domain.predicate(opposite).name;
        let predicate = &rules.domain.predicate(lost.predicate).name;
        let entity = shown_term(rules.domain, lost.terms[0], parameters);
        let message = format!(
            "after the action `{name}`, neither `{predicate}` nor `{opposite}` is true of `{entity}`, and no action makes one of them true again"
        );
        let hint = format!(
            "take `(not {})` out of the effect of `{name}`, or add the other state",
            shown(rules.domain, lost, parameters)
        );
        rules.report(findings, Lint::VanishedObject, name, predicate, message, hint);
    }
}

/// Returns the predicate for which actions exchange this one, in both directions, and without which no action brings one of the two
/// about.
fn opposite_of(rules: &Rules<'_>, predicate: PredicateId) -> Option<PredicateId> {
    let exchanges = |facts: &ActionFacts<'_>, from: PredicateId, to: PredicateId| {
        let mut lost = facts
            .needs
            .iter()
            .filter(|atom| atom.predicate == from && facts.removes(atom));
        lost.any(|lost| {
            facts
                .adds
                .iter()
                .any(|gained| gained.predicate == to && gained.terms == lost.terms)
        })
    };
    let gained = rules
        .actions
        .iter()
        .flat_map(|facts| facts.adds.iter().map(|atom| atom.predicate));
    let mut opposites: Vec<PredicateId> = gained.filter(|own| *own != predicate).collect();
    opposites.dedup();
    opposites.into_iter().find(|opposite| {
        let brings = |atom: &&&Atom| atom.predicate == predicate || atom.predicate == *opposite;
        let mut both = [(predicate, *opposite), (*opposite, predicate)].into_iter();
        both.all(|(from, to)| rules.actions.iter().any(|facts| exchanges(facts, from, to)))
            && rules.actions.iter().all(|facts| {
                facts.adds.iter().filter(brings).all(|gained| {
                    let mut needs = facts.needs.iter().filter(brings);
                    needs.any(|need| need.terms == gained.terms)
                })
            })
    })
}
