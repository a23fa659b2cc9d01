//! Facts that actions exchange for each other, and the action that does not.
//!
//! `pick` needs `(on ?box ?shelf)`, makes it false and makes `(holding ?box)` true: it exchanges one fact about the box for
//! another. An action that needs the second fact, makes the first one true and keeps both contradicts `pick`. These are the
//! invariants of planners, looked for in the exception instead of the rule.

use super::Rules;
use super::action_facts::ActionFacts;
use crate::lint::notation::{shown, shown_term};
use crate::lint::{Finding, Lint, quoted};
use longstep::domain::{Atom, PredicateId, Term};

/// A predicate and the position of the entity that keeps its place in the exchange; none for a fact without arguments.
pub(super) type Role = (PredicateId, Option<usize>);

/// One fact of an action for another one about the same entity.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Exchange {
    /// The index of the action.
    action: usize,
    lost: Role,
    gained: Role,
}

/// All exchanges of a domain.
pub(super) struct Exchanges(Vec<Exchange>);

impl Exchanges {
    pub(super) fn of(rules: &Rules<'_>) -> Self {
        let mut all = Vec::new();
        for (index, facts) in rules.actions.iter().enumerate() {
            let pairs = pairs(rules, facts);
            for (lost, gained) in &pairs {
                let exchange = |(lost, gained)| Exchange {
                    action: index,
                    lost,
                    gained,
                };
                all.extend(common_roles(lost, gained).into_iter().map(exchange));
            }
        }
        Self(all)
    }

    /// Returns the other actions that exchange one role for the other, in either direction.
    fn between(&self, left: Role, right: Role, but: usize) -> Vec<usize> {
        let is_one = |own: &&Exchange| {
            own.action != but && ((own.lost, own.gained) == (left, right) || (own.gained, own.lost) == (left, right))
        };
        let mut actions: Vec<usize> = self.0.iter().filter(is_one).map(|own| own.action).collect();
        actions.dedup();
        actions
    }

    /// Returns true if the action exchanges the two roles for each other and for nothing else.
    fn is_only(&self, action: usize, left: Role, right: Role) -> bool {
        let own = self.0.iter().filter(|own| own.action == action);
        let mut of_entity = own.filter(|own| [own.lost, own.gained].iter().any(|role| [left, right].contains(role)));
        of_entity.all(|own| {
            [(left, right), (right, left)].contains(&(own.lost, own.gained)) || own.lost.1.is_none() || left.1.is_none()
        })
    }
}

/// Returns the facts that the action gives up, each with the facts that it makes true instead. A fact that is exchanged for
/// one of its own predicate, such as a place for a place, is exchanged for no other.
fn pairs<'a>(rules: &Rules<'_>, facts: &ActionFacts<'a>) -> Vec<(&'a Atom, &'a Atom)> {
    let is_state = |atom: &&&Atom| rules.is_state(atom.predicate);
    let lost: Vec<&Atom> = facts
        .needs
        .iter()
        .filter(|atom| facts.removes(atom))
        .filter(is_state)
        .copied()
        .collect();
    let gained = facts.adds.iter().filter(|atom| !facts.needs.contains(atom));
    let gained: Vec<&Atom> = gained.filter(is_state).copied().collect();
    let moves = |atom: &Atom, others: &[&Atom]| others.iter().any(|other| other.predicate == atom.predicate);
    let mut pairs = Vec::new();
    for own in &lost {
        for other in &gained {
            if own.predicate == other.predicate || !moves(own, &gained) && !moves(other, &lost) {
                pairs.push((*own, *other));
            }
        }
    }
    pairs
}

/// Returns the roles of each parameter that both atoms name, or of none if one has no arguments.
pub(super) fn common_roles(left: &Atom, right: &Atom) -> Vec<(Role, Role)> {
    if left.terms.is_empty() || right.terms.is_empty() {
        return vec![((left.predicate, None), (right.predicate, None))];
    }
    let mut roles = Vec::new();
    for (i, term) in left.terms.iter().enumerate() {
        for (j, other) in right.terms.iter().enumerate() {
            if term == other && matches!(term, Term::Variable(_)) {
                roles.push(((left.predicate, Some(i)), (right.predicate, Some(j))));
            }
        }
    }
    roles
}

/// Reports an action after which two facts hold that other actions exchange for each other.
pub(super) fn conflicting_facts(rules: &Rules<'_>, exchanges: &Exchanges, findings: &mut Vec<Finding>) {
    let mut found = Vec::new();
    for (index, facts) in rules.actions.iter().enumerate() {
        for kept in facts.needs.iter().filter(|atom| !facts.removes(atom)) {
            let gains = facts.adds.iter().filter(|atom| !facts.needs.contains(atom));
            let conflicts = gains.flat_map(|gained| {
                let roles = common_roles(kept, gained).into_iter();
                roles.map(move |(left, right)| (gained, contradicting(rules, exchanges, index, left, right)))
            });
            let strongest = conflicts.max_by_key(|(_, others)| others.len());
            if let Some((gained, others)) = strongest.filter(|(_, others)| !others.is_empty()) {
                found.push((index, *kept, *gained, others));
            }
        }
    }
    for (index, kept, gained, others) in found {
        let facts = &rules.actions[index];
        let (name, parameters) = (facts.name(), &facts.action.parameters);
        let text = |atom: &Atom| shown(rules.domain, atom, parameters);
        let others: Vec<&str> = others.iter().take(3).map(|own| rules.actions[*own].name()).collect();
        let predicate = rules.domain.predicate(kept.predicate).name.as_str();
        let message = format!(
            "after the action `{name}`, `{}` and `{}` are both true, but {} {} one by the other",
            text(kept),
            text(gained),
            quoted(&others),
            if others.len() == 1 { "replaces" } else { "replace" },
        );
        let hint = format!("add `(not {})` to the effect of `{name}`", text(kept));
        rules.report(findings, Lint::ConflictingFacts, name, predicate, message, hint);
    }
}

/// Returns the actions that exchange the two facts; none if another action treats them as facts that go together.
fn contradicting(rules: &Rules<'_>, exchanges: &Exchanges, index: usize, left: Role, right: Role) -> Vec<usize> {
    let others = exchanges.between(left, right, index);
    let together = |(own, facts): (usize, &ActionFacts<'_>)| {
        let beside = |atom: &&&Atom| atom.predicate == left.0;
        let mut kept = facts.needs.iter().filter(beside);
        own != index
            && kept.any(|first| {
                let needed = facts.needs.iter().filter(|second| *second != first);
                let gained = facts.adds.iter().filter(|_| !facts.removes(first));
                let mut seconds = needed.chain(gained).filter(|second| !facts.removes(second));
                seconds.any(|second| common_roles(first, second).contains(&(left, right)))
            })
    };
    // What is only gained is a record, such as a place that was visited.
    let is_record = !rules.changes(right.0, false);
    let is_clear = others.len() > 1 || others.iter().all(|own| exchanges.is_only(*own, left, right));
    if is_clear && !is_record && !rules.actions.iter().enumerate().any(together) {
        others
    } else {
        Vec::new()
    }
}

/// Reports an action that exchanges facts about an entity at another position than the other actions do.
pub(super) fn swapped_arguments(rules: &Rules<'_>, exchanges: &Exchanges, findings: &mut Vec<Finding>) {
    let mut found: Vec<(usize, Role, usize, Vec<usize>)> = Vec::new();
    for own in &exchanges.0 {
        for (fixed, moved) in [(own.lost, own.gained), (own.gained, own.lost)] {
            let Some(position) = moved.1.filter(|_| fixed.0 != moved.0) else {
                continue;
            };
            if !exchanges.between(fixed, moved, own.action).is_empty() {
                continue;
            }
            let parameters = &rules.domain.predicate(moved.0).parameters;
            let kind = parameters[position].kind;
            let elsewhere = (0..parameters.len()).filter(|other| *other != position && parameters[*other].kind == kind);
            let usual = elsewhere.map(|other| (moved.0, Some(other))).find_map(|role| {
                let others = exchanges.between(fixed, role, own.action);
                let all = exchanges.between(fixed, role, usize::MAX);
                // Of two actions, the one that makes the fact true is wrong.
                let adds = || {
                    rules.actions[own.action]
                        .adds
                        .iter()
                        .any(|atom| atom.predicate == moved.0)
                };
                (all.len() == others.len() && (others.len() > 1 || others.len() == 1 && adds())).then_some(others)
            });
            let seen = found
                .iter()
                .any(|(action, role, ..)| *action == own.action && role.0 == moved.0);
            if let Some(others) = usual.filter(|_| !seen) {
                found.push((own.action, moved, position, others));
            }
        }
    }
    for (index, role, _, others) in found {
        let facts = &rules.actions[index];
        let name = facts.name();
        let own = facts
            .adds
            .iter()
            .chain(&facts.needs)
            .find(|atom| atom.predicate == role.0);
        let Some(atom) = own else { continue };
        let predicate = rules.domain.predicate(role.0).name.as_str();
        let others: Vec<&str> = others.iter().take(3).map(|own| rules.actions[*own].name()).collect();
        let message = format!(
            "the arguments of `{}` in the effect of `{name}` are in another order than in {}",
            shown(rules.domain, atom, &facts.action.parameters),
            quoted(&others)
        );
        let hint =
            format!("exchange the arguments of `{predicate}` in the effect of `{name}`, unless this order is meant");
        rules.report(findings, Lint::SwappedArguments, name, predicate, message, hint);
    }
}

/// Reports an action that takes an entity from its place and says nothing about where it is afterwards.
pub(super) fn vanished_objects(rules: &Rules<'_>, exchanges: &Exchanges, findings: &mut Vec<Finding>) {
    let mut found = Vec::new();
    for (index, facts) in rules.actions.iter().enumerate() {
        for lost in facts
            .needs
            .iter()
            .filter(|atom| facts.removes(atom) && rules.is_state(atom.predicate))
        {
            for (position, term) in lost.terms.iter().enumerate() {
                let role = (lost.predicate, Some(position));
                if facts.adds_about(*term) || !is_movable(rules, facts, *term) || removed_about(facts, *term) > 1 {
                    continue;
                }
                if let Some((other, gained)) = replacement(rules, exchanges, index, role, lost) {
                    found.push((index, *lost, *term, other, gained));
                }
            }
        }
    }
    for (index, lost, term, other, gained) in found {
        let facts = &rules.actions[index];
        let (name, parameters) = (facts.name(), &facts.action.parameters);
        let predicate = rules.domain.predicate(lost.predicate).name.as_str();
        let gained = rules.domain.predicate(gained).name.as_str();
        let entity = shown_term(rules.domain, term, parameters);
        let message = format!(
            "the action `{name}` makes `{}` false and nothing about `{entity}` true, but `{}` replaces one fact about it by another, with `{gained}`",
            shown(rules.domain, lost, parameters),
            rules.actions[other].name(),
        );
        let hint = format!("add to the effect of `{name}` where or how `{entity}` is afterwards");
        rules.report(findings, Lint::VanishedObject, name, predicate, message, hint);
    }
}

/// Returns true for a parameter that may be anywhere: no place.
fn is_movable(rules: &Rules<'_>, facts: &ActionFacts<'_>, term: Term) -> bool {
    let Term::Variable(slot) = term else { return false };
    !rules.is_place(facts.action.parameters[slot].kind)
}

/// Counts the facts about the term that the action makes false. More than one is the end of an entity, such as a finished order.
fn removed_about(facts: &ActionFacts<'_>, term: Term) -> usize {
    facts
        .needs
        .iter()
        .filter(|atom| atom.terms.contains(&term) && facts.removes(atom))
        .count()
}

/// Returns another action that replaces the fact, with the predicate that it makes true instead. Only for a new fact about
/// something that the action at `index` also has among its parameters, or if that action makes nothing true at all.
fn replacement(
    rules: &Rules<'_>,
    exchanges: &Exchanges,
    index: usize,
    role: Role,
    lost: &Atom,
) -> Option<(usize, PredicateId)> {
    let facts = &rules.actions[index];
    if facts.adds.iter().any(|atom| atom.predicate == lost.predicate) {
        return None;
    }
    let makes_nothing = facts.action.numeric.is_empty() && facts.action.effects.iter().all(|effect| !effect.adds);
    let named = facts.parameters_of(lost);
    let others = (0..facts.action.parameters.len()).filter(|slot| !named.contains(slot));
    let others: Vec<_> = others.map(|slot| facts.action.parameters[slot].kind).collect();
    let fits = |gained: &Role| {
        let places = rules.domain.predicate(gained.0).parameters.iter().enumerate();
        let mut places = places.filter(|(position, _)| Some(*position) != gained.1);
        makes_nothing || places.any(|(_, place)| others.iter().any(|kind| rules.reach.overlap(*kind, place.kind)))
    };
    let others = || {
        exchanges
            .0
            .iter()
            .filter(|own| own.action != index && own.lost.0 != own.gained.0)
    };
    let replaces = others().find(|own| own.lost == role && fits(&own.gained));
    let gives_back = || others().find(|own| own.gained == role && makes_nothing);
    let replaced = replaces.map(|own| (own.action, own.gained.0));
    replaced.or_else(|| gives_back().map(|own| (own.action, own.lost.0)))
}
